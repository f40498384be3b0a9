"""Blocks of the workspace and their attributes, the frame's invalid mask, guide and the like, and their commands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal, SignalInstance
from PySide6.QtGui import QUndoCommand

from ilf._runtime.formatting import counted
from ilf.data.blocks import BlockInfo
from ilf.data.frame import GroundTruthFile, RGBDFrame
from ilf.data.guide import Guide
from ilf.data.label_map import Box
from ilf.data.neighbours import NeighbourDepth
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import block_colour
from ilf.evaluation.quality.ignored import IgnoredPlace, ignore
from ilf.evaluation.quality.places import Place
from ilf.project.frame_state import FrameState
from ilf.segmentation.editing.patches import LabelPatch, patch_between, redrawn
from ilf.segmentation.extraction import Extraction
from ilf.segmentation.reextraction import fill_around, overlay_kept

from .block_notes import BlockNotes
from .frames import WorkspaceFrames
from .parameters import WorkspaceParameters
from .results import BlockErrors, same_depth, same_mask
from .session import Session, touched_by
from .stroke import StrokeInProgress

DrawnChange = tuple[Box, NDArray[np.bool_], NDArray[np.bool_]]
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


class KeptBlocks(NamedTuple):
    """How many blocks a new extraction kept, and whether there are no others."""

    locked: int
    by_hand: int
    all_of_them: bool


class WorkspaceBlocks(QObject):
    """The blocks of the frames (label maps, attributes, selection), and the frame's invalid mask, guide,
    depth of neighbours, ground truth and rectangle."""

    about_to_change = Signal()
    """The current frame or its label map is about to change: strokes in progress must end."""
    labels_changed = Signal(object)
    """The box (rows, columns) of the label map that changed."""
    stroke_changed = Signal(object)
    """The same, by a stroke in progress, which may still be cancelled."""
    edited = Signal(object)
    """An edit of the label map was made, undone or redone: a `Change`."""
    replaced = Signal()
    """All blocks of the current frame were replaced, or restored by undo; not an edit."""
    infos_changed = Signal()
    selection_changed = Signal()
    invalid_mask_changed = Signal()
    """The invalid mask of the current frame has changed."""
    guide_changed = Signal()
    """The guide of the current frame has changed or was removed."""
    neighbours_changed = Signal()
    """The depth of neighbours of the current frame has changed or was removed."""
    ground_truth_changed = Signal()
    """The ground truth of the current frame has changed or was removed."""
    block_errors_changed = Signal()
    """The known errors of blocks have changed."""
    ignored_changed = Signal()
    """Flagged places of the current frame are ignored, or not any more."""
    region_changed = Signal()
    """The rectangle of the current frame has changed or was removed."""
    validity_changed = Signal(object)
    """Other results of a Session, current or not, may be valid now."""

    def __init__(self, frames: WorkspaceFrames, parameters: WorkspaceParameters, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._frames = frames
        self._parameters = parameters
        self._stroke: StrokeInProgress | None = None
        frames.leaving.connect(self._end_strokes)

    # selection and strokes

    @property
    def chosen(self) -> int:
        """The first selected block, which edits and curves use; 0 for none."""
        return self._frames.session.selected[0] if self._frames.has_session and self._frames.session.selected else 0

    def select(self, labels: list[int]) -> None:
        """Select blocks; edits and curves use the first one."""
        if self._frames.has_session:
            self._select(self._frames.session, labels)

    def _select(self, session: Session, labels: list[int]) -> None:
        if labels != session.selected:
            session.selected = labels
            if self._frames.is_current(session):
                self.selection_changed.emit()

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke; `end_stroke` makes it an undo step, `drop_stroke` cancels it."""
        if patch is None:
            return
        if self._stroke is None:
            self._stroke = StrokeInProgress(self._frames.session.labels)
        self._stroke.reach(patch.box)
        self._frames.session.apply(patch)
        self.stroke_changed.emit(patch.box)

    @property
    def stroke_in_progress(self) -> bool:
        """Whether a stroke is in progress."""
        return self._stroke is not None

    @property
    def stroke_so_far(self) -> LabelPatch | None:
        """What the stroke in progress has changed; None for nothing."""
        return None if self._stroke is None else self._stroke.patch(self._frames.session.labels)

    def end_stroke(self, text: str) -> LabelPatch | None:
        """Make the stroke one undo step and return what it changed; None for nothing."""
        patch = self._take_stroke()
        if patch is not None:
            self._frames.session.undo_stack.push(EditLabels(self, self._frames.session, patch, text, done=True))
        return patch

    def drop_stroke(self) -> bool:
        """Restore the pixels of the stroke in progress; False if there is none."""
        patch = self._take_stroke()
        if patch is None:
            return False
        self._frames.session.apply(patch, forward=False)
        self.stroke_changed.emit(patch.box)
        return True

    def _take_stroke(self) -> LabelPatch | None:
        patch, self._stroke = self.stroke_so_far, None
        return patch

    def _end_strokes(self) -> None:
        self.about_to_change.emit()
        self.drop_stroke()

    # extraction and edits

    def set_first(self, session: Session, extraction: Extraction, used: BlockParameters) -> None:
        """Set the first blocks of a frame that was opened without any; an undo step only if it has been edited
        since."""
        if session.undo_stack.count() or session.counts():
            self.set_extracted(session, extraction, used)
            return
        session.take_notes(BlockNotes(extraction=used, network=extraction.network, extracted=extraction.blocks.copy()))
        session.set_labels(extraction.blocks)
        self._frames.touch(session, viewing=True)
        if self._frames.is_current(session):
            self.labels_changed.emit((slice(0, session.labels.shape[0]), slice(0, session.labels.shape[1])))
            self.replaced.emit()
        self.validity_changed.emit(session)

    def set_extracted(self, session: Session, extraction: Extraction, used: BlockParameters) -> KeptBlocks:
        """Replace the blocks by those of another extraction as one undo step; locked and hand-made blocks stay."""
        self.prepare_change(session)
        locked, by_hand = self.staying(session)
        kept, handmade = locked | by_hand, session.handmade()
        labels = extraction.blocks
        around = fill_around(session.labels, kept, labels, used.smallest_block(labels.size))
        # a block that was only locked is not hand-made: a later extraction replaces it once it is unlocked
        notes = BlockNotes({}, {}, None, used, extraction.network, around.copy(), kept, handmade & kept)
        self._replace(session, around, "Extract blocks", notes)
        return KeptBlocks(len(locked), len(by_hand), kept == set(session.counts()))

    def staying(self, session: Session) -> tuple[frozenset[int], frozenset[int]]:
        """Return the blocks that a new extraction keeps: locked ones, and other hand-made ones."""
        locked = session.locked & set(session.counts())
        return locked, session.handmade() - locked if self._parameters.keeps_handmade else frozenset()

    def replace(self, labels: NDArray[np.int32], text: str, names: Mapping[int, str] | None = None) -> None:
        """Replace the current frame's label map, with names of blocks, as one undo step.

        Locked blocks stay, with their names; new blocks with the same labels get other labels.
        """
        session = self._frames.session
        self.prepare_change(session)
        locked = session.locked
        around = overlay_kept(session.labels, locked, labels)
        free = ~np.isin(session.labels, list(locked))
        numbers, first = np.unique(labels[free], return_index=True)
        become = zip(numbers.tolist(), around[free][first].tolist(), strict=True)
        named = {label: names[number] for number, label in become if names and number in names}
        if np.array_equal(around, session.labels):
            renamed = {label: {"name": name} for label, name in named.items() if session.info(label).name != name}
            if renamed:
                self.edit_infos(renamed, text)
        infos = {label: BlockInfo(name, block_colour(label)) for label, name in named.items()}
        self._replace(session, around, text, BlockNotes(infos, kept=locked))

    def _replace(self, session: Session, labels: NDArray[np.int32], text: str, notes: BlockNotes) -> None:
        """Replace label map and attributes; blocks that are kept keep their attributes."""
        old, patch = session.notes, patch_between(session.labels, labels)
        if patch is None:
            session.take_notes(replace(notes, infos=old.infos, own=old.own, drawn=old.drawn))
            self.validity_changed.emit(session)
            return
        notes.infos |= {label: info for label, info in old.infos.items() if label in notes.kept}
        notes.own = {label: own for label, own in old.own.items() if label in notes.kept}
        notes.drawn = None if old.drawn is None else old.drawn & np.isin(labels, list(notes.kept))
        session.undo_stack.push(EditLabels(self, session, patch, text, notes=notes))

    def edit(self, patch: LabelPatch | None, text: str) -> bool:
        """Change the label map as one undo step; False if there is nothing to change."""
        if patch is None:
            return False
        self._frames.session.undo_stack.push(EditLabels(self, self._frames.session, patch, text))
        return True

    def start(self) -> int:
        """Select and return an unused label, to be painted."""
        label = self._frames.session.next_label()
        self._frames.session.info(label)
        self.select([label])
        return label

    def edit_info(self, label: int, text: str, **changes: Any) -> None:
        """Rename, recolour or lock a block as one undo step."""
        self.edit_infos({label: changes}, text)

    def edit_infos(self, changes: Mapping[int, Mapping[str, Any]], text: str) -> None:
        """Rename, recolour or lock blocks as one undo step."""
        self._frames.session.undo_stack.push(EditInfo(self, self._frames.session, changes, text))

    def set_lock(self, label: int, locked: bool) -> None:
        """Lock or unlock a block as one undo step."""
        name = self._frames.session.info(label).name
        self.edit_info(label, f"{'Lock' if locked else 'Unlock'} {name}", locked=locked)

    def set_visible(self, label: int, visible: bool) -> None:
        """Show or hide a block in the overlay; not undoable."""
        self._frames.session.change_info(label, visible=visible)
        self._frames.touch(self._frames.session)
        self.infos_changed.emit()

    def set_invalid_mask(self, mask: NDArray[np.bool_] | None, text: str) -> bool:
        """Set the invalid mask, bool (H, W), as one undo step; False if it is the same already.

        Raises
        ------
        InputError
            If no valid depth would be left.
        """
        session = self._frames.session
        frame = session.frame.with_invalid_mask(mask)
        if same_mask(session.frame.invalid_mask, frame.invalid_mask):
            return False
        return self._take_frame(frame, text, self.invalid_mask_changed)

    def set_guide(self, guide: Guide | None, text: str) -> bool:
        """Set or remove the guide as one undo step; False if it is equal to the present one.

        Raises
        ------
        InputError
            If its aspect ratio differs from the frame's.
        """
        session = self._frames.session
        frame = session.frame.with_guide(guide)
        if same_depth(session.frame.guide, frame.guide):
            return False
        return self._take_frame(frame, text, self.guide_changed)

    def set_neighbours(self, neighbours: NeighbourDepth | None, text: str) -> bool:
        """Set or remove the depth of neighbours as one undo step; False if it is equal to the present one."""
        session = self._frames.session
        if same_depth(session.frame.neighbours, neighbours):
            return False
        frame = session.frame.with_neighbours(neighbours)
        return self._take_frame(frame, text, self.neighbours_changed)

    def set_region(self, box: Box | None) -> None:
        """Set or remove the current frame's rectangle (rows, columns)."""
        if box != self._frames.session.region:
            self._frames.session.region = box
            self._frames.touch(self._frames.session, viewing=True)
            self.region_changed.emit()

    def set_ground_truth(self, ground_truth: NDArray[np.float32] | None, file: GroundTruthFile | None = None) -> None:
        """Set or remove the current frame's ground truth [m], float32 (H, W), NaN unknown.

        `file` is the file that it was read from.

        Raises
        ------
        InputError
            If it does not fit the frame.
        """
        self._frames.session.take_ground_truth(ground_truth, file)
        self._frames.touch(self._frames.session)
        self.ground_truth_changed.emit()

    def set_block_errors(self, session: Session, errors: BlockErrors) -> None:
        """Set the known errors of blocks."""
        if errors != session.block_errors:
            session.block_errors = errors
            if self._frames.is_current(session):
                self.block_errors_changed.emit()

    def take_propagated(self, session: Session, propagated: FrameState, text: str) -> None:
        """Take over the blocks propagated to a frame, with all their attributes, as one undo step."""
        self.prepare_change(session)
        session.undo_stack.push(PropagateBlocks(self, self._parameters, session, propagated, text))
        if not session.selected:
            self._select(session, list(propagated.selected))

    def mark_checked(self, blocks: Collection[int]) -> None:
        """Mark blocks of the current frame as checked, as one undo step."""
        unseen = self._frames.session.to_check.intersection(blocks)
        if unseen:
            self._frames.session.undo_stack.push(MarkChecked(self, self._frames.session, unseen))

    def ignore_place(self, place: Place) -> None:
        """Ignore a flagged place of the current frame, as one undo step."""
        session = self._frames.session
        rest = (other for other in session.ignored if not other.is_at(place))
        ignored = (*rest, ignore(place, session.frame, session.labels))
        session.undo_stack.push(IgnorePlace(self, session, ignored))

    # notifications from commands

    def prepare_change(self, session: Session) -> None:
        """End strokes before the label map of a session changes."""
        if self._frames.is_current(session):
            self._end_strokes()

    def note_labels_changed(self, session: Session, patch: LabelPatch | None, change: Change | None = None) -> None:
        """Called by commands after the label map or block attributes have changed; with `change`, by an edit."""
        if self._frames.is_current(session):
            if patch is not None:
                left = session.counts()
                # a new block that is not painted yet stays selected
                gone = [
                    label
                    for label in session.selected
                    if label not in left and ((patch.before == label).any() or (patch.after == label).any())
                ]
                self.labels_changed.emit(patch.box)
                if gone:
                    self.select([label for label in session.selected if label not in gone])
            if change is None:
                self.replaced.emit()
            else:
                self.edited.emit(change)
        self.validity_changed.emit(session)

    def _take_frame(self, frame: RGBDFrame, text: str, changed: SignalInstance) -> bool:
        """Put a frame in place of the current one, as one undo step."""
        session = self._frames.session
        session.undo_stack.push(TakeFrame(session, frame, text, partial(self._note_depth_changed, changed)))
        return True

    def _note_depth_changed(self, changed: SignalInstance, session: Session) -> None:
        if self._frames.is_current(session):
            changed.emit()
        self.validity_changed.emit(session)

    def note_checked(self, session: Session) -> None:
        """Called by commands after the set of blocks to check has changed."""
        self.note_infos_changed(session)
        self._frames.sessions_changed.emit()

    def note_ignored_changed(self, session: Session) -> None:
        """Called by commands after the set of ignored places has changed."""
        if self._frames.is_current(session):
            self.ignored_changed.emit()

    def note_infos_changed(self, session: Session) -> None:
        """Called by commands after a name, colour or lock has changed."""
        if self._frames.is_current(session):
            self.infos_changed.emit()


