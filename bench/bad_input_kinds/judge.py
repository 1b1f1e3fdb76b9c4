# SPDX-License-Identifier: Apache-2.0
"""Runs the command on one kind of bad input, and says what is wrong with how it took it."""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import stat
import subprocess
import time

MOST_SECONDS = 10         # by the clock; the machine may be shared
MOST_CPU_SECONDS = 2      # beyond what the command takes with good input
LONGEST_MESSAGE = 3000    # bytes on stderr
NOBODY = 65534

# Words of libraries and of the language's run-time; a message is for people.
LEAKS = re.compile(
    r'terminate called|what\(\)|std::|basic_string|bad_alloc|filesystem error|yaml-cpp|YAML::|bad conversion|bad file|nlohmann|json\.exception|'
    r'cv::|OpenCV|\[ ?(?:WARN|ERROR)|libpng|TIFF(?:Read|Fetch|Open|Client|Fill)|JPEG datastream|AddressSanitizer|UndefinedBehavior|LeakSanitizer|'
    r'ThreadSanitizer|runtime error|Segmentation|Assertion|\.cpp:\d|\.hpp:\d|CLI::|boost|vector::|sto[ild]\b|Invalid argument\(s\)|SQL logic|'
    r'ffmpeg|\[\w+ @ 0x')
CONTROL = re.compile(r'[\x00-\x08\x0b-\x1f\x7f]')


class Outcome:
    def __init__(self, code, killed, cpu, out, error):
        self.code, self.killed, self.cpu, self.out, self.error = code, killed, cpu, out, error


def _before_exec(kind):
    def do():
        if kind and kind.file_limit:
            resource.setrlimit(resource.RLIMIT_FSIZE, (kind.file_limit, kind.file_limit))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    return do


def execute(covis, words, folder, logs, kind=None, seconds=MOST_SECONDS):
    """Runs a command in `folder`; its output goes to files in `logs`. stdin is empty."""
    limited = bool(kind and kind.file_limit)  # the messages must have room all the same
    with open(logs / 'stdout', 'wb') as out, open(logs / 'stderr', 'wb') as error:
        person = {'user': NOBODY, 'group': NOBODY, 'extra_groups': []} if kind and kind.as_nobody and os.getuid() == 0 else {}
        process = subprocess.Popen([covis, *words], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE if limited else out,
                                   stderr=subprocess.PIPE if limited else error,
                                   preexec_fn=_before_exec(kind), restore_signals=not limited, **person)
    until, killed = time.monotonic() + seconds, False
    while True:
        ended, status, usage = os.wait4(process.pid, os.WNOHANG)
        if ended:
            break
        if time.monotonic() > until and not killed:
            process.kill()
            killed = True
        time.sleep(0.002)
    process.returncode = os.waitstatus_to_exitcode(status)
    if limited:
        for name, pipe in (('stdout', process.stdout), ('stderr', process.stderr)):
            (logs / name).write_bytes(pipe.read())
            pipe.close()
    return Outcome(process.returncode, killed, usage.ru_utime + usage.ru_stime, (logs / 'stdout').read_bytes(), (logs / 'stderr').read_bytes())


def snapshot(folder):
    """What is in a folder, byte by byte; of what is no regular file, what it is."""
    found = {}
    for root, folders, files in os.walk(folder):
        for name in folders + files:
            path = pathlib.Path(root, name)
            mode = os.lstat(path).st_mode
            key = os.fsencode(path.relative_to(folder))
            if stat.S_ISREG(mode) and os.lstat(path).st_size < 1 << 26:
                found[key] = path.read_bytes()
            else:
                found[key] = (stat.S_IFMT(mode), os.readlink(path) if stat.S_ISLNK(mode) else os.lstat(path).st_size * stat.S_ISREG(mode))
    return found


def changed(before, after, allowed):
    """The names that differ, apart from those beneath `allowed`."""
    names = [os.fsdecode(name) for name in sorted(before.keys() | after.keys()) if before.get(name) != after.get(name)]
    return [name for name in names if not any(name == a or name.startswith(a + '/') for a in allowed)]


