"""Unsaved work of windows that closed unexpectedly: restored as the project of this window, discarded, or kept."""

from __future__ import annotations

import contextlib
import socket
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QApplication, QDialog

from ilf._runtime.formatting import counted
from ilf.errors import IlfError
from ilf.project.archive import Parts
from ilf.project.file import OpenedProject, open_project
from ilf.project.recovery import RecoverableWork, copy_frames
from ilf.sources.named_places import may_look_at, named_in

from ...widgets.notices import ACCEPT, DESTROY, ask
from ...work.steps import Steps
from ..context import Context
from .feature import ProjectFeature

_ABOUT = (
    "ILF Studio or the computer closed unexpectedly. This work is not in a project file yet. It is kept until you "
    "discard it."
)
_RESTORE, _DISCARD = "&Restore", "&Discard…"

_Read = tuple[OpenedProject | None, tuple[str, ...], dict[str, str]]
"""The opened project file, problems, and for each frame that cannot be read why."""


def ask_what_to_do(context: Context, left: RecoverableWork) -> Steps[None]:
    """Ask until unsaved work is restored as the project of the window, after asking about the present one, or is
    discarded, or is to be kept for the next start."""
    name, answer = _name_of(left), _RESTORE
    answers = [(_RESTORE, ACCEPT)] * (not left.problem) + [(_DISCARD, DESTROY)]
    details = "\n".join((_ABOUT, *([left.problem] if left.problem else _details(left))))
    window, title = context.window, "Restore unsaved work"
    while answer:
        answer = yield partial(ask, window, title, f"Unsaved work: {name}", details, answers, cancel="Decide &later")
        if answer == _RESTORE:
            project = context.feature(ProjectFeature)
            if (yield from project.left(f"{name} is restored")):
                yield from project.opening.begin()
                if (yield from _restored(context, left)):
                    return
        elif answer:
            text = f"The unsaved work on {name} is deleted permanently."
            if (yield partial(ask, window, "Discard unsaved work?", text, "", [("&Discard", DESTROY)])):
                try:
                    left.discard()
                except OSError as error:
                    context.notes.report("Not discarded", error)
                else:
                    return


def _name_of(left: RecoverableWork) -> str:
    """Return a display name: the project, the frames, or the folder of work that cannot be read."""
    if left.project:
        return Path(left.project).stem
    names = [frame.name for frame in left.frames or left.read.project.frames]
    more = f" and {len(names) - 3} more" * (len(names) > 3)
    return ", ".join(names[:3]) + more or left.path.name


def _details(left: RecoverableWork) -> list[str]:
    """Describe unsaved work in lines."""
    frames, count = left.frames, counted(len(left.read.project.frames), "frame")
    changed = f"{len(frames)} of {count} changed"
    lines = [changed if frames else f"{count}: no work on frames, but the list or its settings have changed"]
    if left.project:
        lines.append(f"Project {left.project}")
    if left.header is not None:
        lines.append(f"Last change: {left.header.changed.astimezone():%d %B %Y at %H:%M:%S}")
        lines += [f"From computer {left.header.host}"] * (left.header.host != socket.gethostname())
    return [*lines, *left.read.problems]


def _restored(context: Context, left: RecoverableWork) -> Steps[bool]:
    """Make unsaved work the project of a window without frames; return whether that was done. Its folder is deleted
    only after this window has stored the work."""
    name, recorder = _name_of(left), context.recorder
    read = partial(context.loader.read, f"Restore {name}", lambda: _read_work(context, left))
    found: _Read | None = yield lambda go: read(go, go)
    if found is None:
        if isinstance(report := QApplication.activeModalWidget(), QDialog):
            yield report.finished.connect  # not two questions at once
        return False
    opened, problems, left_aside = found
    newer = "" if opened is None else _why_newer(opened.path, left)
    # located files take precedence over the paths in the project file
    places = left.read.places if opened is None else replace(opened.places, given=left.read.places.given)
    # a file that is unreadable or newer may contain none of the work
    unsaved = (left.stored if opened is None or newer else left.changed) - set(left_aside)
    context.feature(ProjectFeature).opening.take(left.read.project, places, opened, unsaved, newer)
    context.notes.warn(f"Restored {name}", [newer] * bool(newer))
    told = [*problems]
    for frame_id, problem in left_aside.items():
        entry = context.workspace.entries.of(frame_id)
        if entry is not None:
            context.workspace.note_problem(entry, problem)
            told.append(f"{entry.name}: {problem} It stays in {left.path}, which is offered again.")
    context.notes.warn("Restored with errors", told)
    if unsaved or not left_aside:
        context.notes.show_message(f"{name} restored: save it to keep it.")
    with contextlib.suppress(Exception):  # such as a frame that cannot be stored: then not all is written
        yield recorder.flush
    if recorder.store.is_written and not left_aside:
        with contextlib.suppress(OSError):
            left.discard()
    return True


def _read_work(context: Context, left: RecoverableWork) -> _Read:
    """Read the work and store it in the window; called in a worker thread."""
    opened, problems = _project_of(left)
    stores: list[Parts] = [left.parts, *([] if opened is None else [opened.parts])]
    copied = copy_frames(stores, left.stored)
    context.recorder.store.adopt(copied)
    return opened, (*left.read.problems, *problems), copied.problems


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
