"""`ilf report`: one HTML page about a frame, a recorded run, a project, or several of them."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

from .._runtime.long_work import run_to_end
from ..data.results import Completion
from ..errors import IlfError, InputError
from ..evaluation.hold_out import completion_steps
from ..project.file import SUFFIX, OpenedProject, open_project
from ..project.project import ProjectFrame
from ..report.report import report_steps, write_report
from ..report.subject import Subject, Unreadable
from ..run.options import as_file_name
from ..run.replaying import replay
from ..run.run import Run
from ..sources.frame_ref import RECORD_FILE
from .output import Bar, shows_progress, warn
from .parsing import add_frame, add_settings, add_shared, frame_from, hold_out_from, preset_from, settings_from
from .usage import Parser, UsageError, declare

Read = Callable[[list[str], Bar], Subject]
"""Reads a frame to report on, adds notes and shows its progress."""


def _sources(arguments: argparse.Namespace, opened: ExitStack) -> list[tuple[str, Read]]:
    """List the names and readers of the frames that the arguments name: of folders, records and projects, which stay
    open as long as `opened`, or of the two files of one frame."""
    inputs = [Path(path) for path in arguments.inputs]
    if not inputs:
        raise UsageError("Give a colour and a depth file, one folder or more, a run.json, or a project.")
    if not all(path.is_dir() or path.suffix.lower() in (".json", SUFFIX) for path in inputs):
        return [(arguments.inputs[0], partial(_completed, arguments, arguments.inputs))]
    sources: list[tuple[str, Read]] = []
    for path in inputs:
        record = path / RECORD_FILE if path.is_dir() else path
        if path.is_dir() and not record.is_file():
            sources.append((str(path), partial(_completed, arguments, [str(path)])))
            continue
        if also := [flag for flag in arguments.given.values() if flag not in _WITH_RUNS]:
            raise UsageError(f"{record} contains the settings of its runs: leave out {', '.join(also)}.")
        if record.suffix.lower() == SUFFIX:
            sources += _of_project(opened.enter_context(open_project(path)), arguments.look_in)
        else:  # the output folder of a run can be read as a frame, too, but is reported as a run
            sources.append((str(path), partial(_replayed, record)))
    return sources


def _subjects(sources: Sequence[tuple[str, Read]], notes: list[str], bar: Bar) -> Iterator[Subject | Unreadable]:
    """Yield the subjects and add their notes; if there are several, an unreadable one is reported and skipped."""
    is_single = len(sources) == 1
    for name, read in sources:
        own: list[str] = []
        try:
            subject = read(own, bar)
        except IlfError as error:
            if is_single or isinstance(error, UsageError):
                raise
            notes.append(f"{name} is not in the report: {error}")
            yield Unreadable(name, str(error))
        else:
            before = "" if is_single else f"{subject.run.frame.name}: "
            notes += [before + note for note in own]
            yield subject


def _completed(arguments: argparse.Namespace, inputs: list[str], notes: list[str], bar: Bar) -> Subject:
    """Complete a frame with the settings of the arguments."""
    parameters, choice = settings_from(arguments, preset_from(arguments.preset))
    frame = frame_from(argparse.Namespace(**{**vars(arguments), "inputs": inputs}))
    made = choice.run_of(frame, parameters)
    completion = _complete(made, bar)
    notes += [*made.blocks.notes, *completion.notes]
    return Subject(completion)


def _replayed(record: Path, notes: list[str], bar: Bar) -> Subject:
    """Replay a recorded run."""
    again = replay(record)
    completion = _complete(again.run, bar)
    notes += [*again.differences, *again.run.blocks.notes, *completion.notes, *again.verdict(completion)]
    return Subject(completion, again=shlex.join(["ilf", "complete", "--replay", str(record.absolute())]))


def _of_project(opened: OpenedProject, folders: Sequence[str]) -> list[tuple[str, Read]]:
    """List a project's frames with work on them; their files are also searched in `folders`."""
    project, places = opened.project, replace(opened.places, folders=tuple(map(Path, folders)))

    def stored(frame: ProjectFrame, notes: list[str], _: Bar) -> Subject:
        decoded = opened.state(frame.id, places)
        notes += decoded.problems
        state = decoded.state.with_current_settings(frame.summary.note, project.common if project.for_all else None)
        again = shlex.join(["ilf", "project", "replay", str(opened.path), "--frame", frame.id])
        return Subject.of_state(state, again, decoded.problems)

    frames = [frame for frame in project.frames if frame.has_state and frame.summary.has_work]
    if not frames:
        raise InputError(f"{opened.path} has no frame with edits or results to report on. Run blocks first.")
    return [(frame.name, partial(stored, frame)) for frame in frames]


def _complete(made: Run, bar: Bar) -> Completion:
    name = made.frame.name
    return run_to_end(completion_steps(made, None), lambda step: bar.show(bar.n, f"{name}: {step.text}"))


_WITH_RUNS = {"--look-in", "--hold-out", "--seeds", "--out", "--progress", "--no-progress", "--device"}
"""The flags of what contains the settings of its runs."""

_USAGE = """ilf report RGB DEPTH [options]
       ilf report (FOLDER | run.json | PROJECT.ilf)... [options]"""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = _USAGE
    parser.description = (
        "Write one self-contained HTML page. Frames are completed first, recorded runs are replayed, and the edited "
        "frames of a project are used as they are. Several of them share one page with an index. For PDF, print the "
        "page in a browser, or use File > Report… in the window."
    )
    add_frame(parser)
    add_shared(parser, "--invalid-mask", "--look-in", "--hold-out", "--seeds")
    output = parser.add_argument_group("output")
    declare(output, "--out FILE.html  output file (default: NAME-report.html)")
    add_shared(output, "--progress")
    add_settings(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    hidden = hold_out_from(arguments)
    out = None if arguments.out is None else Path(arguments.out)
    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"--out must end in .html, not {out.name}. For PDF, print the page, or use the window.")
    notes: list[str] = []
    with ExitStack() as opened:
        sources = _sources(arguments, opened)
        bar = opened.enter_context(Bar(shown=shows_progress(arguments)))
        title = Path(arguments.inputs[0]).stem if len(arguments.inputs) == 1 else "Report"
        steps = report_steps(_subjects(sources, notes, bar), len(sources), title=title, hidden=hidden)
        content = run_to_end(steps, lambda step: bar.show(step.share, step.text))
    warn(notes)
    path = out or Path(f"{as_file_name(content.title)}-report.html")
    write_report(path, content)
    print(f"Written to {path}, {path.stat().st_size / 1000:.0f} kB.")
