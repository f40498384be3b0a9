"""Restoring of unsaved work of another window."""

from __future__ import annotations

import contextlib
import uuid
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
from pathlib import Path

from ilf._runtime.formatting import counted
from ilf.errors import IlfError
from ilf.project.archive import Parts
from ilf.project.file import OpenedProject, open_project
from ilf.project.recovery import RecoverableWork, copy_frames
from ilf.sources.named_places import may_look_at, named_in

from ..context import Context
from .feature import ProjectFeature
from .opening import entry_of


class Restoring:
    """Restores unsaved work in a window: as its project if it has none, else by adding the frames to its list."""

    def __init__(self, context: Context, left: RecoverableWork) -> None:
        self._context, self._left, self._alone = context, left, has_no_project(context)
        is_of_this = bool(left.project) and left.project == context.recorder.present.file
        self._frames = left.frames if is_of_this else left.read.project.frames
        entries = context.workspace.entries
        self._ids = {one.id: one.id if entries.of(one.id) is None else uuid.uuid4().hex for one in self._frames}
        """Id of a frame in the unsaved work -> its id in this window."""

    def restore(self, then: Callable[[], None], fail: Callable[[], None]) -> None:
        """Restore the work; call `then` on success, `fail` otherwise. The folder is deleted only after this window has
        stored the work."""
        take = partial(self._take, then=then)
        self._context.loader.read(f"Restore {name_of(self._left)}", self._read_work, take, fail)

    def _read_work(self) -> tuple[OpenedProject | None, tuple[str, ...], dict[str, str]]:
        """Read the work and store it in this window; called in a worker thread.

        Returns the opened project file, problems, and for each frame that cannot be read, by its id in this window,
        why.
        """
        left = self._left
        opened, problems = _project_of(left)
        stores: list[Parts] = [left.parts]
        wanted = {former: frame_id for former, frame_id in self._ids.items() if former in left.stored}
        if opened is not None:
            stores.append(opened.parts)
        if opened is not None and not self._alone:
            wanted |= {frame.id: self._ids[frame.id] for frame in self._frames if frame.has_state}
        copied = copy_frames(stores, wanted)
        self._context.recorder.store.adopt(copied)
        if opened is not None and not self._alone:
            opened.close()
        return opened, (*left.read.problems, *problems), copied.problems

    def _take(
        self, read: tuple[OpenedProject | None, tuple[str, ...], dict[str, str]], then: Callable[[], None]
    ) -> None:
        context, left = self._context, self._left
        opened, problems, left_aside = read
        if self._alone:
            self._take_project(opened, left_aside)
        else:
            self._add_frames(left_aside)
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

    def _take_project(self, opened: OpenedProject | None, left_aside: Collection[str]) -> None:
        """Make the work the project of this window."""
        left, newer = self._left, "" if opened is None else _why_newer(opened.path, self._left)
        # located files take precedence over the paths in the project file
        places = left.read.places if opened is None else replace(opened.places, given=left.read.places.given)
        # a file that is unreadable or newer may contain none of the work
        unsaved = (left.stored if opened is None or newer else left.changed) - set(left_aside)
        opening = self._context.feature(ProjectFeature).opening
        opening.take(left.read.project, places, opened, unsaved, newer)
        self._context.notes.warn(f"Restored {name_of(left)}", [newer] * bool(newer))

    def _add_frames(self, left_aside: Collection[str]) -> None:
        """Add the frames to the list of this window."""
        context, read, ids = self._context, self._left.read, self._ids
        store = context.recorder.store
        given = {**read.places.given, **store.places.given}
        store.places = replace(store.places, given=given, stated_in=store.places.stated_in or "")
        new = []
        for frame in self._frames:
            id = ids[frame.id]
            here = frame if id == frame.id else replace(frame, id=id, name=f"{frame.name} (restored)")
            new.append(entry_of(here, id not in left_aside))
        context.workspace.add_entries(new)
        if new:
            present = ids.get(read.project.present)
            context.loader.open_entry(next((entry for entry in new if entry.id == present), new[0]))


def has_no_project(context: Context) -> bool:
    """Return whether a window has no project that restored work would be added to."""
    return not len(context.workspace.entries) and context.recorder.store.project is None


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
