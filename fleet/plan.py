# SPDX-License-Identifier: Apache-2.0
"""The manifest of a site, and the plan that follows from it: which recordings are mapped, and which maps are merged when.

The plan is a pure function of the manifest and of the command's bytes. Each job has a key, the hash of all that its result
depends on, so that what is done is found again by its key.
"""
from __future__ import annotations

import concurrent.futures
import dataclasses
import hashlib
import json
import os
import pathlib
from typing import Any

MANIFEST = 'manifest.json'
VOCABULARY = pathlib.Path('vocabulary/default.covis-voc')


class SiteError(Exception):
    """The manifest or a recording is not right; the message says what."""


@dataclasses.dataclass(frozen=True)
class Recording:
    name: str
    path: str
    id: str                        # hash of its content
    bytes: int
    options: tuple[str, ...] = ()  # of covis run, for this recording alone


@dataclasses.dataclass
class Manifest:
    """Recordings in batches: those of one `add` are merged as a balanced tree, and each later batch with the site of before."""
    batches: list[list[Recording]] = dataclasses.field(default_factory=list)
    run_options: list[str] = dataclasses.field(default_factory=lambda: ['--skip-bad'])
    merge_options: list[str] = dataclasses.field(default_factory=list)
    one_truth_frame: bool = False  # the truths of all recordings are poses in one world

    def recordings(self) -> list[Recording]:
        return [recording for batch in self.batches for recording in batch]

    @staticmethod
    def load(site: pathlib.Path) -> Manifest:
        file = site / MANIFEST
        if not file.exists():
            raise SiteError(f'{file}: there is none; fleet/fleet.py add {site} RECORDING… makes it')
        try:
            data = json.loads(file.read_text())
            data['batches'] = [[Recording(**(r | {'options': tuple(r['options'])})) for r in batch]
                               for batch in data['batches']]
            return Manifest(**data)
        except (ValueError, KeyError, TypeError) as error:
            raise SiteError(f'{file}: it is not a manifest: {error}') from error

    def save(self, site: pathlib.Path) -> None:
        write_whole(site / MANIFEST, json.dumps(dataclasses.asdict(self), indent=1) + '\n')


def write_whole(file: pathlib.Path, text: str) -> None:
    """Writes a file whole or not at all, whatever is killed meanwhile."""
    file.parent.mkdir(parents=True, exist_ok=True)
    aside = file.with_name(f'{file.name}.{os.uname().nodename}.{os.getpid()}')
    aside.write_text(text)
    aside.replace(file)


def hash_of(*parts: Any) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:32]


def hash_of_file(file: pathlib.Path) -> str:
    digest = hashlib.sha256()
    with open(file, 'rb') as content:
        while block := content.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def content_of(path: pathlib.Path) -> tuple[str, int]:
    """Hash and size of a recording: of a file, or of all names and files in a folder."""
    if path.is_file():
        return hash_of(hash_of_file(path)), path.stat().st_size
    files = sorted(p for p in path.rglob('*') if p.is_file())
    if not files:
        raise SiteError(f'{path}: there is no such file, and no folder with files')
    with concurrent.futures.ThreadPoolExecutor() as pool:
        hashes = list(pool.map(hash_of_file, files))
    return hash_of([[str(p.relative_to(path)), h] for p, h in zip(files, hashes)]), sum(p.stat().st_size for p in files)


def split_option(word: str) -> tuple[str, str]:
    """What a word of the options begins with, '--camera=' of '--camera=FILE' or nothing, and the rest, which may name a file."""
    name, equals, value = word.partition('=') if word.startswith('--') else ('', '', word)
    return (name + equals, value) if equals else ('', word)


def absolute(word: str) -> str:
    begin, rest = split_option(word)
    return begin + os.path.abspath(rest) if os.path.isfile(rest) else word


def add(site: pathlib.Path, paths: list[str], options: list[str]) -> list[str]:
    """Adds recordings as one batch, all or none. Returns what there is to say."""
    manifest = Manifest.load(site) if (site / MANIFEST).exists() else Manifest()
    options = [absolute(word) for word in options]
    names = {r.name: r for r in manifest.recordings()}
    contents = {(r.id, r.options): r for r in manifest.recordings()}
    batch: list[Recording] = []
    said: list[str] = []
    for text in paths:
        path = pathlib.Path(text).absolute()
        id, size = content_of(path)
        recording = Recording(path.name, str(path), id, size, tuple(options))
        if same := contents.get((id, recording.options)):
            said.append(f'{text}: the same bytes as {same.name}; left out')
            continue
        if recording.name in names:
            raise SiteError(f'{text}: there is another recording of the name {recording.name}, '
                            f'{names[recording.name].path}; give this one another name. Nothing was added')
        names[recording.name] = contents[(id, recording.options)] = recording
        batch.append(recording)
        said.append(f'{recording.name}: {size / 1e6:.1f} MB')
    if batch:
        manifest.batches.append(batch)
    manifest.save(site)
    return said


@dataclasses.dataclass(frozen=True)
class Node:
    """A job: a recording is mapped, or the maps of two nodes are merged."""
    key: str
    recording: Recording | None = None
    inputs: tuple[str, ...] = ()
    recordings: int = 1


@dataclasses.dataclass
class Plan:
    nodes: dict[str, Node]  # those that a node needs come before it
    root: str

    def of_kind(self, merges: bool) -> list[Node]:
        return [node for node in self.nodes.values() if bool(node.inputs) == merges]


def identity_of(covis: pathlib.Path) -> str:
    """The hash of the command and of the vocabulary it uses by default."""
    share = [covis.parent.parent / 'share/covis' / VOCABULARY.name, pathlib.Path(__file__).parent.parent / VOCABULARY]
    files = [covis.resolve(), *(file for file in share if file.exists())]
    return hash_of([hash_of_file(file) for file in files])


def options_hash(options: list[str]) -> list[str]:
    """Options as they count for a result: a file by its content."""
    parts = [split_option(word) for word in options]
    return [begin + (hash_of_file(pathlib.Path(rest)) if os.path.isfile(rest) else rest) for begin, rest in parts]


def plan_of(manifest: Manifest, command: str) -> Plan:
    """The jobs of a site; `command` is the identity of the covis that does them."""
    nodes: dict[str, Node] = {}
    run_options = options_hash(manifest.run_options)
    merge_options = options_hash(manifest.merge_options)

    def leaf(recording: Recording) -> str:
        key = hash_of('map', command, recording.id, run_options, options_hash(list(recording.options)))
        nodes[key] = Node(key, recording)
        return key

    def merge(left: str, right: str) -> str:
        key = hash_of('merge', command, left, right, merge_options)
        nodes[key] = Node(key, None, (left, right), nodes[left].recordings + nodes[right].recordings)
        return key

    def tree(batch: list[Recording]) -> str:
        if len(batch) == 1:
            return leaf(batch[0])
        half = (len(batch) + 1) // 2
        return merge(tree(batch[:half]), tree(batch[half:]))

    root = ''
    for batch in manifest.batches:
        made = tree(batch)
        root = merge(root, made) if root else made
    if not root:
        raise SiteError('the manifest has no recordings')
    return Plan(nodes, root)
