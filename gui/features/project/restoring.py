"""Restoring of unsaved work of another window."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ilf._runtime.formatting import counted
from ilf.errors import IlfError
from ilf.project.archive import Parts
from ilf.project.file import OpenedProject, open_project
from ilf.project.recovery import RecoverableWork, copy_frames
from ilf.sources.named_places import may_look_at, named_in

from ..context import Context
from .feature import ProjectFeature

_Read = tuple[OpenedProject | None, tuple[str, ...], dict[str, str]]
"""The opened project file, problems, and for each frame that cannot be read why."""


def restore(context: Context, left: RecoverableWork, then: Callable[[], None], fail: Callable[[], None]) -> None:
    """Make unsaved work the project of a window without frames; call `then` on success, `fail` otherwise. Its folder is
    deleted only after this window has stored the work."""

    def take(read: _Read) -> None:
        opened, problems, left_aside = read
        newer = "" if opened is None else _why_newer(opened.path, left)
        # located files take precedence over the paths in the project file
        places = left.read.places if opened is None else replace(opened.places, given=left.read.places.given)
        # a file that is unreadable or newer may contain none of the work
        unsaved = (left.stored if opened is None or newer else left.changed) - set(left_aside)
        context.feature(ProjectFeature).opening.take(left.read.project, places, opened, unsaved, newer)
        context.notes.warn(f"Restored {name_of(left)}", [newer] * bool(newer))
        told = [*problems]
        for frame_id, problem in left_aside.items():
            entry = context.workspace.entries.of(frame_id)
            if entry is not None:
                context.workspace.note_problem(entry, problem)
                told.append(f"{entry.name}: {problem} It stays in {left.path}, which is offered again.")
        context.notes.warn("Restored with errors", told)

        def drop(_: Exception | None) -> None:
            """Delete the folder if all of its frames are in this window's own; else keep it, to be offered again."""
            if left_aside or not context.recorder.store.is_written:
                left.release()
                return
            with contextlib.suppress(OSError):
                left.discard()

        context.recorder.flush(drop)
        then()

    context.loader.read(f"Restore {name_of(left)}", lambda: _read_work(context, left), take, fail)


def _read_work(context: Context, left: RecoverableWork) -> _Read:
    """Read the work and store it in the window; called in a worker thread."""
    opened, problems = _project_of(left)
    stores: list[Parts] = [left.parts, *([] if opened is None else [opened.parts])]
    copied = copy_frames(stores, left.stored)
    context.recorder.store.adopt(copied)
    return opened, (*left.read.problems, *problems), copied.problems


def name_of(left: RecoverableWork) -> str:
    """Return a display name: the project, the frames, or the folder of work that cannot be read."""
    if left.project:
        return Path(left.project).stem
    names = [frame.name for frame in left.frames or left.read.project.frames]
    more = f" and {len(names) - 3} more" * (len(names) > 3)
    return ", ".join(names[:3]) + more or left.path.name


def _project_of(left: RecoverableWork) -> tuple[OpenedProject | None, tuple[str, ...]]:
    """Return the project file, if there is one that can be read, and its problems."""
    path = left.project
    if not path:
        return None, ()
    without = [frame for frame in left.read.project.frames if frame.has_state and frame.id not in left.stored]
    lost = f" Work on {counted(len(without), 'frame')} that only this file contains is missing." if without else ""
    try:
        opened = open_project(path if may_look_at(path) else named_in(path, None))
    except IlfError as error:
        return None, (f"{error}{lost} Save the project under a new name.",)
    return opened, opened.problems


def _why_newer(path: Path, left: RecoverableWork) -> str:
    """Return why a project file must not be replaced without asking: it was saved after the work; "" if not."""
    with contextlib.suppress(OSError):
        if left.header is not None and path.stat().st_mtime > left.header.changed.timestamp():
            return (
                f"{path.name} has been saved after this work, and may contain newer work: Save will ask for another "
                "file."
            )
    return ""
