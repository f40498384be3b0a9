"""What `ilf project info` tells of a project: as text, and as JSON."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import Any

from ..confidence import RMS_NAME
from ..parameters import Parameters
from ..preset_words import likeness
from ..project import Stage
from ..project.encoding import SCHEMA
from ..project.facts import FrameFacts, RunFacts
from ..project.file import OpenedProject
from ..project.json_values import plain
from .report import table


def print_facts(opened: OpenedProject, facts: Sequence[FrameFacts]) -> None:
    """Print what there is to tell of a project."""
    project, path = opened.project, opened.path
    stages = Counter(frame.summary.stage for frame in project.frames)
    in_words = ", ".join(f"{stages[stage]} {stage}" for stage in Stage if stages[stage])
    for_whom = "for all frames" if project.for_all else "for each frame; the next one begins with"
    lines = [
        ("project", f"{path}, {path.stat().st_size / 1e6:.1f} MB in {counted(len(opened.parts.names()), 'part')}"),
        ("schema", f"{SCHEMA}" if not opened.read_only else f"newer than {SCHEMA}"),
        ("frames", f"{len(facts)}" + (f": {in_words}" if in_words else "")),
        ("parameters", f"{for_whom} {_parameters_text(project.common)}"),
        ("files", "embedded" if opened.read.embedded else "beside the project, or where they were"),
    ]
    problems = [*opened.problems, *([opened.read_only] if opened.read_only else [])]
    for fact in facts:
        problems += [f"{fact.frame.name}: {problem}" for problem in fact.problems]
        problems += [
            f"{fact.frame.name}: {file} {'is missing' if how == 'missing' else 'has changed'}."
            for file, how in fact.sources.items()
            if how in ("missing", "changed")
        ]
    for name, text in [*lines, *(("problem", problem) for problem in problems)]:
        print(f"{name + ':':13} {text}")
    if facts:
        head = ["frame", "id", "stage", "size", "missing", "blocks", "completed", "runs", "kB", "files"]
        print("", *table(head, [_frame_row(fact) for fact in facts]), sep="\n")
    for fact in facts:
        if fact.runs:
            print(f"\nRuns of {fact.frame.name}:")
            head = ["run", "name", "end", "blocks", "time [s]", "truth [mm]", "hidden [mm]", f"{RMS_NAME} [mm]", "note"]
            print(*table(head, [_run_row(run) for run in fact.runs]), sep="\n")


def _frame_row(fact: FrameFacts) -> list[str]:
    summary = fact.frame.summary
    how = Counter(fact.sources.values())
    return [
        fact.frame.name,
        fact.frame.id,
        summary.stage.value,
        "-" if summary.shape is None else f"{summary.shape[1]} x {summary.shape[0]}",
        "-" if summary.missing is None else f"{summary.missing:.1%}",
        str(summary.blocks),
        str(summary.completed),
        str(len(fact.runs)),
        f"{fact.size / 1000:.0f}",
        ", ".join(f"{count} {state}" for state, count in how.items()) or "in the project",
    ]


def _run_row(run: RunFacts) -> list[str]:
    errors = (run.truth_error, run.hidden_error, run.expected_error)
    return [
        str(run.number),
        " ".join(run.name.split()),
        run.how,
        str(run.blocks),
        f"{run.seconds:.1f}",
        *("-" if error is None or error != error else f"{1000 * error:.2f}" for error in errors),
        " ".join(run.note.split()) or "-",
    ]


def facts_as_json(opened: OpenedProject, facts: Sequence[FrameFacts]) -> Any:
    """The same, ready for JSON."""
    return plain(
        {
            "path": str(opened.path),
            "bytes": opened.path.stat().st_size,
            "parts": len(opened.parts.names()),
            "read_only": opened.read_only,
            "embedded": opened.read.embedded,
            "problems": opened.problems,
            "present": opened.project.present,
            "for_all": opened.project.for_all,
            "parameters": opened.project.common.to_dict(),
            "frames": [
                {
                    "id": fact.frame.id,
                    "name": fact.frame.name,
                    **dataclasses.asdict(fact.frame.summary),
                    "has_state": fact.frame.has_state,
                    "bytes": fact.size,
                    "sources": fact.sources,
                    "runs": [dataclasses.asdict(run) for run in fact.runs],
                    "problems": fact.problems,
                }
                for fact in facts
            ],
        }
    )


def _parameters_text(parameters: Parameters) -> str:
    nearest = likeness(parameters)
    changes = ", ".join(f"{name} {value}" for name, value in nearest.differs.items())
    return f"preset {nearest.preset}" + (f" with {changes}" if changes else "")


def counted(count: int, what: str) -> str:
    """A number of things, in words."""
    return f"{count} {what}{'' if count == 1 else 's'}"
