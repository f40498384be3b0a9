"""What the arguments of `ilf report` name, read one after the other."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ..errors import IlfError, InputError
from ..judgement import Step
from ..judgement.completing import completion_steps
from ..judgement.step import run_out
from ..outcomes import Completion
from ..parameters import BlockParameters
from ..project.file import SUFFIX, OpenedProject, open_project
from ..project.project import ProjectFrame
from ..report import Subject, Unreadable
from ..run import Run, replay
from ..run.options import RECORD_FILE
from .parsing import UsageError, frame_from, parameter_flags, preset_from, with_given

Tell = Callable[[Step], None]


@dataclass(frozen=True)
class ReportSource:
    """A frame to report on: what it is called, and how it is had, which adds to some notes and tells how far it is."""

    name: str
    read: Callable[[list[str], Tell], Subject]


def report_sources(arguments: argparse.Namespace, opened: ExitStack) -> list[ReportSource]:
    """What the arguments name: folders, records and projects, or the two files of one frame.

    Projects stay open as long as `opened`.
    """
    inputs = [Path(path) for path in arguments.inputs]
    if not inputs:
        raise UsageError("Give a colour and a depth file, one folder or more, a run.json, or a project.")
    if not all(path.is_dir() or path.suffix.lower() in (".json", SUFFIX) for path in inputs):
        return [ReportSource(arguments.inputs[0], partial(_completed, arguments, arguments.inputs))]
    sources: list[ReportSource] = []
    for path in inputs:
        record = path / RECORD_FILE if path.is_dir() else path
        if path.suffix.lower() == SUFFIX and not path.is_dir():
            _refuse_flags(arguments, path)
            sources += _of_project(opened.enter_context(open_project(path)), arguments.look_in)
        elif record.is_file() or not path.is_dir():  # what a run wrote can be read as a frame, too, but is a run
            _refuse_flags(arguments, record)
            sources.append(ReportSource(str(path), partial(_replayed, record)))
        else:
            sources.append(ReportSource(str(path), partial(_completed, arguments, [str(path)])))
    return sources


def read_subjects(sources: Sequence[ReportSource], notes: list[str], tell: Tell) -> Iterator[Subject | Unreadable]:
    """One after the other; of several, one that cannot be read costs that one only. Notes are added on the way."""
    total = len(sources)
    for number, source in enumerate(sources):

        def tell_all(step: Step, number: int = number) -> None:
            tell(Step(number / total, step.text))

        own: list[str] = []
        try:
            subject = source.read(own, tell_all)
        except UsageError:
            raise
        except IlfError as error:
            if total == 1:
                raise
            notes.append(f"{source.name} is not in the report: {error}")
            yield Unreadable(source.name, str(error))
        else:
            before = f"{subject.run.frame.name}: " if total > 1 else ""
            notes += [before + note for note in own]
            yield subject


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


def _replayed(record: Path, notes: list[str], tell: Tell) -> Subject:
    """A recorded run, made again."""
    again = replay(record)
    completion = _complete(again.run, tell)
    notes += [*again.differences, *again.run.notes, *completion.notes, *again.verdict(completion)]
    return Subject(again.run, completion, again=shlex.join(["ilf", "complete", "--replay", str(record.absolute())]))


def _of_project(project: OpenedProject, folders: Sequence[str]) -> list[ReportSource]:
    """Its frames that have been worked on; their files may also be in these folders."""
    places = replace(project.places, folders=tuple(map(Path, folders)))
    frames = [frame for frame in project.project.frames if frame.has_state and frame.summary.is_worked_on]
    if not frames:
        raise InputError(f"{project.path} has no frame that has been worked on, so there is nothing to report on.")

    for_all = project.project.common if project.project.for_all else None

    def stored(frame: ProjectFrame, notes: list[str], tell: Tell) -> Subject:
        decoded = project.state(frame.id, places)
        notes += decoded.problems
        again = shlex.join(["ilf", "project", "replay", str(project.path), "--frame", frame.id])
        return Subject.of_state(decoded.state.as_set(frame.summary.note, for_all), again, decoded.problems)

    return [ReportSource(frame.name, partial(stored, frame)) for frame in frames]


def _refuse_flags(arguments: argparse.Namespace, file: Path) -> None:
    """Raise UsageError for flags that say what the file says already."""
    reading = "depth_encoding", "depth_units", "invalid", "intrinsics", "min_confidence"
    names = "frame", "max_gap", "topics", "preset", "distrust", "guide", "truth", "truth_units", *reading
    also = [f"--{name.replace('_', '-')}" for name in names if getattr(arguments, name) is not None]
    if also := [*also, *parameter_flags(arguments)]:
        raise UsageError(f"{file} says how its runs are made: leave out {', '.join(also)}.")


def _complete(made: Run, tell: Tell) -> Completion:
    name = made.frame.name
    return run_out(completion_steps(made, None), lambda step: tell(Step(0.0, f"{name}: {step.text}")))
