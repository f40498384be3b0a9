"""Changes of a frame's blocks and their attributes, invalid mask, guide and ground truth."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Box
from ilf.data.frame import GroundTruthFile
from ilf.data.guide import Guide
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import block_colour
from ilf.project.frame_state import BlockInfo, BlockNotes, FrameState
from ilf.segmentation.editing.patches import LabelPatch, patch_between
from ilf.segmentation.extraction import Extraction
from ilf.segmentation.reextraction import fill_around, overlay_kept

from .commands import EditInfo, EditLabels, MarkChecked, MarkInvalid, PropagateBlocks, TakeGuide
from .results import BlockErrors, same_guide, same_mask
from .session import Session
from .workspace_parameters import WorkspaceParameters


class KeptBlocks(NamedTuple):
    """How many blocks a new extraction kept, and whether there are no others."""

    locked: int
    by_hand: int
    all_of_them: bool


class WorkspaceBlocks(WorkspaceParameters):
    """The part of the workspace that changes blocks (edits, strokes, extraction, names, locks), invalid mask, guide and
    ground truth."""

    def set_first_blocks(self, session: Session, extraction: Extraction, used: BlockParameters) -> None:
        """Set the first blocks of a frame that was opened without any; an undo step only if it has been edited
        since."""
        if session.undo_stack.count() or session.counts():
            self.set_extracted(session, extraction, used)
            return
        session.take_notes(BlockNotes(extraction=used, network=extraction.network, extracted=extraction.blocks.copy()))
        session.set_labels(extraction.blocks)
        self.touch(session, viewing=True)
        if session is self._session:
            self.labels_changed.emit((slice(0, session.labels.shape[0]), slice(0, session.labels.shape[1])))
            self.replaced.emit()
            self.results_changed.emit()
        else:
            self.sessions_changed.emit()

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
        return locked, session.handmade() - locked if self.keeps_handmade else frozenset()

    def replace_labels(self, labels: NDArray[np.int32], text: str, names: Mapping[int, str] | None = None) -> None:
        """Replace the current frame's label map, with names of blocks, as one undo step.

        Locked blocks stay, with their names; new blocks with the same labels get other labels.
        """
        session = self.session
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
            self.note_results_changed(session)
            return
        notes.infos |= {label: info for label, info in old.infos.items() if label in notes.kept}
        notes.own = {label: own for label, own in old.own.items() if label in notes.kept}
        notes.drawn = None if old.drawn is None else old.drawn & np.isin(labels, list(notes.kept))
        session.undo_stack.push(EditLabels(self, session, patch, text, notes=notes))

    def edit_labels(self, patch: LabelPatch | None, text: str) -> bool:
        """Change the label map as one undo step; False if there is nothing to change."""
        if patch is None:
            return False
        self.session.undo_stack.push(EditLabels(self, self.session, patch, text))
        return True

    def end_stroke(self, text: str) -> LabelPatch | None:
        """Make the stroke one undo step and return what it changed; None for nothing."""
        patch = self._take_stroke()
        if patch is not None:
            self.session.undo_stack.push(EditLabels(self, self.session, patch, text, done=True))
        return patch

    def start_block(self) -> int:
        """Select and return an unused label, to be painted."""
        label = self.session.next_label()
        self.session.info(label)
        self.select([label])
        return label

    def edit_info(self, label: int, text: str, **changes: Any) -> None:
        """Rename, recolour or lock a block as one undo step."""
        self.edit_infos({label: changes}, text)

    def edit_infos(self, changes: Mapping[int, Mapping[str, Any]], text: str) -> None:
        """Rename, recolour or lock blocks as one undo step."""
        self.session.undo_stack.push(EditInfo(self, self.session, changes, text))

    def set_lock(self, label: int, locked: bool) -> None:
        """Lock or unlock a block as one undo step."""
        name = self.session.info(label).name
        self.edit_info(label, f"{'Lock' if locked else 'Unlock'} {name}", locked=locked)

    def set_visible(self, label: int, visible: bool) -> None:
        """Show or hide a block in the overlay; not undoable."""
        self.session.change_info(label, visible=visible)
        self.touch(self.session)
        self.infos_changed.emit()

    def set_invalid_mask(self, mask: NDArray[np.bool_] | None, text: str) -> bool:
        """Set the invalid mask, bool (H, W), as one undo step; False if it is the same already.

        Raises
        ------
        InputError
            If no valid depth would be left.
        """
        session = self.session
        frame = session.frame.with_invalid_mask(mask)
        if same_mask(session.frame.invalid_mask, frame.invalid_mask):
            return False
        session.undo_stack.push(MarkInvalid(self, session, frame, text))
        return True

    def set_guide(self, guide: Guide | None, text: str) -> bool:
        """Set or remove the guide as one undo step; False if it is equal to the present one.

        Raises
        ------
        InputError
            If its aspect ratio differs from the frame's.
        """
        session = self.session
        frame = session.frame.with_guide(guide)
        if same_guide(session.frame.guide, frame.guide):
            return False
        session.undo_stack.push(TakeGuide(self, session, frame, text))
        return True

    def set_region(self, box: Box | None) -> None:
        """Set or remove the current frame's rectangle (rows, columns)."""
        if box != self.session.region:
            self.session.region = box
            self.touch(self.session, viewing=True)
            self.region_changed.emit()

    def set_ground_truth(self, ground_truth: NDArray[np.float32] | None, file: GroundTruthFile | None = None) -> None:
        """Set or remove the current frame's ground truth [m], float32 (H, W), NaN unknown.

        `file` is the file that it was read from.

        Raises
        ------
        InputError
            If it does not fit the frame.
        """
        self.session.take_ground_truth(ground_truth, file)
        self.touch(self.session)
        self.ground_truth_changed.emit()

    def set_block_errors(self, session: Session, errors: BlockErrors) -> None:
        """Set the known errors of blocks."""
        if errors != session.block_errors:
            session.block_errors = errors
            if session is self._session:
                self.block_errors_changed.emit()

    def take_propagated(self, session: Session, propagated: FrameState, text: str) -> None:
        """Take over the blocks propagated to a frame, with all their attributes, as one undo step."""
        self.prepare_change(session)
        session.undo_stack.push(PropagateBlocks(self, session, propagated, text))
        if not session.selected:
            self._select(session, list(propagated.selected))

    def mark_checked(self, blocks: Collection[int]) -> None:
        """Mark blocks of the current frame as checked, as one undo step."""
        unseen = self.session.to_check.intersection(blocks)
        if unseen:
            self.session.undo_stack.push(MarkChecked(self, self.session, unseen))
