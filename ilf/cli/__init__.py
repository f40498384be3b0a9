"""The command line: `ilf complete`, `blocks`, `info`, `judge` and the others of `build_parser`; no Qt."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence

from .. import __version__
from ..errors import IlfError
from . import bench, blocks, capture, complete, experiments, info, judge, models, presets, project, report_page, sample
from .parsing import Parser, UsageError


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process if left out.

    Returns
    -------
    int
        Exit status: 0 if all is well, 1 after an error, 2 for wrong usage, 130 if interrupted. Whatever goes
        wrong is one line on stderr.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        # as stderr has it: a name that a terminal cannot show must not be an error after all has been written
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        arguments = build_parser().parse_args(argv)
        arguments.command(arguments)
        sys.stdout.flush()
    except UsageError as error:
        return _failed(error, 2)
    except BrokenPipeError:
        # whoever read the output has seen enough; without this the interpreter complains when it flushes at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (IlfError, OSError) as error:
        return _failed(error, 1)
    except KeyboardInterrupt:
        return _failed("interrupted", 130)
    return 0


def build_parser() -> Parser:
    """The parser of all commands."""
    parser = Parser(
        prog="ilf",
        allow_abbrev=False,
        description="Complete the missing depth of RGB-D frames by iterative low-pass filtering.",
    )
    parser.add_argument("--version", action="version", version=f"ilf {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for module in (
        complete,
        blocks,
        capture,
        info,
        judge,
        report_page,
        bench,
        experiments,
        sample,
        models,
        presets,
        project,
    ):
        module.add_command(commands)
    return parser


def _failed(reason: object, status: int) -> int:
    print("ilf: error:", " ".join(str(reason).split()), file=sys.stderr)
    return status
