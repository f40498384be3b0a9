"""A document: a frame's state, its undo history, and every change that the window makes of it. No widgets."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Self
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoStack

from ilf._runtime.formatting import counted
from ilf.data.blocks import BlockInfo, Blocks, Box, Colour, block_colour, bounds, whole
from ilf.data.by_hand import DepthByHand
from ilf.data.frame import GroundTruthFile, RGBDFrame, read_only
from ilf.data.guide import Guide
from ilf.data.neighbours import NeighbourDepth
from ilf.data.parameters import BlockParameters
from ilf.data.results import BlockResult, Completion, IterationRecord
from ilf.evaluation.measuring import Line
from ilf.evaluation.quality.places import Place, ignore
from ilf.project.frame_state import FrameState
from ilf.project.run_history import StoredRun
from ilf.run.replaying import Replay
from ilf.run.run import Run
from ilf.segmentation.editing.patches import LabelPatch, patch_between, redrawn
from ilf.segmentation.extraction import Extraction
from ilf.segmentation.reextraction import fill_around, overlay_kept

from .frame_data import FrameData
from .parts import NO_PART, Changes, DrawnChange, Edit, Part, Swap
from .results import ErrorEstimate, FrameResults, Preview, same_layers

Depth = NDArray[np.float32]

MAX_COMPARED = 4
"""Maximum number of runs that are compared at a time."""

RUN_COLOURS: tuple[Colour, ...] = (
    (230, 119, 34),
    (200, 66, 160),
    (38, 160, 92),
    (132, 98, 222),
    (186, 142, 14),
    (222, 66, 72),
    (20, 158, 170),
    (150, 104, 74),
)
"""Colours of runs in the history, distinct on light and dark backgrounds and from the blue of the current result."""


class Document(FrameData):
    """An open frame of the window: state, undo history, and what changes them.

    Attributes
    ----------
    undo_stack : QUndoStack
    changes : Changes
        Where changes are told: to the window while it is in the list of documents, else to nobody.
    had_unsaved : bool
        Whether there were unsaved changes when it was opened, and they still are.
    """

    def __init__(self, state: FrameState, origin: object, key: str) -> None:
        super().__init__(state, origin, key)
        self.undo_stack = QUndoStack()
        self.changes = Changes()
        self._before_stroke: NDArray[np.int32] | None = None
        """The label map before the stroke in progress."""
        self._edits = 0
        self.had_unsaved = False
        self._others = 0
        """Number of changes that are not undo steps."""
        self._others_saved = 0
        self._runs_saved = 1
        self.undo_stack.indexChanged.connect(self.note_edit)

    @classmethod
    def of_state(cls, state: FrameState, origin: object, key: str) -> Self:
        """Make a document of a frame's state, with an empty history and no unsaved changes."""
        document = cls(state, origin, key)
        document.restore_results(list(state.results.values()), state.extrapolation)
        there = document.counts().keys()
        selected = tuple(label for label in state.selected if label in there)
        document.change(to_check=frozenset(state.to_check & there), selected=selected)
        document.note_saved(document.stamp)
        return document

    @classmethod
    def of(cls, run: Run, origin: object, key: str, record_replay: Replay | None = None) -> Self:
        """Make a document with the frame and blocks of a run; `Workspace.open_document` sets the parameters.

        `record_replay` is the record that the run was read from.
        """
        state = FrameState(uuid4().hex, run.frame, replace(run.blocks, own={}), extrapolate=run.extrapolate)
        document = cls(state, origin, key)
        document.record_replay = record_replay
        return document

    # what is told

    def note(self, part: Part) -> None:
        """Tell that a part has changed."""
        self.changes.note(part, self)

    def touch(self, part: Part = NO_PART, viewing: bool = False) -> None:
        """Tell of a change that a project stores, other than an undo step; `viewing`: only of the view, which needs no
        saving."""
        if not viewing:
            self._others += 1
        self.changes.touch(self)
        self.note(part)

    def note_edit(self) -> None:
        """Note an edit that the undo stack does not report; undo steps call this through their signal."""
        self._edits += 1
        self.changes.touch(self)

    # saved or not

    @property
    def unsaved(self) -> bool:
        """Whether there are changes that are not in the project file."""
        return self.had_unsaved or not self.undo_stack.isClean() or self._others != self._others_saved

    def unsaved_summary(self) -> str:
        """Return a summary of the unsaved changes, as "earlier changes, 3 edits, 1 run"; "" for none."""
        if not self.unsaved:
            return ""
        clean = self.undo_stack.cleanIndex()
        edits = abs(self.undo_stack.index() - clean) if clean >= 0 else self.undo_stack.index()
        runs = sum(kept.number >= self._runs_saved for kept in self.state.runs)
        counts = [counted(count, what) for count, what in ((edits, "edit"), (runs, "run")) if count]
        return ", ".join(["earlier changes"] * self.had_unsaved + counts) or "changes"

    @property
    def stamp(self) -> tuple[int, int, int]:
        """Version of the frame's state: differs after any change; the argument of `note_saved`."""
        return self._edits, self._others, self.state.next_number

    def note_saved(self, stamp: tuple[int, int, int]) -> None:
        """Mark the state at a stamp as saved; later changes are not."""
        self.had_unsaved = False
        edits, self._others_saved, self._runs_saved = stamp
        if edits == self._edits:
            self.undo_stack.setClean()
        else:
            self.undo_stack.resetClean()
        self.note(Part.LIST)

    # selection and strokes

    @property
    def chosen(self) -> int:
        """The first selected block, which edits and curves use; 0 for none."""
        return self.state.selected[0] if self.state.selected else 0

    def select(self, labels: Sequence[int]) -> None:
        """Select blocks; edits and curves use the first one."""
        if tuple(labels) != self.state.selected:
            self.change(selected=tuple(labels))
            self.note(Part.SELECTION)

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke, which `drop_stroke` takes back: it is no undo step."""
        if patch is None:
            return
        if self._before_stroke is None:
            self._before_stroke = self.labels.copy()
        self.apply(patch)
        self._note_labels(patch.box, Part.STROKE)

    @property
    def stroke_in_progress(self) -> bool:
        """Whether a stroke is in progress."""
        return self._before_stroke is not None

    def drop_stroke(self) -> LabelPatch | None:
        """Restore the pixels of the stroke in progress, and return what it changed; None for nothing."""
        before, self._before_stroke = self._before_stroke, None
        patch = None if before is None else patch_between(before, self.labels)
        if patch is not None:
            self.apply(patch, forward=False)
            self._note_labels(patch.box, Part.STROKE)
        return patch

    def prepare_change(self) -> None:
        """End strokes before the label map changes."""
        if self is self.changes.shown:
            self.changes.about_to_change.emit()
        self.drop_stroke()

    def _note_labels(self, box: Box, part: Part) -> None:
        if self is self.changes.shown:
            self.changes.labels_changed.emit(box)
        self.note(part)

    # blocks

    def set_first(self, extraction: Extraction, used: BlockParameters) -> None:
        """Set the first blocks of a frame that was opened without any; it has not been edited since."""
        labels = extraction.blocks
        self.take_blocks(Blocks(labels, extraction=used, network=extraction.network, extracted=read_only(labels)))
        self.set_labels(labels)
        self.touch(viewing=True)
        self._note_labels(whole(labels.shape), Part.LABELS | Part.REPLACED | Part.RESULTS)

    def set_extracted(
        self, extraction: Extraction, used: BlockParameters, keep_handmade: bool
    ) -> tuple[int, int, bool]:
        """Replace the blocks by those of another extraction as one undo step; locked blocks stay, and with
        `keep_handmade` hand-made ones. Return the numbers of both, and whether there are no other blocks."""
        self.prepare_change()
        locked, by_hand = self.staying(keep_handmade)
        kept, handmade = locked | by_hand, self.handmade()
        labels = extraction.blocks
        around = fill_around(self.labels, kept, labels, used.smallest_block(labels.size))
        # a block that was only locked is not hand-made: a later extraction replaces it once it is unlocked
        blocks = Blocks(
            around,
            extraction=used,
            network=extraction.network,
            extracted=read_only(around),
            kept=kept,
            handmade=handmade & kept,
        )
        self._replace(blocks, "Extract blocks")
        return len(locked), len(by_hand), kept == set(self.counts())

    def staying(self, keep_handmade: bool) -> tuple[frozenset[int], frozenset[int]]:
        """Return the blocks that a new extraction keeps: locked ones, and other hand-made ones."""
        locked = self.locked & set(self.counts())
        return locked, self.handmade() - locked if keep_handmade else frozenset()

    def replace_blocks(self, labels: NDArray[np.int32], text: str, names: Mapping[int, str] | None = None) -> None:
        """Replace the label map, with names of blocks, as one undo step.

        Locked blocks stay, with their names; new blocks with the same labels get other labels.
        """
        self.prepare_change()
        locked = self.locked
        around = overlay_kept(self.labels, locked, labels)
        free = ~np.isin(self.labels, list(locked))
        numbers, first = np.unique(labels[free], return_index=True)
        become = zip(numbers.tolist(), around[free][first].tolist(), strict=True)
        named = {label: names[number] for number, label in become if names and number in names}
        if np.array_equal(around, self.labels):
            renamed = {label: {"name": name} for label, name in named.items() if self.info(label).name != name}
            if renamed:
                self.edit_infos(renamed, text)
        infos = {label: BlockInfo(name, block_colour(label)) for label, name in named.items()}
        self._replace(Blocks(around, infos, kept=locked), text)

    def _replace(self, blocks: Blocks, text: str) -> None:
        """Replace the blocks; those that are kept keep what is said about them."""
        old, patch, kept = self.blocks, patch_between(self.labels, blocks.labels), blocks.kept
        if patch is None:
            self.take_blocks(replace(blocks, infos=old.infos, own=old.own, drawn=old.drawn))
            self.note(Part.RESULTS)
            return
        blocks = replace(
            blocks,
            infos={**blocks.infos, **{label: info for label, info in old.infos.items() if label in kept}},
            own={label: own for label, own in old.own.items() if label in kept},
            drawn=None if old.drawn is None else old.drawn & np.isin(blocks.labels, list(kept)),
        )
        self._change_labels(patch, text, blocks)

    def edit(self, patch: LabelPatch | None, text: str) -> bool:
        """Change the label map as one undo step; False if there is nothing to change."""
        if patch is None:
            return False
        self._change_labels(patch, text)
        return True

    def _change_labels(self, patch: LabelPatch, text: str, blocks: Blocks | None = None) -> None:
        """Change the label map as one undo step. New borders become drawn borders; with `blocks`, they do not: all that
        is said about the blocks changes too, as when all blocks are replaced."""
        touched, unseen, drawn = patch.touched, self.state.to_check, self.blocks.drawn
        borders: DrawnChange | None = None
        if blocks is None:
            box, now = redrawn(drawn, self.labels, patch)
            borders = box, np.zeros_like(now) if drawn is None else drawn[box].copy(), now

        def exchange(to: tuple[bool, frozenset[int], Blocks | None]) -> tuple[bool, frozenset[int], Blocks | None]:
            (forward, to_check, other), former, edit = to, self.state.to_check, None
            self.prepare_change()
            self.apply(patch, forward)
            self.change(to_check=to_check)
            if other is not None:
                other = self.take_blocks(other)
            elif borders is not None:
                box, before, after = borders
                self.draw(box, after if forward else before, touched)
                edit = Edit(self, touched, text, Part.LABELS, patch, forward, borders)
            self.note_labels_changed(patch, edit)
            return not forward, former, other

        to_check = unseen - touched if blocks is None else unseen & blocks.kept
        self.undo_stack.push(Swap(text, (True, to_check, blocks), exchange))

    def start_block(self) -> int:
        """Select and return an unused label, to be painted."""
        label = self.next_label()
        self.info(label)
        self.select([label])
        return label

    def edit_info(self, label: int, text: str, **changes: Any) -> None:
        """Rename, recolour or lock a block as one undo step."""
        self.edit_infos({label: changes}, text)

    def edit_infos(self, changes: Mapping[int, Mapping[str, Any]], text: str) -> None:
        """Rename, recolour or lock blocks as one undo step."""

        def exchange(changes: Mapping[int, Mapping[str, Any]]) -> Mapping[int, Mapping[str, Any]]:
            former = {
                label: {name: getattr(self.info(label), name) for name in values} for label, values in changes.items()
            }
            for label, values in changes.items():
                self.change_info(label, **values)
            self.note(Part.INFOS)
            return former

        self.undo_stack.push(Swap(text, changes, exchange))

    def set_lock(self, label: int, locked: bool) -> None:
        """Lock or unlock a block as one undo step."""
        self.edit_info(label, f"{'Lock' if locked else 'Unlock'} {self.info(label).name}", locked=locked)

    def set_visible(self, label: int, visible: bool) -> None:
        """Show or hide a block in the overlay; not undoable."""
        self.change_info(label, visible=visible)
        self.touch(Part.INFOS)

    def mark_checked(self, blocks: Collection[int]) -> None:
        """Mark blocks as checked, as one undo step."""
        unseen = self.state.to_check.intersection(blocks)
        if unseen:
            name = self.info(next(iter(unseen))).name if len(unseen) == 1 else counted(len(unseen), "block")
            self._push_change(f"Mark {name} as checked", Part.INFOS | Part.LIST, to_check=self.state.to_check - unseen)

    def ignore_place(self, place: Place) -> None:
        """Ignore a flagged place, as one undo step."""
        rest = (other for other in self.state.ignored if not other.is_at(place))
        self._push_change("Ignore flagged place", Part.IGNORED, ignored=(*rest, ignore(place, self.frame, self.labels)))

    def _push_change(self, text: str, part: Part, **fields: Any) -> None:
        """Replace fields of the state as one undo step."""

        def exchange(fields: dict[str, Any]) -> dict[str, Any]:
            former = {name: getattr(self.state, name) for name in fields}
            self.change(**fields)
            self.note(part)
            return former

        self.undo_stack.push(Swap(text, fields, exchange))

    def note_labels_changed(self, patch: LabelPatch | None, edit: Edit | None = None) -> None:
        """Called by undo steps after the label map or what is said about blocks has changed; with `edit`, by it."""
        if patch is not None:
            self._note_labels(patch.box, Part.LABELS)
            left = self.counts()
            # a new block that is not painted yet stays selected
            gone = [
                label
                for label in self.selected
                if label not in left and ((patch.before == label).any() or (patch.after == label).any())
            ]
            if gone:
                self.select([label for label in self.selected if label not in gone])
        if edit is None:
            self.note(Part.REPLACED)
        else:
            self.changes.edited.emit(edit)
        self.note(Part.RESULTS)

    # the frame's layers

    def set_invalid_mask(self, mask: NDArray[np.bool_] | None, text: str) -> bool:
        """Set the invalid mask, bool (H, W), as one undo step; False if it is the same already.

        Raises
        ------
        InputError
            If no valid depth would be left.
        """
        return self._set_frame(self.frame.with_invalid_mask(mask), text, Part.INVALID_MASK)

    def set_guide(self, guide: Guide | None, text: str) -> bool:
        """Set or remove the guide as one undo step; False if it is equal to the present one.

        Raises
        ------
        InputError
            If its aspect ratio differs from the frame's.
        """
        return self._set_frame(self.frame.with_guide(guide), text, Part.GUIDE)

    def set_neighbours(self, neighbours: NeighbourDepth | None, text: str) -> bool:
        """Set or remove the depth of neighbours as one undo step; False if it is equal to the present one."""
        return self._set_frame(self.frame.with_neighbours(neighbours), text, Part.NEIGHBOURS)

    def _set_frame(self, frame: RGBDFrame, text: str, part: Part) -> bool:
        """Put a frame in place of the current one, as one undo step; False if it has the same layers."""
        if same_layers(self.frame, frame):
            return False

        def exchange(other: RGBDFrame) -> RGBDFrame:
            former = self.frame
            self.take_frame(other)
            self._note_edit(Edit(self, frozenset(self.counts()), text, part, forward=same_layers(other, frame)))
            return former

        self.undo_stack.push(Swap(text, frame, exchange))
        return True

    def set_by_hand(self, depth: Depth, where: NDArray[np.bool_], text: str) -> bool:
        """Set depth by hand [m], float32 (H, W), NaN for none, at the pixels in `where`, bool (H, W), as one undo step;
        False if nothing changes.

        Raises
        ------
        InputError
            If a depth is out of range.
        """
        box = bounds(where)
        if box is None:
            return False
        before = self._by_hand_in(box)
        after = np.where(where[box], depth[box], before)
        if np.array_equal(before, after, equal_nan=True):
            return False
        DepthByHand(after)  # refuses it before it becomes a step

        def exchange(other: Depth) -> Depth:
            former = self._by_hand_in(box)
            forward = np.array_equal(other, after, equal_nan=True)
            self._note_edit(Edit(self, self.take_by_hand(box, other), text, Part.BY_HAND, forward=forward))
            return former

        self.undo_stack.push(Swap(text, after, exchange))
        return True

    def _by_hand_in(self, box: Box) -> Depth:
        """Return a copy of depth by hand in a box."""
        if self.blocks.by_hand is None:
            return np.full(self.labels[box].shape, np.nan, np.float32)
        return self.blocks.by_hand.depth[box].copy()

    def _note_edit(self, edit: Edit) -> None:
        self.note(edit.part | Part.RESULTS)
        self.changes.edited.emit(edit)

    def propose(self, depth: Depth | None) -> None:
        """Show depth [m], float32 (H, W), NaN for none, in place of the completed depth until it is taken or dropped;
        None drops it."""
        if depth is not self.proposal:
            self.proposal = depth
            self.note(Part.PROPOSAL)

    def set_measurements(self, lines: Sequence[Line]) -> None:
        """Set all measurements."""
        self.look(Part.MARKS, viewing=False, measurements=tuple(lines))

    def look(self, part: Part, viewing: bool = True, **fields: Any) -> None:
        """Set what is looked at: rectangle, profile line, measurements; not undoable."""
        looked = replace(self.state.looked, **fields)
        if looked != self.state.looked:
            self.change(looked=looked)
            self.touch(part, viewing)

    def set_camera(self, read: RGBDFrame, origin: object) -> bool:
        """Take over the camera of the frame as it was read again, and what was read; no undo step. Return False, and
        change nothing, if its images are others, or if depth of neighbours was brought here by the present camera."""
        images = ((self.frame.rgb, read.rgb), (self.frame.measured, read.measured))
        same = (np.array_equal(here, there, equal_nan=here.dtype.kind == "f") for here, there in images)
        if self.frame.neighbours is not None or not all(same):
            return False
        self.take_camera(read)
        self.origin = origin
        self.touch(Part.FRAME)
        self.note(Part.RESULTS)
        return True

    def set_ground_truth(self, ground_truth: Depth | None, file: GroundTruthFile | None = None) -> None:
        """Set or remove the ground truth [m], float32 (H, W), NaN unknown.

        `file` is the file that it was read from.

        Raises
        ------
        InputError
            If it does not fit the frame.
        """
        self.change(frame=self.frame.with_ground_truth(ground_truth, file))
        for kept in self.state.runs:
            kept.ground_truth_error = None
        self.touch(Part.GROUND_TRUTH)

    # results

    def add_records(self, label: int, records: Sequence[IterationRecord]) -> None:
        """Add records of a running block."""
        self.results.live.setdefault(label, []).extend(records)
        self.note(Part.RECORDS)

    def add_previews(self, previews: Sequence[Preview]) -> None:
        """Store the depth so far of running blocks."""
        self.results.add_previews(previews)
        for block, _ in previews:
            self._shown.note(block.box)
        self.note(Part.PREVIEWS)

    def store_results(self, results: Sequence[BlockResult], frame: RGBDFrame | None = None) -> None:
        """Store results of blocks; `frame` is the frame as it was when they started, if it may have changed since."""
        self.add_results(results, frame)
        self.touch(Part.SOME_RESULTS)

    def store_extrapolation(self, base: Completion, extrapolation: Completion) -> None:
        """Store the extrapolation of a completion."""
        self.add_extrapolation(base, extrapolation)
        self.touch(Part.RESULTS)

    def store_error_estimate(self, completion: Completion, error_estimate: ErrorEstimate) -> None:
        """Store the error estimate of a completion; ignored if the completion is outdated."""
        if completion is self.completion():
            self.results.error_estimate = completion, error_estimate
            self.note(Part.EXPECTED_ERROR)

    def end_run(self, keep_previews: bool = False) -> None:
        """End the run; with `keep_previews`, another run of the same blocks starts next."""
        for block, _ in self.results.previews.values():
            self._shown.note(block.box)
        self.results.end_run(keep_previews)
        self.note(Part.RESULTS)

    def clear_results(self) -> None:
        """Remove all results, as one undo step; results of later runs stay when it is undone."""

        def exchange(cleared: FrameResults | None) -> FrameResults | None:
            present = self.results.snapshot()
            if cleared is None:
                self.put_back_results(FrameResults(), present)
            else:
                self.put_back_results(cleared, FrameResults())
            self.note(Part.RESULTS)
            return present if cleared is None else None

        if self.results.kept:
            self.undo_stack.push(Swap("Clear results", None, exchange))

    # run history

    def keep_run(self, kept: StoredRun) -> None:
        """Add a run to the history."""
        self.change(runs=(*self.state.runs, kept), next_number=max(self.state.next_number, kept.number + 1))
        self.touch(Part.HISTORY)

    def change_run(self, kept: StoredRun, **changes: Any) -> None:
        """Set attributes of a stored run, such as its name or note."""
        for name, value in changes.items():
            setattr(kept, name, value)
        self.touch(Part.HISTORY | Part.COMPARED if kept in self.compared else Part.HISTORY)

    def delete_runs(self, runs: Collection[StoredRun]) -> None:
        """Delete runs from the history, as one undo step; later runs stay when it is undone."""
        there = [kept for kept in self.state.runs if kept in runs]
        compared = [kept for kept in self.compared if kept in there]

        def exchange(deletes: bool) -> bool:
            runs = [kept for kept in self.state.runs if kept not in there]
            shown = [kept for kept in self.compared if kept not in there]
            if not deletes:
                for kept in there:
                    kept.ground_truth_error = None  # the ground truth may have changed meanwhile
                runs, shown = sorted([*runs, *there], key=lambda kept: kept.number), [*shown, *compared]
            self.change(runs=tuple(runs))
            self.note(Part.HISTORY)
            self.compare_runs(shown)
            return not deletes

        if there:
            text = f"Delete {there[0].name}" if len(there) == 1 else f"Delete {len(there)} runs"
            self.undo_stack.push(Swap(text, True, exchange))

    def drop_runs(self, runs: Collection[StoredRun]) -> None:
        """Delete runs from the history; not undoable."""
        self.change(runs=tuple(kept for kept in self.state.runs if kept not in runs))
        self.touch(Part.HISTORY)

    def compare_runs(self, runs: Sequence[StoredRun]) -> None:
        """Compare stored runs with the result; the last `MAX_COMPARED` of the given ones."""
        runs = runs[-MAX_COMPARED:]
        numbers = tuple(kept.number for kept in runs)
        if numbers == self.state.compared:
            return
        for place, kept in enumerate(runs):
            taken = [other.colour for other in runs[:place]]
            if kept.colour in taken:
                kept.colour = next(colour for colour in RUN_COLOURS if colour not in taken)
        self.change(compared=numbers)
        self.touch(Part.COMPARED, viewing=True)
