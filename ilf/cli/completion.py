"""The scripts with which shells complete commands, options and file names."""

from __future__ import annotations

import argparse
import re

import shtab

_FILE = re.compile(r"BAG|CAMERA|DIR|FILE|FOLDER|FRAME|INPUT|PATH|PRESET|RESULT|SOURCE|\w+\.\w+")
"""Placeholders of arguments that name files or folders."""


def completion_script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the completion script of a parser for a shell."""
    _prepare(parser)
    return str(shtab.complete(parser, shell=shell))


def _prepare(parser: argparse.ArgumentParser) -> None:
    """Describe commands by their one-line help, and complete what names files by files."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                command.description = None
                _prepare(command)
        elif action.choices is None and isinstance(action.metavar, str) and _FILE.fullmatch(action.metavar):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
