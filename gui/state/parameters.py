"""Filter and extraction parameters of the workspace, shared by all frames or separate for each, and their commands.

While they are shared, a change is one undo step of the frame where it was made. Undoing it restores the former values
in all frames, even if they were changed from another frame since: all frames without own parameters always have the
same ones.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoCommand

from ilf.data.blocks import OwnValues, own_values
from ilf.data.parameters import DEFAULT_PRESET, BlockParameters, Parameters
from ilf.data.presets import preset
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from .frames import WorkspaceFrames
from .session import Session

OwnChange = Mapping[int, tuple[OwnValues | None, OwnValues | None]]
"""Block label -> its own parameters before and after, None for none."""

DRAG_S = 0.7
"""Changes of the same parameters within this time [s] are one undo step."""


class SharedParameters(NamedTuple):
    """Whether parameters are shared by all frames, and the shared parameters."""

    on: bool
    values: Parameters
    """The next frame starts with these, whether they are shared or not."""

    def applies_to(self, session: Session) -> bool:
        """Whether a frame has the shared parameters."""
        return self.on and not session.state.own_parameters

    def apply_to(self, session: Session) -> None:
        """Set the shared parameters in a restored frame, unless it has its own."""
        if self.applies_to(session):
            session.change(common=self.values)

    def apply_to_all(self, sessions: Iterable[Session], transient: bool = False) -> None:
        """Set the shared parameters in all frames without own ones; with `transient`, undo does not lead back."""
        for session in sessions:
            if self.applies_to(session) and session.state.common != self.values:
                if not transient:
                    session.remember_parameters()
                session.change(common=self.values)


class WorkspaceParameters(QObject):
    """The parameters of all frames, of one frame, or of blocks."""

    changed = Signal()
    """Filter parameters, or how they are shared."""
    extraction_changed = Signal()
    """Extraction parameters, or which blocks an extraction keeps."""
    validity_changed = Signal(object)
    """Other results of a Session, current or not, may be valid now."""

    def __init__(self, frames: WorkspaceFrames, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._frames = frames
        self.shared = SharedParameters(False, preset(DEFAULT_PRESET))
        """Whether parameters are shared, and which; if not, a new frame starts with those of the current frame."""
        self.extraction = BlockParameters()
        """The parameters of the next extraction."""
        self.keeps_handmade = True
        """Whether a new extraction keeps hand-made blocks, as it keeps locked ones."""
        frames.leaving.connect(self._leave)

    @property
    def current(self) -> Parameters:
        """Common parameters of the current frame: those of all blocks without own parameters."""
        return self._frames.session.state.common if self._frames.has_session else self.shared.values

    @property
    def of_next_frame(self) -> Parameters:
        """Parameters that the next frame starts with."""
        return self.shared.values if self.shared.on else self.current

    def _leave(self) -> None:
        """Remember the parameters of the current frame for the next one."""
        self.shared = SharedParameters(self.shared.on, self.of_next_frame)

    def start(self, session: Session, recorded: Run | None = None, restored: bool = False) -> None:
        """Set the parameters of a frame that is about to be opened: those of the next frame, or of a recorded run.

        A `restored` frame keeps its own, unless it shares them.
        """
        if restored:
            self.shared.apply_to(session)
        else:
            session.change(common=self.of_next_frame)
        if recorded is None:
            return
        own_parameters = self.shared.on and recorded.parameters != self.shared.values
        session.change(common=recorded.parameters, own_parameters=own_parameters)
        if recorded.blocks.extraction is not None:
            self.set_extraction(recorded.blocks.extraction)
        labels = session.counts() if recorded.only is None else recorded.only
        own = {label: own_values(recorded.parameters_of(label), recorded.parameters) for label in labels}
        session.change_blocks(own={**session.blocks.own, **{label: values for label, values in own.items() if values}})

    def set(self, parameters: Parameters, blocks: int | Collection[int] | None = None) -> None:
        """Set the common parameters, or those of some blocks, as one undo step.

        For blocks, the values that differ from the common ones become own parameters. Values set while a slider moves
        belong to the same step.
        """
        if blocks is None:
            self._edit((self.current, parameters), {}, own_values(parameters, self.current).keys())
            return
        labels = [blocks] if isinstance(blocks, int) else blocks
        self._edit_own(dict.fromkeys(labels, own_values(parameters, self.current)))

    def set_own(self, values: OwnValues, blocks: Collection[int]) -> None:
        """Add own parameters to blocks; values equal to the common ones are removed."""
        common, own = self.current.to_dict(), self._frames.session.blocks.own
        merged = {label: {**own.get(label, {}), **values} for label in blocks}
        self._edit_own(
            {
                label: {name: value for name, value in one.items() if value != common[name]}
                for label, one in merged.items()
            }
        )

    def reset_own(self, blocks: Collection[int]) -> None:
        """Remove all own parameters from blocks."""
        self._edit_own({label: {} for label in blocks})

    def copy_own(self, source: int, blocks: Collection[int]) -> None:
        """Copy the own parameters of a block to others."""
        values = self._frames.session.blocks.own.get(source, {})
        self._edit_own(dict.fromkeys(blocks, values))

    def _edit_own(self, wanted: Mapping[int, OwnValues]) -> None:
        changes = self._own_changes(wanted)
        self._edit(None, changes, names_in(changes))

    def _own_changes(self, wanted: Mapping[int, OwnValues]) -> OwnChange:
        """Return the changes that give blocks these own parameters."""
        own = self._frames.session.blocks.own
        return {
            label: (own.get(label), values or None)
            for label, values in wanted.items()
            if values != (own.get(label) or {})
        }

    def _edit(
        self,
        common: tuple[Parameters, Parameters] | None,
        own: OwnChange,
        names: Collection[str],
    ) -> None:
        if not names:
            return
        if not self._frames.has_session:
            if common is not None:
                self.set_shared(SharedParameters(self.shared.on, common[1]))
            return
        session = self._frames.session
        stack = session.undo_stack
        last = stack.command(stack.index() - 1) if not stack.isClean() else None
        if isinstance(last, EditParameters) and stack.index() == stack.count() and last.extend(common, own, names):
            session.note_edit()
            self._frames.touched.emit(session)
            return
        what = parameter_labels(names)[0] if len(names) == 1 else f"{len(names)} filter parameters"
        blocks = f" of {session.info(min(own)).name}" if len(own) == 1 else f" of {len(own)} blocks"
        where = blocks if own else self.all_frames_text(session)
        stack.push(EditParameters(self, session, common, own, names, f"Set {what}{where}"))

    def all_frames_text(self, session: Session) -> str:
        """Return the end of the text of an undo step on a frame's common parameters."""
        return " for all frames" if self.shared.applies_to(session) else ""

    def take(
        self, session: Session, common: OwnValues, own: Mapping[int, OwnValues | None], transient: bool = False
    ) -> None:
        """Set some of the common parameters and own parameters of blocks (None for none). Called by commands.

        With `transient`, undo does not lead back to the present ones.
        """
        before = session.valid_results()
        if not transient:
            session.remember_parameters()
        if own:
            merged = {**session.blocks.own, **own}
            session.change_blocks(own={label: values for label, values in merged.items() if values})
        session.change(common=session.state.common.replace(**common))
        if common and self.shared.applies_to(session):
            self.shared = SharedParameters(True, session.state.common)
            self.shared.apply_to_all(self._frames.sessions, transient)
            self._frames.project_touched.emit()
        if self._frames.is_current(session):
            self.changed.emit()
        if session.valid_results() != before:  # results of earlier parameters are valid again
            self.validity_changed.emit(session)

    def take_common(self, session: Session, common: Parameters, own: bool) -> None:
        """Set a frame's common parameters, unless it has the shared ones. Called by commands.

        With `own`, they are its own while parameters are shared by all frames.
        """
        session.change(common=common, own_parameters=own)
        self.shared.apply_to(session)
        if self._frames.is_current(session):
            self.changed.emit()

    def set_shared(self, shared: SharedParameters) -> None:
        """Set whether parameters are shared by all frames, and which; also on loading a project, before its frames."""
        former, self.shared = self.shared, shared
        shared.apply_to_all(self._frames.sessions)
        if former.on and not shared.on:  # from now on they are stored with each frame
            for session in self._frames.sessions:
                if session.counts() or session.unsaved:
                    self._frames.touched.emit(session)
        self.changed.emit()
        self._frames.project_touched.emit()

    def share(self) -> list[Session]:
        """Share the current frame's parameters with all frames without own ones, as one undo step.

        Returns the open frames that had other parameters.
        """
        shared = SharedParameters(True, self.current)
        states = {session: session.state for session in self._frames.sessions}
        others = [one for one, state in states.items() if not state.own_parameters and state.common != self.current]
        self._push_sharing(shared, own=False, text="Use parameters for all frames")
        return [one for one in others if not self._frames.is_current(one)]

    def keep_own(self) -> None:
        """Give the current frame its own parameters while others are shared, as one undo step."""
        self._push_sharing(self.shared, own=True, text="Use parameters for this frame only")

    def reset_to_shared(self) -> None:
        """Reset the current frame to the shared parameters, as one undo step."""
        self._push_sharing(self.shared, own=False, text="Reset to shared parameters")

    def separate(self) -> None:
        """Stop sharing parameters: every frame keeps its current ones as its own, as one undo step."""
        self._push_sharing(SharedParameters(False, self.current), own=False, text="Separate parameters for each frame")

    def _push_sharing(self, shared: SharedParameters, own: bool, text: str) -> None:
        session = self._frames.session
        session.undo_stack.push(ShareParameters(self, self._frames, session, shared, own, text))

    def take_shared(self, shared: SharedParameters, session: Session, common: Parameters, own: bool) -> None:
        """Set whether parameters are shared, the shared ones, and those of one frame. Called by commands."""
        before = session.valid_results()
        session.remember_parameters()
        session.change(common=common, own_parameters=own)
        self.set_shared(shared)
        self._frames.sessions_changed.emit()
        if session.valid_results() != before:
            self.validity_changed.emit(session)

    def restore(self, kept: StoredRun) -> bool:
        """Restore common and own parameters of a stored run in the current frame, as one undo step; False if they are
        the current ones."""
        session, run = self._frames.session, kept.run
        there = set(session.counts()).intersection(np.unique(run.blocks.labels).tolist())
        own = {label: own_values(run.parameters_of(label), run.parameters) for label in there}
        changes = self._own_changes(own)
        names = names_in(changes).union(own_values(run.parameters, session.state.common))
        if not names:
            return False
        common = session.state.common, run.parameters
        text = f"Restore parameters of {kept.name}{self.all_frames_text(session)}"
        session.undo_stack.push(EditParameters(self, session, common, changes, names, text))
        return True

    def set_extraction(self, parameters: BlockParameters) -> None:
        """Set the parameters of the next extraction."""
        self.extraction = parameters
        self.extraction_changed.emit()
        self._frames.project_touched.emit()

    def set_keeps_handmade(self, on: bool) -> None:
        """Set whether the next extraction keeps hand-made blocks."""
        self.keeps_handmade = on
        self.extraction_changed.emit()
        self._frames.project_touched.emit()


