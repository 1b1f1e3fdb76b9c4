# SPDX-License-Identifier: Apache-2.0
"""What a kind of bad input is, and how a good input is damaged."""
import dataclasses
import os
import pathlib
import shutil
import typing


@dataclasses.dataclass
class Kind:
    """One kind of bad input.

    The good inputs and older results that `words` and `needs` name by their first folder are copied into a folder of the
    kind's own, which `damage` gets. A refusal ends with 1 or 2 and one message that has all of `says` (regular
    expressions); nothing may change then but `changes`. What is `passed_over` ends with 0, and says so in the messages
    or in the summary; the command may write to `out` then.
    """
    group: str
    name: str
    words: list
    says: list
    damage: typing.Callable = None
    needs: tuple = ()
    changes: tuple = ()         # paths that a refused command may write all the same
    passed_over: bool = False
    unreadable: int = None      # frames_unreadable in the summary
    noise: str = ''             # lines that a decoder writes to stderr by itself, beside the message (a regular expression)
    on_stdout: bool = False     # `check` lists what is wrong with a recording on stdout
    file_limit: int = 0         # bytes that a file can have, as on a disk that gets full; 0: no limit
    as_nobody: bool = False     # the rights of files are put to the test, which root does not feel
    folder_name: str = 'work'   # the folder that the command is run in


def run(*words, out='out'):
    return ['run', *words, '--quiet', '--out', out]


# ---- Damage: each returns a function of the kind's folder ---------------------------------------------------------

def both(*steps):
    def do(folder):
        for step in steps:
            step(folder)
    return do


def write(path, content):
    def do(folder):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content if isinstance(content, bytes) else content.encode())
    return do


def append(path, content):
    def do(folder):
        data = (folder / path).read_bytes()
        (folder / path).write_bytes(data + (content if isinstance(content, bytes) else content.encode()))
    return do


def change(path, function):
    """Replaces the bytes of a file by what the function makes of them."""
    def do(folder):
        (folder / path).write_bytes(function((folder / path).read_bytes()))
    return do


def replace(path, old, new):
    def do(folder):
        text = (folder / path).read_bytes()
        old_bytes = old.encode() if isinstance(old, str) else old
        assert old_bytes in text, f'{path} has no {old}'
        (folder / path).write_bytes(text.replace(old_bytes, new.encode() if isinstance(new, str) else new, 1))
    return do


def line(path, number, text):
    """Replaces one line, counted from 1; None: leaves it out."""
    def do(folder):
        lines = (folder / path).read_text().splitlines()
        lines[number - 1:number] = [] if text is None else [text]
        (folder / path).write_text('\n'.join(lines) + '\n')
    return do


def column(path, row, number, text):
    """Replaces one column of a row, both counted from 1."""
    def do(folder):
        lines = (folder / path).read_text().splitlines()
        parts = lines[row - 1].split(' ')
        parts[number - 1] = text
        lines[row - 1] = ' '.join(parts)
        (folder / path).write_text('\n'.join(lines) + '\n')
    return do


def cut(path, share):
    """share: what is left of the file; from 2 on a number of bytes."""
    return change(path, lambda data: data[:int(share if share >= 2 else share * len(data))])


def patch(path, offset, content):
    return change(path, lambda data: data[:offset] + content + data[offset + len(content):])


def zero(path, begin, end):
    """begin, end: shares of the file."""
    def zeroed(data):
        first, last = int(begin * len(data)), int(end * len(data))
        return data[:first] + bytes(last - first) + data[last:]
    return change(path, zeroed)


def remove(path):
    def do(folder):
        if (folder / path).is_dir():
            shutil.rmtree(folder / path)
        else:
            (folder / path).unlink()
    return do


def _in_place_of(path, make):
    def do(folder):
        if os.path.lexists(folder / path):
            remove(path)(folder)
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        make(folder / path)
    return do


def folder_at(path):
    return _in_place_of(path, lambda place: place.mkdir())


def fifo(path):
    return _in_place_of(path, os.mkfifo)


def link(path, target):
    return _in_place_of(path, lambda place: place.symlink_to(target))


def empty(path):
    return _in_place_of(path, lambda place: place.write_bytes(b''))


def large(path, size):
    """A file with a hole, which takes no room on the disk."""
    def make(place):
        with open(place, 'wb') as file:
            file.truncate(size)
    return _in_place_of(path, make)


def locked(path, mode=0):
    return lambda folder: os.chmod(folder / path, mode)


def rename(path, to):
    def do(folder):
        (folder / to).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).rename(folder / to)
    return do


def copy(path, to):
    def do(folder):
        if os.path.lexists(folder / to):
            remove(to)(folder)
        shutil.copy(folder / path, folder / to)
    return do


def files_like(pattern, step, every=1):
    """Does a step, which makes a damage of a path, to every n-th file that fits."""
    def do(folder):
        for path in sorted(folder.glob(pattern))[::every]:
            step(str(pathlib.Path(path).relative_to(folder)))(folder)
    return do
