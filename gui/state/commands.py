"""Undoable commands. Each is one undo step with a text that describes it."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoCommand

from ilf._runtime.formatting import counted
from ilf.data.blocks import Box
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult
from ilf.project.frame_state import BlockNotes, FrameState, OwnValues, own_values
from ilf.project.run_history import StoredRun
from ilf.segmentation.editing.patches import LabelPatch, patch_between, redrawn

from .results import FrameResults
from .session import Session, touched_by

Mask = NDArray[np.bool_]

OwnChange = Mapping[int, tuple[OwnValues | None, OwnValues | None]]
"""Block label -> its own parameters before and after, None for none."""

DRAG_S = 0.7
"""Changes of the same parameters within this time [s] are one undo step."""


DrawnChange = tuple[Box, Mask, Mask]
"""Where drawn borders change, and the drawn pixels there before and after."""


class Change(NamedTuple):
    """An edit of a label map that was made, undone or redone.

    Attributes
    ----------
    session : Session
    patch : LabelPatch
        The edit in forward direction.
    forward : bool
        False if it was undone.
    text : str
        The name of the edit.
    drawn : (Box, ndarray of bool, ndarray of bool)
        Where drawn borders change, and the drawn pixels there before the edit and after it.
    """

    session: Session
    patch: LabelPatch
    forward: bool
    text: str
    drawn: DrawnChange

    @property
    def blocks(self) -> frozenset[int]:
        """Blocks that gained or lost pixels."""
        return touched_by(self.patch)


class CommandHost(Protocol):
    """The object that a command notifies before and after it changes a session."""

    def prepare_change(self, session: Session) -> None:
        """The label map is about to change."""
        ...

    def note_labels_changed(self, session: Session, patch: LabelPatch | None, change: Change | None = None) -> None:
        """The label map has changed; with `change`, by an edit."""
        ...

    def note_infos_changed(self, session: Session) -> None:
        """A name, colour or lock has changed."""
        ...

    def note_results_changed(self, session: Session) -> None:
        """Results were removed or restored."""
        ...

    def note_invalid_mask_changed(self, session: Session) -> None:
        """The invalid mask has changed."""
        ...

    def note_guide_changed(self, session: Session) -> None:
        """The guide has changed or was removed."""
        ...

    def take_parameters(
        self, session: Session, common: OwnValues, own: Mapping[int, OwnValues | None], transient: bool = False
    ) -> None:
        """Set some of the common parameters and own parameters of blocks (None for none); with `transient`, undo does
        not lead back to the present ones."""
        ...


class EditLabels(QUndoCommand):
    """A change of the label map.

    New borders become drawn borders. With `notes`, they do not: the attributes of the blocks change too, as when all
    blocks are replaced. With `done`, the map is already changed (a brush paints while it moves).
    """

    def __init__(
        self,
        host: CommandHost,
        session: Session,
        patch: LabelPatch,
        text: str,
        done: bool = False,
        notes: BlockNotes | None = None,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._patch = patch
        self._done = done
        self._other_notes = notes
        self._other_to_check = session.to_check
        if session.to_check:
            self._other_to_check = session.to_check & notes.kept if notes else session.to_check - touched_by(patch)
        self._drawn: DrawnChange | None = None
        """Where drawn borders change, and the drawn pixels there before and after."""
        if notes is None:
            former = session.notes.drawn
            box, drawn = redrawn(former, session.labels, patch)
            self._drawn = box, np.zeros_like(drawn) if former is None else former[box].copy(), drawn

    def redo(self) -> None:
        """Apply the change."""
        if not self._done:
            self._host.prepare_change(self._session)
            self._session.apply(self._patch)
        self._done = False
        self._notify(forward=True)

    def undo(self) -> None:
        """Undo the change."""
        self._host.prepare_change(self._session)
        self._session.apply(self._patch, forward=False)
        self._notify(forward=False)

    def _notify(self, forward: bool) -> None:
        session, change = self._session, None
        session.to_check, self._other_to_check = self._other_to_check, session.to_check
        if self._other_notes is not None:
            self._other_notes = session.take_notes(self._other_notes)
        elif self._drawn is not None:
            box, before, after = self._drawn
            change = Change(session, self._patch, forward, self.text(), self._drawn)
            session.draw(box, after if forward else before, change.blocks)
        self._host.note_labels_changed(session, self._patch, change)


class EditInfo(QUndoCommand):
    """A change of blocks' names, colours or locks."""

    def __init__(
        self, host: CommandHost, session: Session, changes: Mapping[int, Mapping[str, Any]], text: str
    ) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._before = {
            label: {name: getattr(session.info(label), name) for name in values} for label, values in changes.items()
        }
        self._after = changes

    def redo(self) -> None:
        """Apply the change."""
        self._change(self._after)

    def undo(self) -> None:
        """Undo the change."""
        self._change(self._before)

    def _change(self, changes: Mapping[int, Mapping[str, Any]]) -> None:
        for label, values in changes.items():
            self._session.change_info(label, **values)
        self._host.note_infos_changed(self._session)


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
        host: CommandHost,
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
        self._host.take_parameters(
            self._session,
            {name: value for name, value in values.items() if name in self._names},
            {label: values[which] for label, values in self._own.items()},
            transient,
        )


