"""Write the manual pages of `ilf` and `ilf-gui` from their parsers.

    python assets/packaging/make_man.py

writes share/man/man1 beside this script. The options of a command of `ilf` are in its own --help.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from gui.app.start import build_parser as window_parser
from ilf.cli.commands import build_parser
from ilf.cli.usage import EXIT_STATUSES

FOLDER = Path(__file__).parent / "share" / "man" / "man1"


def pages() -> dict[str, str]:
    """The pages by the names of their files."""
    commands, window = build_parser([]), window_parser()
    exits = ("EXIT STATUS", *(line for status, text in EXIT_STATUSES.items() for line in _item(str(status), text)))
    more = (".PP", "The options of a command: ", ".B ilf", _roff("COMMAND --help"))
    return {
        "ilf.1": _page(commands, "COMMAND [ARGUMENT ...]", [*_arguments(commands), *more], [exits], "ilf-gui"),
        "ilf-gui.1": _page(window, "[OPTION ...] [FRAME ...]", [*_arguments(window)], [], "ilf"),
    }


def _page(
    parser: argparse.ArgumentParser, usage: str, arguments: list[str], others: list[tuple[str, ...]], see: str
) -> str:
    about = str(parser.description)
    lines = [f'.TH {_roff(parser.prog.upper())} 1 "" "ILF Studio" "User Commands"']
    lines += [".SH NAME", _roff(f"{parser.prog} - {about[0].lower()}{about[1:].rstrip('.')}")]
    lines += [".SH SYNOPSIS", f".B {_roff(parser.prog)}", _roff(usage), ".SH DESCRIPTION", _roff(about), *arguments]
    for title, *text in others:
        lines += [f".SH {title}", *text]
    return "\n".join([*lines, ".SH SEE ALSO", f".BR {_roff(see)} (1)", ""])


def _arguments(parser: argparse.ArgumentParser) -> Iterator[str]:
    """The groups of arguments, as sections; sub-commands are items of theirs."""
    for group in parser._action_groups:
        listed = [action for action in group._group_actions if action.help != argparse.SUPPRESS]
        if listed:
            yield f".SH {_roff(str(group.title).upper())}"
        for action in listed:
            if isinstance(action, argparse._SubParsersAction):
                for command in action._get_subactions():
                    yield from _item(str(command.metavar), str(command.help))
                continue
            value = action.metavar or "|".join(map(str, action.choices or [])) or action.dest.upper()
            flags = [flag if action.nargs == 0 else f"{flag} {value}" for flag in action.option_strings]
            yield from _item(", ".join(flags) or str(value), parser._get_formatter()._expand_help(action))


def _item(term: str, text: str) -> Iterator[str]:
    yield from (".TP", f".B {_roff(term)}", _roff(text))


def _roff(text: str) -> str:
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{escaped}" if escaped.startswith((".", "'")) else escaped


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
