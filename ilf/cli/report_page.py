"""`ilf report`: one HTML page about a frame, a recorded run, or several of them."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from ..errors import IlfError, InputError
from ..judgement import HIDDEN_PATTERNS, HiddenTest, Step
from ..judgement.completing import completion_steps
from ..judgement.step import run_out
from ..outcomes import Completion
from ..parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..report import ReportOptions, Subject, Unreadable, report_steps, write_report
from ..run import Run, replay
from ..run.options import RECORD_FILE, as_file_name
from .parsing import (
    Commands,
    UsageError,
    add_block_parameters,
    add_distrusted,
    add_frame,
    add_parameters,
    add_preset,
    add_truth,
    count,
    frame_from,
    parameter_flags,
    preset_from,
    with_given,
)
from .progress import ShareProgress
from .report import warn

_SEEDS = 3
_USAGE = """ilf report RGB DEPTH [options]
       ilf report (FOLDER | run.json)... [options]"""

Tell = Callable[[Step], None]


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "report",
        help="write one HTML page about frames: pictures, blocks, parameters, curves, errors, versions and hashes",
        usage=_USAGE,
        description="Write one HTML page that needs no other file and no network. A frame is completed first, and a "
        "recorded run made again. Several of them make one page with an index. For PDF, print the page in a browser, "
        "or use File > Report… in the window.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_distrusted(parser)
    add_truth(parser)
    add_preset(parser)
    parser.add_argument(
        "--hidden",
        choices=tuple(HIDDEN_PATTERNS),
        help="also judge on known depth that is hidden, in this pattern; takes as long as the run, once per seed",
    )
    parser.add_argument(
        "--seeds", type=count, metavar="N", help=f"how often depth is hidden, ever other pixels (default: {_SEEDS})"
    )
    output = parser.add_argument_group("output")
    output.add_argument("--out", metavar="FILE.html", help="the page (default: NAME-report.html here)")
    output.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="progress bar on stderr (default: if that is a terminal)",
    )
    add_parameters(parser, Parameters, "filter", presets=PRESETS, default=DEFAULT_PRESET)
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    several = _are_several(arguments.inputs)
    total = len(arguments.inputs) if several else 1
    options = ReportOptions("Report", _test(arguments))
    path = _output(arguments, several)
    notes: list[str] = []
    shown = sys.stderr.isatty() if arguments.progress is None else arguments.progress
    with ShareProgress(shown=shown) as progress:
        subjects = _subjects(arguments, several, notes, progress.update)
        content = run_out(report_steps(subjects, options, total), progress.update)
    warn(notes)
    if path is None:
        path = Path(f"{as_file_name(content.title)}-report.html")
    write_report(path, content, options)
    print(f"Written to {path}, {path.stat().st_size / 1e6:.1f} MB.")


def _are_several(inputs: list[str]) -> bool:
    """Whether every input is a frame or a record of its own; otherwise they are the two files of one frame."""
    if not inputs:
        raise UsageError("Give a colour and a depth file, one folder or more, or a run.json.")
    return all(Path(path).is_dir() or Path(path).suffix.lower() == ".json" for path in inputs)


def _test(arguments: argparse.Namespace) -> HiddenTest | None:
    if arguments.hidden is None:
        if arguments.seeds is not None:
            raise UsageError("--seeds is about hidden depth: add --hidden.")
        return None
    return HiddenTest(arguments.hidden, tuple(range(arguments.seeds or _SEEDS)))


def _output(arguments: argparse.Namespace, several: bool) -> Path | None:
    """Where the page goes, if that can be said before the frame is read."""
    if arguments.out is None:
        return Path("report.html") if several and len(arguments.inputs) > 1 else None
    path = Path(arguments.out)
    if path.suffix.lower() not in (".html", ".htm"):
        raise UsageError(
            f"--out is an HTML page: {path.name} should end in .html. For PDF, print the page in a browser, or use "
            "File > Report… in the window."
        )
    return path


def _subjects(
    arguments: argparse.Namespace, several: bool, notes: list[str], tell: Tell
) -> Iterator[Subject | Unreadable]:
    """One after the other; of several, one that cannot be read costs that one only."""
    if not several:
        yield _completed(arguments, arguments.inputs, notes, tell)
        return
    total = len(arguments.inputs)
    for number, path in enumerate(arguments.inputs):

        def tell_all(step: Step, number: int = number) -> None:
            tell(Step(number / total, step.text))

        own: list[str] = []
        try:
            subject = _subject(arguments, Path(path), own, tell_all)
        except UsageError:
            raise
        except IlfError as error:
            if total == 1:
                raise
            notes.append(f"{path} is not in the report: {error}")
            yield Unreadable(path, str(error))
        else:
            if total > 1:
                name = subject.run.frame.name
                own = [f"{name}: {note}" for note in own]
            notes += own
            yield subject


def _subject(arguments: argparse.Namespace, path: Path, notes: list[str], tell: Tell) -> Subject:
    if not path.is_dir():
        return _replayed(arguments, path, notes, tell)
    record = path / RECORD_FILE
    if record.is_file():  # what a run wrote can be read as a frame, too, but is a run
        return _replayed(arguments, record, notes, tell)
    return _completed(arguments, [str(path)], notes, tell)


def _completed(arguments: argparse.Namespace, inputs: list[str], notes: list[str], tell: Tell) -> Subject:
    """A frame, completed by what the arguments say."""
    chosen = preset_from(arguments.preset)
    parameters = with_given(chosen.parameters, arguments)
    extraction = with_given(chosen.extraction or BlockParameters(), arguments)
    frame = frame_from(argparse.Namespace(**{**vars(arguments), "inputs": inputs}))
    made = Run.extracted(frame, extraction, parameters)
    if not made.blocks.any():
        raise InputError(f"There are no blocks in {frame.name}, so there is nothing to report on.")
    completion = _complete(made, tell)
    notes += [*made.notes, *completion.notes]
    return Subject(made, completion)


def _replayed(arguments: argparse.Namespace, record: Path, notes: list[str], tell: Tell) -> Subject:
    """A recorded run, made again."""
    names = "preset", "distrust", "truth", "truth_units", "depth_units", "intrinsics"
    also = [f"--{name.replace('_', '-')}" for name in names if getattr(arguments, name) is not None]
    if also := [*also, *parameter_flags(arguments)]:
        raise UsageError(f"{record} says how its run is made: leave out {', '.join(also)}.")
    again = replay(record)
    completion = _complete(again.run, tell)
    notes += [*again.differences, *again.run.notes, *completion.notes, *again.verdict(completion)]
    return Subject(again.run, completion, again=shlex.join(["ilf", "complete", "--replay", str(record.absolute())]))


def _complete(made: Run, tell: Tell) -> Completion:
    name = made.frame.name
    return run_out(completion_steps(made, None), lambda step: tell(Step(0.0, f"{name}: {step.text}")))
