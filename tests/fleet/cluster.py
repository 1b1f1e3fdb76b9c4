# SPDX-License-Identifier: Apache-2.0
"""A Slurm cluster on this one machine: munged, slurmctld and several slurmd, each a node with a port of its own.

Debian's slurmd is built for one node a host name, so each node has a host name that is not the machine's and the address
127.0.0.1; nothing outside the cluster's folder is read or written, and only processes that it started are ended.
"""
from __future__ import annotations

import os
import pathlib
import pwd
import secrets
import signal
import socket
import subprocess
import time

CONFIG = """\
ClusterName=covis
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=30
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdPidFile={folder}/%n.pid
SlurmdLogFile={folder}/%n.log
SlurmdSpoolDir={folder}/spool-%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SlurmdParameters=config_overrides
SlurmdTimeout=10
ReturnToService=2
MinJobAge=300
NodeName=node[1-{nodes}] NodeAddr=127.0.0.1 Port=[{first}-{last}] CPUs={cpus} RealMemory={memory}
PartitionName=site Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Cluster:
    """Daemons that run until `stop`; commands of Slurm reach them with `environment`."""

    def __init__(self, folder: pathlib.Path, nodes: int = 4, cpus: int = 2, memory: int = 8000) -> None:
        self.folder = folder
        self.nodes = [f'node{i + 1}' for i in range(nodes)]
        self.running: dict[str, subprocess.Popen[bytes]] = {}
        for name in ['state', *(f'spool-{node}' for node in self.nodes)]:
            (folder / name).mkdir(parents=True, exist_ok=True)
        os.chmod(folder, 0o755)
        key = folder / 'munge.key'
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        config = folder / 'slurm.conf'
        config.write_text(CONFIG.format(
            host=socket.gethostname(), user=pwd.getpwuid(os.getuid()).pw_name, folder=folder, nodes=nodes, port=26817,
            first=26821, last=26820 + nodes, cpus=cpus, memory=memory))
        self.environment = os.environ | {'SLURM_CONF': str(config)}

    def _start(self, name: str, *command: str) -> None:
        with open(self.folder / f'{name}.out', 'ab') as out:
            self.running[name] = subprocess.Popen(command, stdout=out, stderr=out, env=self.environment)

    def start(self) -> None:
        self._start('munged', '/usr/sbin/munged', '--foreground', '--force', f'--socket={self.folder}/munge.socket',
                    f'--key-file={self.folder}/munge.key', f'--pid-file={self.folder}/munged.pid',
                    f'--seed-file={self.folder}/munged.seed', f'--log-file={self.folder}/munged.log')
        self._wait(lambda: (self.folder / 'munge.socket').exists(), 'munged')
        self._start('slurmctld', '/usr/sbin/slurmctld', '-D')
        for node in self.nodes:
            self.start_node(node)
        self._wait(lambda: self.states() == dict.fromkeys(self.nodes, 'idle'), 'the nodes')

    def start_node(self, node: str) -> None:
        self._start(node, '/usr/sbin/slurmd', '-D', '-N', node)

    def command(self, *words: str) -> str:
        return subprocess.run(words, env=self.environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              check=False).stdout

    def states(self) -> dict[str, str]:
        """Each node's state, by sinfo."""
        return {words[0]: words[1] for line in self.command('sinfo', '-hNo', '%N %T').splitlines()
                if len(words := line.split()) == 2}

    def jobs(self) -> list[tuple[str, str, str]]:
        """Running jobs: number, name and node."""
        return [(words[0], words[1], words[2]) for line in self.command('squeue', '-ht', 'R', '-o', '%i %j %N').splitlines()
                if len(words := line.split()) == 3]

    def kill_node(self, node: str) -> None:
        """Ends a node as a power failure does: its daemon, and all that it started, at once."""
        for pid in [self.running[node].pid, *self._processes_of(node)]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.running.pop(node).wait()

    def _processes_of(self, node: str) -> list[int]:
        """Processes of a node's jobs, before them those that watch over a job and would report its end."""
        watching, jobs = [], []
        for entry in pathlib.Path('/proc').glob('[0-9]*'):
            try:
                environment = (entry / 'environ').read_bytes().split(b'\0')
                parent = int((entry / 'stat').read_text().rpartition(')')[2].split()[1])
                if not {f'SLURM_CONF={self.environment["SLURM_CONF"]}'.encode(),
                        f'SLURMD_NODENAME={node}'.encode()} <= set(environment):
                    continue
                jobs.append(int(entry.name))
                if pathlib.Path(f'/proc/{parent}/comm').read_text().startswith('slurmstepd'):
                    watching.append(parent)
            except OSError:  # it has ended meanwhile
                continue
        return watching + jobs

    def _wait(self, done, what: str, seconds: float = 60) -> None:
        end = time.monotonic() + seconds
        while not done():
            if time.monotonic() > end:
                raise RuntimeError(f'{what} did not start in {seconds:.0f} s: see the logs in {self.folder}')
            time.sleep(0.2)

    def stop(self) -> None:
        for node in self.nodes:
            if node in self.running:
                self.kill_node(node)
        for process in self.running.values():
            process.terminate()
        for process in self.running.values():
            process.wait(timeout=20)
        self.running.clear()