class ClearResults(QUndoCommand):
    """Removal of all results of a frame. Undo restores them; results of later runs stay."""

    def __init__(self, host: CommandHost, session: Session) -> None:
        super().__init__("Clear results")
        self._host = host
        self._session = session
        self._cleared = FrameResults({})

    def redo(self) -> None:
        """Apply the change."""
        self._cleared = self._session.swap_results(FrameResults({}))
        self._host.note_results_changed(self._session)

    def undo(self) -> None:
        """Undo the change."""
        newer = self._session.swap_results(FrameResults({}))
        self._session.swap_results(self._cleared.with_newer(newer))
        self._host.note_results_changed(self._session)


class MarkInvalid(QUndoCommand):
    """A change of the frame's invalid mask."""

    def __init__(self, host: CommandHost, session: Session, frame: RGBDFrame, text: str) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._other = frame

    def redo(self) -> None:
        """Apply the change."""
        former = self._session.frame
        self._session.take_frame(self._other)
        self._other = former
        self._notify()

    undo = redo

    def _notify(self) -> None:
        self._host.note_invalid_mask_changed(self._session)


class TakeGuide(MarkInvalid):
    """A change or removal of the frame's guide."""

    def _notify(self) -> None:
        self._host.note_guide_changed(self._session)


# Undoable commands on propagated blocks: take them over, mark them as checked.


class PropagateNotices(CommandHost, Protocol):
    """`CommandHost` that also handle common parameters and blocks to check."""

    def take_common(self, session: Session, common: Parameters, own: bool) -> None:
        """Set a frame's common parameters; `own`: they are its own while parameters are shared by all frames."""
        ...

    def note_checked(self, session: Session) -> None:
        """The set of blocks to check has changed."""
        ...


class PropagateBlocks(QUndoCommand):
    """Transfer of propagated blocks to a frame, with all their attributes and parameters."""

    def __init__(self, host: PropagateNotices, session: Session, propagated: FrameState, text: str) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._patch = patch_between(session.labels, propagated.labels)
        notes = propagated.notes
        self._notes = replace(notes, infos=dict(notes.infos), own=dict(notes.own))
        self._common, self._own, self._extrapolate = (
            propagated.common,
            propagated.own_parameters,
            propagated.extrapolate,
        )
        self._to_check = set(propagated.to_check)

    def redo(self) -> None:
        """Apply the change."""
        self._swap(forward=True)

    def undo(self) -> None:
        """Undo the change."""
        self._swap(forward=False)

    def _swap(self, forward: bool) -> None:
        session = self._session
        self._host.prepare_change(session)
        if self._patch is not None:
            session.apply(self._patch, forward)
        self._notes = session.take_notes(self._notes)
        session.to_check, self._to_check = self._to_check, session.to_check
        session.extrapolate, self._extrapolate = self._extrapolate, session.extrapolate
        common, own = session.common, session.own_parameters
        self._host.take_common(session, self._common, self._own)
        self._common, self._own = common, own
        self._host.note_checked(session)
        self._host.note_labels_changed(session, self._patch)


