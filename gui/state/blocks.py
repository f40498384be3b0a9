"""Blocks of the workspace and their attributes, the frame's invalid mask, guide and the like, and their commands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal, SignalInstance
from PySide6.QtGui import QUndoCommand

from ilf._runtime.formatting import counted
from ilf.data.blocks import BlockInfo, Blocks
from ilf.data.frame import GroundTruthFile, RGBDFrame, read_only
from ilf.data.guide import Guide
from ilf.data.label_map import Box
from ilf.data.neighbours import NeighbourDepth
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import block_colour
from ilf.evaluation.quality.ignored import ignore
from ilf.evaluation.quality.places import Place
from ilf.project.frame_state import FrameState
from ilf.segmentation.editing.patches import LabelPatch, patch_between, redrawn
from ilf.segmentation.extraction import Extraction
from ilf.segmentation.reextraction import fill_around, overlay_kept

from .frames import WorkspaceFrames
from .parameters import WorkspaceParameters
from .results import BlockErrors, same_layers
from .session import Session, touched_by
from .stroke import StrokeInProgress
from .swap import Swap

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
            session.change(selected=tuple(labels))
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
        labels = extraction.blocks
        session.take_blocks(Blocks(labels, extraction=used, network=extraction.network, extracted=read_only(labels)))
        session.set_labels(labels)
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
        blocks = Blocks(
            around,
            extraction=used,
            network=extraction.network,
            extracted=read_only(around),
            kept=kept,
            handmade=handmade & kept,
        )
        self._replace(session, blocks, "Extract blocks")
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
        self._replace(session, Blocks(around, infos, kept=locked), text)

    def _replace(self, session: Session, blocks: Blocks, text: str) -> None:
        """Replace the blocks; those that are kept keep what is said about them."""
        old, patch, kept = session.blocks, patch_between(session.labels, blocks.labels), blocks.kept
        if patch is None:
            session.take_blocks(replace(blocks, infos=old.infos, own=old.own, drawn=old.drawn))
            self.validity_changed.emit(session)
            return
        blocks = replace(
            blocks,
            infos={**blocks.infos, **{label: info for label, info in old.infos.items() if label in kept}},
            own={label: own for label, own in old.own.items() if label in kept},
            drawn=None if old.drawn is None else old.drawn & np.isin(blocks.labels, list(kept)),
        )
        session.undo_stack.push(EditLabels(self, session, patch, text, blocks=blocks))

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
        session = self._frames.session

        def exchange(changes: Mapping[int, Mapping[str, Any]]) -> Mapping[int, Mapping[str, Any]]:
            former = {
                label: {name: getattr(session.info(label), name) for name in values}
                for label, values in changes.items()
            }
            for label, values in changes.items():
                session.change_info(label, **values)
            self._note_infos_changed(session)
            return former

        session.undo_stack.push(Swap(text, changes, exchange))

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
        return self._take_frame(self._frames.session.frame.with_invalid_mask(mask), text, self.invalid_mask_changed)

    def set_guide(self, guide: Guide | None, text: str) -> bool:
        """Set or remove the guide as one undo step; False if it is equal to the present one.

        Raises
        ------
        InputError
            If its aspect ratio differs from the frame's.
        """
        return self._take_frame(self._frames.session.frame.with_guide(guide), text, self.guide_changed)

    def set_neighbours(self, neighbours: NeighbourDepth | None, text: str) -> bool:
        """Set or remove the depth of neighbours as one undo step; False if it is equal to the present one."""
        frame = self._frames.session.frame.with_neighbours(neighbours)
        return self._take_frame(frame, text, self.neighbours_changed)

    def set_region(self, box: Box | None) -> None:
        """Set or remove the current frame's rectangle (rows, columns)."""
        session = self._frames.session
        if box != session.state.looked.region:
            session.change(looked=replace(session.state.looked, region=box))
            self._frames.touch(session, viewing=True)
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
        session = self._frames.session
        unseen = session.state.to_check.intersection(blocks)
        if unseen:
            name = session.info(next(iter(unseen))).name if len(unseen) == 1 else counted(len(unseen), "block")
            left = session.state.to_check - unseen
            self._push_change(session, f"Mark {name} as checked", self.note_checked, to_check=left)

    def ignore_place(self, place: Place) -> None:
        """Ignore a flagged place of the current frame, as one undo step."""
        session = self._frames.session
        rest = (other for other in session.state.ignored if not other.is_at(place))
        ignored = (*rest, ignore(place, session.frame, session.labels))
        self._push_change(session, "Ignore flagged place", self._note_ignored_changed, ignored=ignored)

    def _push_change(self, session: Session, text: str, notify: Callable[[Session], None], **fields: Any) -> None:
        """Replace fields of a frame's state as one undo step; `notify` is called after it."""

        def exchange(fields: dict[str, Any]) -> dict[str, Any]:
            former = {name: getattr(session.state, name) for name in fields}
            session.change(**fields)
            notify(session)
            return former

        session.undo_stack.push(Swap(text, fields, exchange))

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
        """Put a frame in place of the current one, as one undo step; False if it has the same layers."""
        session = self._frames.session
        if same_layers(session.frame, frame):
            return False

        def exchange(frame: RGBDFrame) -> RGBDFrame:
            former = session.frame
            session.take_frame(frame)
            self._note_depth_changed(changed, session)
            return former

        session.undo_stack.push(Swap(text, frame, exchange))
        return True

    def _note_depth_changed(self, changed: SignalInstance, session: Session) -> None:
        if self._frames.is_current(session):
            changed.emit()
        self.validity_changed.emit(session)

    def note_checked(self, session: Session) -> None:
        """Called by commands after the set of blocks to check has changed."""
        self._note_infos_changed(session)
        self._frames.sessions_changed.emit()

    def _note_ignored_changed(self, session: Session) -> None:
        """Called after the set of ignored places has changed."""
        if self._frames.is_current(session):
            self.ignored_changed.emit()

    def _note_infos_changed(self, session: Session) -> None:
        """Called after a name, colour or lock has changed."""
        if self._frames.is_current(session):
            self.infos_changed.emit()