def problems_of_crash(kind, outcome):
    found = []
    if outcome.killed:
        found.append(f'it hung: {MOST_SECONDS} s were over')
    elif outcome.code < 0:
        found.append(f'it was ended by signal {-outcome.code}')
    error = outcome.error.decode('utf-8', 'replace')
    if kind.noise:
        error = '\n'.join(line for line in error.split('\n') if not re.search(kind.noise, line))
    if leak := LEAKS.search(outcome.out.decode('utf-8', 'replace') + error):
        found.append(f"'{leak.group()}' leaks through")
    if control := CONTROL.search(error):
        found.append(f'there is a raw control character, {control.group()!r}, in the message')
    if len(outcome.error) > LONGEST_MESSAGE:
        found.append(f'the message has {len(outcome.error)} bytes')
    return found


def messages_of(text):
    """The errors on stderr: lines that say so, or what CLI11 says of wrong usage."""
    lines = [line for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if re.match(r'(\x1b\[\S*?m)?error', line)]
    return errors or [line for line in lines if not re.match(r'info|warning|Run with|frame ', line)][:1]


def problems_of_refusal(kind, outcome):
    found = []
    error = outcome.error.decode('utf-8', 'replace')
    if outcome.code == 0:
        found.append('it was not refused')
    elif outcome.code not in (1, 2) and outcome.code > 0:
        found.append(f'the exit code is {outcome.code}')
    said = outcome.out.decode('utf-8', 'replace') if kind.on_stdout else error
    if not kind.on_stdout and len(messages_of(error)) != 1:
        found.append(f'there are {len(messages_of(error))} messages')
    return found + [f"the message lacks '{wanted}'" for wanted in kind.says if not re.search(wanted, said)]


def problems_of_passing_over(kind, outcome, folder):
    if outcome.code != 0:
        return [f'it was not passed over: the exit code is {outcome.code}']
    said = (outcome.out + outcome.error).decode('utf-8', 'replace')
    summary = folder / 'out/summary.json'
    found = []
    if kind.words[0] == 'run':
        said += summary.read_text()
        count = json.loads(summary.read_text())['frames_unreadable']
        if kind.unreadable is not None and count != kind.unreadable:
            found.append(f'frames_unreadable is {count}, not {kind.unreadable}')
    return found + [f"nothing says '{wanted}'" for wanted in kind.says if not re.search(wanted, said)]


def prepare(kind, good, folder):
    """Lays out the inputs and the older results, and damages what is to be damaged."""
    named = {word.split('=')[-1].split('/')[0] for word in map(os.fsdecode, [*kind.words, *kind.needs])}
    for name in named & set(os.listdir(good)):
        if (good / name).is_dir():
            shutil.copytree(good / name, folder / name)
        else:
            shutil.copy(good / name, folder / name)
    if kind.as_nobody and os.getuid() == 0:
        for path in [folder, *folder.rglob('*')]:
            os.chown(path, NOBODY, NOBODY)
    if kind.damage:
        kind.damage(folder)


def judge(kind, covis, good, work, cpu_of_good):
    """Returns what is wrong, and the outcome."""
    logs, folder = work / 'logs', work / kind.folder_name
    logs.mkdir(parents=True)
    folder.mkdir()
    prepare(kind, good, folder)
    before = snapshot(folder)
    outcome = execute(covis, kind.words, folder, logs, kind)
    if outcome.killed:  # another process may have held up the disk; a hang hangs again
        outcome = execute(covis, kind.words, folder, logs, kind)
    found = problems_of_crash(kind, outcome)
    most = MOST_CPU_SECONDS + cpu_of_good
    if outcome.cpu > most:
        found.append(f'it took {outcome.cpu:.1f} s of processor time, where {most:.1f} s are allowed')
    if kind.passed_over:
        found += problems_of_passing_over(kind, outcome, folder)
    elif not outcome.killed:
        found += problems_of_refusal(kind, outcome)
    differing = changed(before, snapshot(folder), ['out'] if kind.passed_over else kind.changes)
    found += [f'{name}: it has changed' for name in differing]
    found += [f'{os.fsdecode(path)}: a temporary file is left' for path in folder.rglob('*.tmp*')]
    return found, outcome
