# SPDX-License-Identifier: Apache-2.0
import pathlib


def default_vocabulary():
    """The file of the vocabulary that comes with Covis."""
    return str(pathlib.Path(__file__).resolve().parent / 'default.covis-voc')