class EditLabels(QUndoCommand):
    """A change of the label map.

    New borders become drawn borders. With `blocks`, they do not: all that is said about the blocks changes too, as when
    all blocks are replaced. With `done`, the map is already changed (a brush paints while it moves).
    """

    def __init__(
        self,
        host: WorkspaceBlocks,
        session: Session,
        patch: LabelPatch,
        text: str,
        done: bool = False,
        blocks: Blocks | None = None,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._patch = patch
        self._done = done
        self._other_blocks = blocks
        to_check = session.state.to_check
        if to_check:
            to_check = to_check - touched_by(patch) if blocks is None else to_check & blocks.kept
        self._other_to_check = to_check
        self._drawn: DrawnChange | None = None
        """Where drawn borders change, and the drawn pixels there before and after."""
        if blocks is None:
            former = session.blocks.drawn
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
        to_check = session.state.to_check
        session.change(to_check=self._other_to_check)
        self._other_to_check = to_check
        if self._other_blocks is not None:
            self._other_blocks = session.take_blocks(self._other_blocks)
        elif self._drawn is not None:
            box, before, after = self._drawn
            change = Change(session, self._patch, forward, self.text(), self._drawn)
            session.draw(box, after if forward else before, change.blocks)
        self._host.note_labels_changed(session, self._patch, change)


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
        drawn = propagated.blocks.drawn
        self._other = replace(
            propagated, blocks=replace(propagated.blocks, drawn=None if drawn is None else drawn.copy())
        )

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
        other, former = self._other, session.state
        blocks = session.take_blocks(other.blocks)
        session.change(to_check=other.to_check, extrapolate=other.extrapolate)
        self._parameters.take_common(session, other.common, other.own_parameters)
        self._other = replace(former, blocks=blocks)
        self._host.note_checked(session)
        self._host.note_labels_changed(session, self._patch)
