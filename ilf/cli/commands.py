"""All commands, and how whichever is run ends: with an exit status, and one line if something went wrong."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import TextIO

from .._runtime.ending import Interrupted, ending_when_asked, note_fault
from .._runtime.installation import __version__
from ..errors import IlfError, in_words, one_line
from . import (
    batch,
    bench,
    blocks,
    capture,
    complete,
    experiments,
    info,
    models,
    nerfstudio,
    presets,
    project,
    rosbag,
    sample,
)
from . import evaluate as judge
from . import report as report_page
from .parsing import Parser, UsageError


def run(argv: Sequence[str] | None) -> int:
    """Run a command; see `ilf.cli.main`."""
    _make_streams()
    try:
        with ending_when_asked():
            status = _status(argv)
    except Interrupted as asked:
        status = _failed(asked, asked.status)
    except KeyboardInterrupt:
        status = _failed("interrupted", 130)
    finally:
        delivered = [_is_delivered(stream) for stream in (sys.stdout, sys.stderr)]
    return status or (0 if delivered[0] else 1)


def _status(argv: Sequence[str] | None) -> int:
    try:
        arguments = build_parser().parse_args(argv)
        arguments.command(arguments)
        sys.stdout.flush()
    except UsageError as error:
        return _failed(error, 2)
    except BrokenPipeError:
        # whoever read the output has seen enough
        return 1
    except (IlfError, OSError) as error:
        return _failed(in_words(error), 1)
    except Exception as error:
        return _failed(note_fault(error), 1)
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
    often = complete, batch, blocks, info, judge, report_page
    for module in (*often, capture, rosbag, bench, experiments, sample, models, presets, project, nerfstudio):
        module.add_command(commands)
    return parser


def _make_streams() -> None:
    """Have stdout and stderr, also where they were closed before: then as if nobody listened."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        # as stderr has it: a name that a terminal cannot show must not be an error after all has been written
        sys.stdout.reconfigure(errors="backslashreplace")


def _is_delivered(stream: TextIO) -> bool:
    """Whether all that was printed has gone out. What has not is dropped: the interpreter would try again at exit."""
    try:
        stream.flush()
    except OSError:
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return False
    return True


def _failed(reason: object, status: int) -> int:
    with suppress(OSError):
        print("ilf: error:", one_line(" ".join(str(reason).split())), file=sys.stderr)
    return status
