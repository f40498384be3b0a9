"""What changes a frame's blocks, and what is known of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Box
from ilf.data.frame import TruthFile
from ilf.data.guide import Guide
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import block_colour
from ilf.project.frame_state import BlockInfo, BlockNotes, FrameState
from ilf.segmentation.editing.patches import LabelPatch, patch_between
from ilf.segmentation.extraction import Extraction
from ilf.segmentation.reextraction import flow_around, keep_under

from .changing_parameters import ChangingParameters
from .commands import CarryBlocks, Distrust, EditInfo, EditLabels, LookAtBlocks, TakeGuide
from .results import BlockErrors, same_guide, same_mask
from .session import Session


class Kept(NamedTuple):
    """How many blocks stayed as they were when blocks were extracted again, and whether there are no others."""

    locked: int
    by_hand: int
    all_of_them: bool


class ChangingBlocks(ChangingParameters):
    """Blocks change here: by edits and strokes, by extraction, by their names and locks; and so does what
    is distrusted, and what else is known of a frame.
    """

    def set_first_blocks(self, session: Session, extraction: Extraction, used: BlockParameters) -> None:
        """Take the blocks of a frame that was opened without any; as an undoable step only if it has been worked on
        since."""
        if session.undo_stack.count() or session.counts():
            self.set_extracted(session, extraction, used)
            return
        session.take_notes(BlockNotes(extraction=used, network=extraction.network, extracted=extraction.blocks.copy()))
        session.set_labels(extraction.blocks)
        self.touch(session, looked=True)
        if session is self._session:
            self.labels_changed.emit((slice(0, session.labels.shape[0]), slice(0, session.labels.shape[1])))
            self.replaced.emit()
            self.results_changed.emit()
        else:
            self.sessions_changed.emit()

    def set_extracted(self, session: Session, extraction: Extraction, used: BlockParameters) -> Kept:
        """Take the blocks of another extraction as one undoable step, around the blocks that stay as they are."""
        self.prepare_change(session)
        locked, by_hand = self.staying(session)
        kept, handmade = locked | by_hand, session.handmade()
        labels = extraction.blocks
        around = flow_around(session.labels, kept, labels, used.smallest_block(labels.size))
        # a block that only was locked is not made by hand: it goes when it is unlocked
        notes = BlockNotes({}, {}, None, used, extraction.network, around.copy(), kept, handmade & kept)
        self._replace(session, around, "Extract blocks", notes)
        return Kept(len(locked), len(by_hand), kept == set(session.counts()))

    def staying(self, session: Session) -> tuple[frozenset[int], frozenset[int]]:
        """Blocks that stay when blocks are extracted again: locked ones, and others made by hand."""
        locked = session.locked & set(session.counts())
        return locked, session.handmade() - locked if self.keeps_handmade else frozenset()

    def replace_labels(self, labels: NDArray[np.int32], text: str, names: Mapping[int, str] | None = None) -> None:
        """Take another label map for the present frame, with names of its blocks, as one undoable step.

        Locked blocks stay, with their names; blocks that had their numbers get others.
        """
        session = self.session
        self.prepare_change(session)
        locked = session.locked
        around = keep_under(session.labels, locked, labels)
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
        """Take another map and what is known of it; of the blocks that it keeps, what was known of them."""
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
        """Change the label map as one undoable step; False if there is nothing to change."""
        if patch is None:
            return False
        self.session.undo_stack.push(EditLabels(self, self.session, patch, text))
        return True

    def end_stroke(self, text: str) -> LabelPatch | None:
        """Make the stroke one undoable step, and give what it has changed; None if that is nothing."""
        patch = self._take_stroke()
        if patch is not None:
            self.session.undo_stack.push(EditLabels(self, self.session, patch, text, done=True))
        return patch

    def start_block(self) -> int:
        """Choose a number that no block has, to be painted; returned."""
        label = self.session.next_label()
        self.session.info(label)
        self.select([label])
        return label

    def edit_info(self, label: int, text: str, **changes: Any) -> None:
        """Rename, recolour or lock a block as one undoable step."""
        self.edit_infos({label: changes}, text)

    def edit_infos(self, changes: Mapping[int, Mapping[str, Any]], text: str) -> None:
        """Rename, recolour or lock blocks as one undoable step."""
        self.session.undo_stack.push(EditInfo(self, self.session, changes, text))

    def set_lock(self, label: int, locked: bool) -> None:
        """Lock or unlock a block as one undoable step."""
        name = self.session.info(label).name
        self.edit_info(label, f"{'Lock' if locked else 'Unlock'} {name}", locked=locked)

    def set_visible(self, label: int, visible: bool) -> None:
        """Show or hide a block in the overlay. A matter of view, so not undoable."""
        self.session.change_info(label, visible=visible)
        self.touch(self.session)
        self.infos_changed.emit()

    def set_distrusted(self, mask: NDArray[np.bool_] | None, text: str) -> bool:
        """Distrust just the depth at these pixels, bool (H, W), as one undoable step; False if it is so already.

        Raises
        ------
        InputError
            If no depth were left.
        """
        session = self.session
        frame = session.frame.distrusting(mask)
        if same_mask(session.frame.distrusted, frame.distrusted):
            return False
        session.undo_stack.push(Distrust(self, session, frame, text))
        return True

    def set_guide(self, guide: Guide | None, text: str) -> bool:
        """Follow another guide, or none, as one undoable step; False if it says the same.

        Raises
        ------
        InputError
            If it has another aspect than the frame.
        """
        session = self.session
        frame = session.frame.with_guide(guide)
        if same_guide(session.frame.guide, frame.guide):
            return False
        session.undo_stack.push(TakeGuide(self, session, frame, text))
        return True

    def set_region(self, box: Box | None) -> None:
        """Choose a rectangle (rows, columns) of the present frame, or none."""
        if box != self.session.region:
            self.session.region = box
            self.touch(self.session, looked=True)
            self.region_changed.emit()

    def set_truth(self, truth: NDArray[np.float32] | None, file: TruthFile | None = None) -> None:
        """Judge the present frame's results by a truth [m], float32 (H, W), NaN unknown, or by none.

        With `file`, it comes from there.

        Raises
        ------
        InputError
            If it does not fit the frame.
        """
        self.session.take_truth(truth, file)
        self.touch(self.session)
        self.truth_changed.emit()

    def set_block_errors(self, session: Session, errors: BlockErrors) -> None:
        """Take over how far off blocks are known to be."""
        if errors != session.block_errors:
            session.block_errors = errors
            if session is self._session:
                self.block_errors_changed.emit()

    def take_carried(self, session: Session, carried: FrameState, text: str) -> None:
        """Take the blocks that were carried to a frame, with all that came with them, as one undoable step."""
        self.prepare_change(session)
        session.undo_stack.push(CarryBlocks(self, session, carried, text))
        if not session.selected:
            self._select(session, list(carried.selected))

    def look_at(self, blocks: Collection[int]) -> None:
        """Blocks of the present frame that needed a look have had it, as one undoable step."""
        unseen = self.session.to_check.intersection(blocks)
        if unseen:
            self.session.undo_stack.push(LookAtBlocks(self, self.session, unseen))