class MarkChecked(QUndoCommand):
    """Marking of propagated blocks as checked."""

    def __init__(self, host: PropagateNotices, session: Session, blocks: Collection[int]) -> None:
        name = session.info(next(iter(blocks))).name if len(blocks) == 1 else counted(len(blocks), "block")
        super().__init__(f"Mark {name} as checked")
        self._host = host
        self._session = session
        self._blocks = frozenset(blocks)

    def redo(self) -> None:
        """Apply the change."""
        self._session.to_check = self._session.to_check - self._blocks
        self._host.note_checked(self._session)

    def undo(self) -> None:
        """Undo the change."""
        self._session.to_check = self._session.to_check | self._blocks
        self._host.note_checked(self._session)


# Undoable commands on the run history: delete runs, accept the results of a run.


class RunHistoryHost(CommandHost, Protocol):
    """`CommandHost` that also handle the run history."""

    def take_run_history(self, session: Session, runs: list[StoredRun], compared: list[StoredRun]) -> None:
        """Replace the run history and the compared runs."""
        ...


class DeleteRuns(QUndoCommand):
    """Deletion of runs from the history. Undo restores them; later runs stay."""

    def __init__(self, host: RunHistoryHost, session: Session, runs: Collection[StoredRun]) -> None:
        super().__init__(f"Delete {next(iter(runs)).name}" if len(runs) == 1 else f"Delete {len(runs)} runs")
        self._host = host
        self._session = session
        self._runs = list(runs)
        self._compared = [kept for kept in session.compared if kept in runs]

    def redo(self) -> None:
        """Apply the change."""
        session, runs = self._session, self._runs
        self._host.take_run_history(
            session,
            [kept for kept in session.run_history if kept not in runs],
            [kept for kept in session.compared if kept not in runs],
        )

    def undo(self) -> None:
        """Undo the change."""
        session = self._session
        runs = sorted([*session.run_history, *self._runs], key=lambda kept: kept.number)
        self._host.take_run_history(session, runs, [*session.compared, *self._compared])


class AcceptRun(QUndoCommand):
    """Replacement of the current results by those of a stored run, with its parameters."""

    def __init__(
        self, host: CommandHost, session: Session, kept: StoredRun, results: Collection[BlockResult], text: str
    ) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._kept = kept
        self._results = list(results)
        self._before, self._accepted = FrameResults({}), FrameResults({})
        common = kept.run.parameters
        self._common = session.common.to_dict(), common.to_dict()
        own = session.notes.own
        after = {
            result.block.label: None if result.parameters.same_effect(common) else own_values(result.parameters, common)
            for result in results
        }
        self._own = {label: (own.get(label), values) for label, values in after.items()}

    def redo(self) -> None:
        """Apply the change."""
        self._take(1)
        self._before = self._session.restore_results(self._results, self._kept.extrapolation)
        self._accepted = self._session.results.snapshot()
        self._host.note_results_changed(self._session)

    def undo(self) -> None:
        """Undo the change; later results stay."""
        self._take(0)
        newer = self._session.swap_results(FrameResults({})).without(self._accepted)
        self._session.swap_results(self._before.with_newer(newer))
        self._host.note_results_changed(self._session)

    def _take(self, which: int) -> None:
        own: Mapping[int, OwnValues | None] = {label: values[which] for label, values in self._own.items()}
        self._host.take_parameters(self._session, self._common[which], own)
