# SPDX-License-Identifier: Apache-2.0
"""The main program of scripts that check the project's files as text."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(check_tree, things, wrong):
    """Checks the folder that the command line names, or the project; returns the exit code. check_tree(root) returns how many `things` it looked at,
    and a message for each that is `wrong`."""
    root = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT
    count, problems = check_tree(root)
    if count == 0:
        print(f'{root}: no {things} found')
        return 1
    for problem in problems:
        print(problem)
    print(f'{count} {things}, {len(problems)} {wrong}')
    return 1 if problems else 0
