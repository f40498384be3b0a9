"""Bringing back what another window has left behind."""

from __future__ import annotations

import contextlib
import uuid
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QObject

from ilf.errors import IlfError
from ilf.project.archive import Parts
from ilf.project.file import OpenedProject, open_project
from ilf.project.journals import LeftWork, copied_frames
from ilf.project.project import ProjectFrame

from ..context import Desk
from .opening import Opening, entry_of


@dataclass(frozen=True, eq=False)
class _Plan:
    """What is to be brought back, and how."""

    left: LeftWork
    alone: bool
    """Whether it is to be the project of a window without any."""
    frames: tuple[ProjectFrame, ...]
    ids: dict[str, str]
    """Id of a frame there -> its id here."""


@dataclass(frozen=True, eq=False)
class _Brought:
    """What has been read, and is stored in this window."""

    opened: OpenedProject | None
    newer: str
    """Why the project's file may hold newer work than what was left; "" if it does not."""
    problems: tuple[str, ...]


class Restoring(QObject):
    """Takes left work into a window: as its project where it has none yet, else its frames are added to those there."""

    def __init__(self, desk: Desk, opening: Opening) -> None:
        super().__init__(desk.window)
        self._desk = desk
        self._opening = opening

    def is_alone(self) -> bool:
        """Whether there is no project yet that what comes back would be added to."""
        return not len(self._desk.workspace.entries) and self._desk.store.project is None

    def restore(self, left: LeftWork, then: Callable[[], None], fail: Callable[[], None]) -> None:
        """Bring it back; `then` is called when it is there, `fail` when it cannot be. It is taken away only when this
        window has stored it."""
        plan = self._plan(left)
        for frame_id in plan.ids.values():
            self._desk.store.expect(frame_id)
        what = f"Restore {name_of(left)}"

        def give_up() -> None:
            self._desk.store.arrived(plan.ids.values())
            fail()

        self._desk.loader.read(
            what, lambda: self._bring(plan), lambda brought: self._take(plan, brought, then), give_up
        )

    def _plan(self, left: LeftWork) -> _Plan:
        entries, alone = self._desk.workspace.entries, self.is_alone()
        is_of_this = (
            left.note is not None and bool(left.note.project) and left.note.project == self._desk.recorder.project
        )
        frames = left.frames if is_of_this else left.read.project.frames
        ids = {frame.id: frame.id if entries.of(frame.id) is None else uuid.uuid4().hex for frame in frames}
        return _Plan(left, alone, frames, ids)

    def _bring(self, plan: _Plan) -> _Brought:
        """Called off the GUI's thread."""
        left = plan.left
        opened, problems = _project_of(left)
        newer = "" if opened is None else _why_newer(opened.path, left)
        stores: list[Parts] = [left.parts]
        wanted = {former: frame_id for former, frame_id in plan.ids.items() if former in left.stored}
        if opened is not None and not plan.alone:
            stores.append(opened.parts)
            wanted |= {frame.id: plan.ids[frame.id] for frame in plan.frames if frame.has_state}
        copied = copied_frames(stores, wanted)
        self._desk.store.keep(copied.put, copied.refers)
        if opened is not None and not plan.alone:
            opened.close()
        return _Brought(opened, newer, (*left.read.problems, *problems, *copied.problems))

    def _take(self, plan: _Plan, brought: _Brought, then: Callable[[], None]) -> None:
        desk, left, ids = self._desk, plan.left, plan.ids
        given = left.read.places.given  # files that were found again are found there, whatever the project's file says
        if plan.alone:
            places = left.read.places if brought.opened is None else replace(brought.opened.places, given=given)
            # a file that cannot be read, or is not the one that was saved to, holds none of it for certain
            unsaved = left.stored if brought.opened is None or brought.newer else left.changed
            self._opening.take_back(left.read.project, places, brought.opened, unsaved, brought.newer)
            desk.notes.warn(f"Restored {name_of(left)}", [brought.newer] * bool(brought.newer))
        else:
            desk.store.places = replace(desk.store.places, given={**given, **desk.store.places.given})
            new = [entry_of(_under(frame, ids[frame.id]), unsaved=True) for frame in plan.frames]
            desk.workspace.add_entries(new)
            if new:
                present = ids.get(left.read.project.present)
                desk.loader.open_entry(next((entry for entry in new if entry.id == present), new[0]))
        desk.notes.warn("Restored, but not all of it", brought.problems)
        desk.recorder.settle(lambda _: self._let_go(plan))
        then()

    def _let_go(self, plan: _Plan) -> None:
        """All frames are in this window's list by now. What they come from is not needed any more once they are in its
        own journal, too; else it is offered again the next time."""
        self._desk.store.arrived(plan.ids.values())
        left = plan.left
        if self._desk.store.is_written:
            with contextlib.suppress(OSError):
                left.discard()
        else:
            left.release()


def _under(frame: ProjectFrame, frame_id: str) -> ProjectFrame:
    """A frame under this id, called otherwise where its own id is taken by what has become of it here."""
    return frame if frame.id == frame_id else replace(frame, id=frame_id, name=f"{frame.name} (restored)")


def name_of(left: LeftWork) -> str:
    """What to call it: its project, or its frames."""
    if left.note is not None and left.note.project:
        return Path(left.note.project).stem
    frames = left.frames or left.read.project.frames
    names = [frame.name for frame in frames]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _project_of(left: LeftWork) -> tuple[OpenedProject | None, tuple[str, ...]]:
    """The project's file, if it has one that can be read; and what is wrong with it."""
    path = "" if left.note is None else left.note.project
    if not path:
        return None, ()
    without = [frame for frame in left.read.project.frames if frame.has_state and frame.id not in left.stored]
    lost = f" The work on {len(without)} frames that was in it alone is not there." if without else ""
    try:
        opened = open_project(path)
    except IlfError as error:
        return None, (f"{error}{lost} Save the project under a new name.",)
    return opened, opened.problems


def _why_newer(path: Path, left: LeftWork) -> str:
    """Why a project's file must not be replaced unasked: it has been saved since the work was left."""
    with contextlib.suppress(OSError):
        if left.note is not None and path.stat().st_mtime > left.note.changed.timestamp():
            return (
                f"{path.name} has been saved again since this work was left, and may hold newer work: Save asks for "
                "another place."
            )
    return ""