class EditLabels(QUndoCommand):
    """A change of the label map.

    New borders become drawn borders. With `notes`, they do not: the attributes of the blocks change too, as when all
    blocks are replaced. With `done`, the map is already changed (a brush paints while it moves).
    """

    def __init__(
        self,
        host: WorkspaceBlocks,
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
        self, host: WorkspaceBlocks, session: Session, changes: Mapping[int, Mapping[str, Any]], text: str
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


class TakeFrame(QUndoCommand):
    """A change of the frame's invalid mask, guide or depth of neighbours. `notify` is called after it."""

    def __init__(self, session: Session, frame: RGBDFrame, text: str, notify: Callable[[Session], None]) -> None:
        super().__init__(text)
        self._session = session
        self._other = frame
        self._notify = notify

    def redo(self) -> None:
        """Apply the change."""
        former = self._session.frame
        self._session.take_frame(self._other)
        self._other = former
        self._notify(self._session)

    undo = redo


class PropagateBlocks(QUndoCommand):
    """Transfer of propagated blocks to a frame, with all their attributes and parameters."""

    def __init__(
        self,
        host: WorkspaceBlocks,
        parameters: WorkspaceParameters,
        session: Session,
        propagated: FrameState,
        text: str,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._parameters = parameters
        self._session = session
        self._patch = patch_between(session.labels, propagated.blocks.labels)
        self._notes = BlockNotes.of(propagated.blocks)
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
        self._parameters.take_common(session, self._common, self._own)
        self._common, self._own = common, own
        self._host.note_checked(session)
        self._host.note_labels_changed(session, self._patch)


class MarkChecked(QUndoCommand):
    """Marking of propagated blocks as checked."""

    def __init__(self, host: WorkspaceBlocks, session: Session, blocks: Collection[int]) -> None:
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


class IgnorePlace(QUndoCommand):
    """Ignoring of a flagged place."""

    def __init__(self, host: WorkspaceBlocks, session: Session, ignored: tuple[IgnoredPlace, ...]) -> None:
        super().__init__("Ignore flagged place")
        self._host = host
        self._session = session
        self._other = ignored

    def redo(self) -> None:
        """Apply the change."""
        self._session.ignored, self._other = self._other, self._session.ignored
        self._host.note_ignored_changed(self._session)

    undo = redo
