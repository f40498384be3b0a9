"""The table of commands, and running one: exit status, and one line on stderr for an error."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Collection, Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any, TextIO

from .._runtime.files import is_address
from .._runtime.installation import __version__, check_opencv, run_if_child
from .._runtime.termination import Interrupted, log_error, terminating_immediately, terminating_on_signal
from ..errors import IlfError, one_line, to_text, without_credentials
from ..sources.named_places import allow_address
from .usage import DONE, EXIT_STATUSES, FAILED, INTERRUPTED, WRONG_USAGE, Parser, UsageError

COMMANDS = {
    "complete": "complete the depth of a frame and write all results",
    "batch": "complete many frames, in several processes or on several machines",
    "blocks": "extract the operation blocks of a frame",
    "info": "show the contents of a frame, a source of frames or a run record; list presets and layouts",
    "evaluate": "evaluate a frame's completion against ground truth or hold-out",
    "bench": "compare presets and other methods of completion on many frames",
    "report": "write one HTML page about frames: pictures, blocks, parameters, curves, errors, versions and hashes",
    "project": "make, show, export and replay project files; export results to other programs",
    "models": "list, fetch, add and remove networks for edges and guides",
    "sample": "write the bundled sample frame into a folder",
    "capture": "write a frame of the connected camera into a folder",
    "stream": "complete a recording frame after frame, as a robot would, or write results, as a recording or a folder",
}
"""Name -> one-line help. `add_arguments` in the module of the same name adds the arguments to its parser, and
`run` runs the command if it has no actions. The module is imported only when its command is used."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; default: those of the process.

    Returns
    -------
    int
        Exit status, one of `usage.EXIT_STATUSES`. An error is one line on stderr; no incomplete files are left behind.
    """
    run_if_child()
    with terminating_immediately("ilf"):
        return _run(argv)


def _run(argv: Sequence[str] | None) -> int:
    _ensure_streams()
    words = sys.argv[1:] if argv is None else argv
    parser = build_parser(words[:1])
    try:
        with terminating_on_signal():
            status = _status(parser, words)
    except Interrupted as asked:
        status = _failed(asked, asked.status)
    except KeyboardInterrupt:
        status = _failed("interrupted", INTERRUPTED)
    finally:
        delivered = [_is_delivered(stream) for stream in (sys.stdout, sys.stderr)]
    return status or (DONE if delivered[0] else FAILED)


def _status(parser: Parser, words: Sequence[str]) -> int:
    try:
        arguments = parser.parse_args(words)
        if is_address(vars(arguments).get("out")):
            raise UsageError("--out takes a path, not an address: only `ilf batch --shards` writes to addresses.")
        check_opencv()
        if device := vars(arguments).get("device"):
            os.environ["ILF_DEVICE"] = device
        with allow_address(*vars(arguments).get("allow_address", ())):
            arguments.command(arguments)
        sys.stdout.flush()
    except UsageError as error:
        return _failed(error, WRONG_USAGE)
    except BrokenPipeError:
        # the reader of the output has closed the pipe
        return FAILED
    except (IlfError, OSError) as error:
        return _failed(to_text(error), FAILED)
    except Exception as error:
        return _failed(log_error(error), FAILED)
    return DONE


def build_parser(names: Collection[str] = tuple(COMMANDS)) -> Parser:
    """Build the parser of all commands.

    Parameters
    ----------
    names : collection of str
        Commands whose arguments are needed; only their modules are imported.
    """
    parser = Parser(
        prog="ilf",
        description="Complete the missing depth of RGB-D frames by iterative low-pass filtering.",
        epilog="\n".join(["exit status:", *(f"  {status:<5} {text}" for status, text in EXIT_STATUSES.items())]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"ilf {__version__}")
    parser.add_argument(
        "--completion",
        action=_Completion,
        choices=("bash", "zsh", "fish"),
        help="print the script with which a shell completes commands, options and file names. For bash, add this line "
        'to ~/.bashrc: eval "$(ilf --completion bash)". For zsh, write the script to a file named _ilf in a folder of '
        "$fpath; for fish, to ~/.config/fish/completions/ilf.fish",
    )
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text)
        if name in names:
            module = import_module(f"{__package__}.{name}")
            module.add_arguments(command)
            command.set_defaults(command=getattr(module, "run", None))  # without `run`, its actions set theirs
    return parser


class _Completion(argparse.Action):
    """Prints the script with which a shell completes commands, options and file names."""

    def __call__(self, parser: Parser, *given: Any) -> None:  # type: ignore[override]
        import shtab  # not before: no other command needs it

        _, shell, _ = given
        whole = build_parser()
        _prepare(whole, shtab.FILE)
        print(shtab.complete(whole, shell=shell))
        parser.exit()


_FILE = re.compile(r"BAG|CAMERA|DIR|FILE|FOLDER|FRAME|INPUT|PATH|PRESET|RESULT|SOURCE|\w+\.\w+")
"""Placeholders of arguments that name files or folders."""


def _prepare(parser: argparse.ArgumentParser, files: object) -> None:
    """Describe commands by their one-line help, and complete what names files by files."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                command.description = None
                _prepare(command, files)
        elif action.choices is None and isinstance(action.metavar, str) and _FILE.fullmatch(action.metavar):
            action.complete = files  # type: ignore[attr-defined]


def _ensure_streams() -> None:
    """Replace closed stdout and stderr by streams that discard their output."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        # as for stderr: a name that the terminal cannot show must not cause an error after the files are written
        sys.stdout.reconfigure(errors="backslashreplace")


def _is_delivered(stream: TextIO) -> bool:
    """Flush a stream; return whether that succeeded. Otherwise drop the rest, so that it is not flushed at exit."""
    try:
        stream.flush()
    except OSError:
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return False
    return True


def _failed(reason: object, status: int) -> int:
    with suppress(OSError):
        print("ilf: error:", one_line(" ".join(without_credentials(str(reason)).split())), file=sys.stderr)
    return status