def names_in(changes: OwnChange) -> set[str]:
    """Return the names of the parameters that change."""
    return {name for before, after in changes.values() for name in _differing_names(before or {}, after or {})}


class EditParameters(QUndoCommand):
    """A change of the common parameters, or of own parameters of blocks.

    Parameters
    ----------
    common : (Parameters, Parameters) or None
        Before and after; None if unchanged.
    own : mapping of int to (mapping or None, mapping or None)
        Block label -> its own parameters before and after, None for none.
    names : collection of str
        The parameters that change.
    """

    def __init__(
        self,
        host: WorkspaceParameters,
        session: Session,
        common: tuple[Parameters, Parameters] | None,
        own: OwnChange,
        names: Collection[str],
        text: str,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._common = common
        self._own = own
        self._names = frozenset(names)
        self._time = time.monotonic()

    def extend(self, common: tuple[Parameters, Parameters] | None, own: OwnChange, names: Collection[str]) -> bool:
        """Extend the step by new values of the same parameters if they follow quickly, as from a moving slider.

        False if they do not.
        """
        now = time.monotonic()
        same = (self._common is None) == (common is None) and self._own.keys() == own.keys()
        if not same or self._names != frozenset(names) or now - self._time > DRAG_S:
            return False
        if self._common is not None and common is not None:
            self._common = self._common[0], common[1]
        self._own = {label: (self._own[label][0], own[label][1]) for label in own}
        self._time = now
        self._take(1, transient=True)
        return True

    def redo(self) -> None:
        """Apply the change."""
        self._take(1)

    def undo(self) -> None:
        """Undo the change."""
        self._take(0)

    def _take(self, which: int, transient: bool = False) -> None:
        values = {} if self._common is None else self._common[which].to_dict()
        self._host.take(
            self._session,
            {name: value for name, value in values.items() if name in self._names},
            {label: values[which] for label, values in self._own.items()},
            transient,
        )


class ShareParameters(QUndoCommand):
    """A change of sharing: for all frames, or for one only. Undo restores the parameters of the other frames."""

    def __init__(
        self,
        host: WorkspaceParameters,
        frames: WorkspaceFrames,
        session: Session,
        shared: SharedParameters,
        own: bool,
        text: str,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._frames = frames
        self._session = session
        self._shared = shared
        self._common, self._own = session.state.common if own or not shared.on else shared.values, own
        self._former: WeakKeyDictionary[Session, Parameters] = WeakKeyDictionary()

    def redo(self) -> None:
        """Apply the change."""
        self._former = WeakKeyDictionary({session: session.state.common for session in self._frames.sessions})
        self._swap()
        self._mark_separated()

    def undo(self) -> None:
        """Undo the change."""
        self._swap()
        if not self._host.shared.on:
            there = self._frames.sessions
            for session, common in self._former.items():
                if session in there and session.state.common != common:
                    session.remember_parameters()
                    session.change(common=common)
        self._mark_separated(viewing=True)  # restoring an earlier state is no unsaved change

    def _mark_separated(self, viewing: bool = False) -> None:
        """Mark frames that no longer share parameters as changed: their parameters are now stored with them."""
        host, was_shared = self._host, self._shared.on
        for session in self._frames.sessions if was_shared and not host.shared.on else ():
            if session is not self._session and not session.state.own_parameters:
                self._frames.touch(session, viewing)

    def _swap(self) -> None:
        host, session = self._host, self._session
        before = host.shared, session.state.common, session.state.own_parameters
        host.take_shared(self._shared, session, self._common, self._own)
        self._shared, self._common, self._own = before


def _differing_names(one: OwnValues, other: OwnValues) -> set[str]:
    """Return the names whose values differ, or that only one of the two has."""
    return {name for name in {*one, *other} if name not in one or name not in other or one[name] != other[name]}


def parameter_labels(names: Iterable[str]) -> list[str]:
    """Return the labels of parameters, in the order in which they are declared."""
    declarations = Parameters.declarations()
    return [declarations[name].label for name in declarations if name in set(names)]
