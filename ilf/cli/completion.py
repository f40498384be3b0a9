"""`ilf completion`: print scripts for shells to complete commands, options and file names."""

from __future__ import annotations

import argparse
import re

import shtab

from .usage import Parser

SHELLS = ("bash", "zsh", "fish")

_FOLDER = re.compile(r"DIR|FOLDER|BAG")
"""Placeholders of arguments that name folders."""

_FILE = re.compile(r"CAMERA|FILE|FRAME|INPUT|PATH|PRESET|RESULT|SOURCE|\w+\.\w+")
"""Placeholders of arguments that name files, or files as well as folders."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Print the script with which a shell completes commands, options and file names. For bash, add this line to "
        '~/.bashrc: eval "$(ilf completion bash)". For zsh, write the script to a file named _ilf in a folder of '
        "$fpath. For fish, write it to ~/.config/fish/completions/ilf.fish."
    )
    parser.set_defaults(command=run)
    parser.add_argument("shell", choices=SHELLS)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    from .commands import build_parser

    parser = build_parser()
    _prepare(parser)
    print(shtab.complete(parser, shell=arguments.shell))


def _prepare(parser: argparse.ArgumentParser) -> None:
    """Prepare a parser for shtab: describe commands by their one-line help, and complete file and folder arguments by
    files and folders."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                command.description = None
                _prepare(command)
        elif action.choices is None and isinstance(action.metavar, str):
            for pattern, kind in ((_FOLDER, shtab.DIRECTORY), (_FILE, shtab.FILE)):
                if pattern.fullmatch(action.metavar):
                    action.complete = kind  # type: ignore[attr-defined]
