"""What the window works on: the open frames, the present one, the parameters. Signals, no widgets."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from weakref import ref

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoGroup, QUndoStack

from gui.state.block_errors import BlockErrors
from gui.state.carry_commands import CarryBlocks, LookAtBlocks
from gui.state.commands import Change, ClearResults, Distrust, EditInfo, EditLabels, EditParameters, OwnChange
from gui.state.entries import Entries, Entry
from gui.state.kept_commands import AcceptRun, DeleteRuns
from gui.state.kept_runs import COLOURS, MOST_COMPARED
from gui.state.past import Past
from gui.state.results import Preview, same_mask
from gui.state.session import Session
from gui.state.sharing import Shared, ShareParameters
from gui.state.stroke import StrokeUnderWay
from ilf.blocks import Box
from ilf.completion import Watch
from ilf.drawing.block_pictures import block_colour
from ilf.ebs import Extraction
from ilf.ebs.edit import LabelPatch, patch_between
from ilf.ebs.reextraction import flow_around, keep_under
from ilf.filter.convergence import IterationRecord
from ilf.frame import RGBDFrame, TruthFile
from ilf.outcomes import BlockResult, Completion
from ilf.parameters import DEFAULT_PRESET, BlockParameters, Parameters, preset
from ilf.project import FrameState
from ilf.project.block_notes import BlockInfo, BlockNotes
from ilf.project.kept_run import KeptRun
from ilf.project.own_values import OwnValues, differing, own_values, parameter_labels
from ilf.run import Run

_MOST_WATCHED = 4
"""Frames that have key frames at a time."""


class Kept(NamedTuple):
    """How many blocks stayed as they were when blocks were extracted again, and whether there are no others."""

    locked: int
    by_hand: int
    all_of_them: bool


class Workspace(QObject):
    """The single place where the state of the window changes: every change is a method, and sends its signal.

    Signals carry no data that could go stale: who listens reads the workspace. Those of a session are sent for the
    present one only; of the others, `sessions_changed` tells.
    """

    about_to_change = Signal()
    """The present frame is about to be left, or its label map to be changed: strokes under way must end."""
    sessions_changed = Signal()
    """Frames were opened or closed, or what the list says of them has changed."""
    session_changed = Signal()
    labels_changed = Signal(object)
    """The box (rows, columns) of the label map that changed."""
    stroke_changed = Signal(object)
    """The same, by a stroke that is under way and may yet be given up."""
    infos_changed = Signal()
    results_changed = Signal()
    """Other results, or none, or a run has ended."""
    results_added = Signal()
    """Some of a run under way have come: several times a second, it may be."""
    records_added = Signal()
    """Blocks that run have new records."""
    previews_changed = Signal()
    """Blocks that run have other depth."""
    error_changed = Signal()
    """The expected error of the results has been worked out."""
    touched = Signal(object)
    """A Session, the present one or another, has changed in something that a project holds."""
    project_touched = Signal()
    """What a project holds beside its frames has changed: which there are, in which order, what is set for all."""
    edited = Signal(object)
    """An edit of the label map has been made, undone or made again: a `Change`."""
    replaced = Signal()
    """All blocks of the present frame have given way to others, or have come back: no edit."""
    distrusted_changed = Signal()
    """Other depth of the present frame is distrusted."""
    truth_changed = Signal()
    """The present frame has another truth, or none."""
    block_errors_changed = Signal()
    """Other errors of blocks are known."""
    region_changed = Signal()
    """Another rectangle of the present frame is chosen, or none."""
    kept_runs_changed = Signal()
    """Runs of the present frame have been kept, changed or deleted."""
    past_changed = Signal()
    """The views look back to another iteration, or no longer."""
    compared_changed = Signal()
    """Others of the kept runs are compared."""
    selection_changed = Signal()
    parameters_changed = Signal()
    """Of the filter."""
    extraction_changed = Signal()
    """Parameters of the extraction, or which blocks it keeps."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.sessions: list[Session] = []
        """The frames that are open."""
        self.entries = Entries(self)
        """All frames, open or not."""
        self.undo_group = QUndoGroup(self)
        self.shared = Shared(False, preset(DEFAULT_PRESET))
        """Whether parameters are for all frames; while they are not, and a frame is open, the next begins with its."""
        self.extraction_parameters = BlockParameters()
        self.keeps_handmade = True
        """Whether blocks that were made by hand stay when blocks are extracted again, as locked ones do."""
        self._session: Session | None = None
        self._nothing = QUndoStack(self)
        self._stroke: StrokeUnderWay | None = None
        self.past: Past | None = None
        """What the views show in place of the present depth."""
        self._watched: list[Session] = []
        """Frames with key frames, the one that was run last at the end."""

    # frames

    @property
    def session(self) -> Session:
        """The present frame's session; only to be asked for while `has_session`."""
        if self._session is None:
            raise RuntimeError("no frame is open")
        return self._session

    @property
    def has_session(self) -> bool:
        """Whether a frame is open."""
        return self._session is not None

    @property
    def parameters(self) -> Parameters:
        """Parameters of all blocks of the present frame that have no values of their own."""
        return self.shared.values if self._session is None else self._session.common

    @property
    def next_parameters(self) -> Parameters:
        """What the next frame begins with."""
        return self.shared.values if self.shared.on else self.parameters

    def is_present(self, session: Session) -> bool:
        """Whether this is the present frame's session."""
        return session is self._session

    @property
    def chosen(self) -> int:
        """The block that edits and curves are about; 0 for none."""
        return self._session.selected[0] if self._session is not None and self._session.selected else 0

    def session_of(self, key: str) -> Session | None:
        """The open session of a file or folder, if there is one."""
        return next((session for session in self.sessions if session.key == key), None)

    def add_session(
        self, session: Session, recorded: Run | None = None, restored: bool = False, show: bool = True
    ) -> None:
        """Open a frame and, with `show`, make it the present one.

        It begins with the parameters of the present one, or of all, unless it is `restored`. With `recorded`, it comes
        from that run, and has the parameters of that; what it was extracted with goes for the next extraction, and the
        blocks that were run are chosen if they are not all.
        """
        if restored:
            self.shared.begin(session)
        else:
            session.take_common(self.next_parameters)
        if recorded is not None:
            self._take_recorded(session, recorded)
        self.sessions.append(session)
        listed = len(self.entries)
        self.entries.attach(session)
        self.undo_group.addStack(session.undo_stack)
        opened = ref(session)  # the history would hold the session, and never be freed
        session.undo_stack.indexChanged.connect(lambda _: self._note_step(opened()))
        self.sessions_changed.emit()
        if show:
            self.show_session(session)
        if len(self.entries) > listed:
            self.project_touched.emit()

    def _take_recorded(self, session: Session, recorded: Run) -> None:
        session.take_common(recorded.parameters)
        session.own_parameters = self.shared.on and recorded.parameters != self.shared.values
        if recorded.extraction is not None:
            self.set_extraction_parameters(recorded.extraction)
        labels = set(session.counts()) if recorded.only is None else set(recorded.only)
        own = {label: own_values(recorded.parameters_of(label), recorded.parameters) for label in labels}
        session.notes.own.update({label: values for label, values in own.items() if values})
        if labels != set(session.counts()):
            session.selected = sorted(labels)

    def show_session(self, session: Session | None) -> None:
        """Make a frame the present one."""
        if session is self._session:
            return
        self._end_strokes()
        self.shared = Shared(self.shared.on, self.next_parameters)
        self._session = session
        self.undo_group.setActiveStack(session.undo_stack if session else self._nothing)
        self.session_changed.emit()

    def close_session(self, session: Session) -> None:
        """Close a frame for good; the one before it in the list becomes the present one."""
        entry = self.entries.of(session.id)
        self._leave(session)
        if entry is not None:
            self.remove_entries([entry])

    def put_away(self, session: Session, stored: bool = True) -> None:
        """Close a frame whose state is stored, or that has none: its entry stays, and it comes back as it was, without
        its history."""
        entry = self.entries.of(session.id)
        if entry is not None:
            self.entries.detach(entry, stored)
        self._leave(session)

    def add_entries(self, entries: Sequence[Entry]) -> None:
        """Add frames to the list without opening them."""
        self.entries.add(entries)
        self.project_touched.emit()

    def remove_entries(self, entries: Collection[Entry]) -> None:
        """Take frames out of the list, and close those that are open, for good."""
        gone = {entry.session for entry in entries if entry.session is not None}
        if self._session in gone:  # what is shown next is the nearest one that stays
            position = self.sessions.index(self._session)
            nearest = [*reversed(self.sessions[:position]), *self.sessions[position:]]
            self.show_session(next((session for session in nearest if session not in gone), None))
        for session in [session for session in self.sessions if session in gone]:
            self._leave(session)
        self.entries.remove(entries)
        self.project_touched.emit()

    def note_problem(self, entry: Entry, problem: str) -> None:
        """A frame of the list could not be opened, for this reason."""
        self.entries.note_problem(entry, problem)
        self.project_touched.emit()

    def _leave(self, session: Session) -> None:
        position = self.sessions.index(session)
        self.sessions.remove(session)
        self._watched = [one for one in self._watched if one is not session]
        if session is self._session:
            self.show_session(self.sessions[max(position - 1, 0)] if self.sessions else None)
        self.undo_group.removeStack(session.undo_stack)
        session.undo_stack.clear()  # commands and session hold each other, and would never be freed
        self.sessions_changed.emit()

    def note_saved(self, session: Session, stamp: tuple[int, int, int]) -> None:
        """What there was at a `Session.stamp` has been saved."""
        session.note_saved(stamp)
        self.sessions_changed.emit()

    def touch(self, session: Session, looked: bool = False) -> None:
        """Called after something has changed that a project holds; `looked`: only in how it is looked at, which is
        stored but no reason to save."""
        if not looked:
            session.note_other_change()
        if session in self.sessions:
            self.touched.emit(session)

    def _note_step(self, session: Session | None) -> None:
        """A step of a frame's history has been made, taken back or made again."""
        if session is not None and session in self.sessions:
            self.touched.emit(session)

    def set_note(self, entry: Entry, note: str) -> None:
        """What the user says of a frame, open or not."""
        if note == entry.note:
            return
        if entry.session is None:
            self.entries.set_note(entry, note)
        else:
            entry.session.note = note
            self.touch(entry.session)
        self.sessions_changed.emit()
        self.project_touched.emit()

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

    # blocks

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

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke, which `end_stroke` makes a step and `drop_stroke` gives up."""
        if patch is None:
            return
        if self._stroke is None:
            self._stroke = StrokeUnderWay(self.session.labels)
        self._stroke.reach(patch.box)
        self.session.apply(patch)
        self.stroke_changed.emit(patch.box)

    @property
    def stroke_under_way(self) -> bool:
        """Whether the label map holds part of a stroke that may yet be given up."""
        return self._stroke is not None

    def end_stroke(self, text: str) -> LabelPatch | None:
        """Make the stroke one undoable step, and give what it has changed; None if that is nothing."""
        patch = self._take_stroke()
        if patch is not None:
            self.session.undo_stack.push(EditLabels(self, self.session, patch, text, done=True))
        return patch

    def drop_stroke(self) -> bool:
        """Put the pixels of the stroke back; False if none was under way."""
        patch = self._take_stroke()
        if patch is None:
            return False
        self.session.apply(patch, forward=False)
        self.stroke_changed.emit(patch.box)
        return True

    def _take_stroke(self) -> LabelPatch | None:
        stroke, self._stroke = self._stroke, None
        return None if stroke is None else stroke.patch(self.session.labels)

    def _end_strokes(self) -> None:
        self.about_to_change.emit()
        self.drop_stroke()

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

    def select(self, labels: list[int]) -> None:
        """Choose blocks; the first is the one that edits and curves are about."""
        if self.has_session:
            self._select(self.session, labels)

    def _select(self, session: Session, labels: list[int]) -> None:
        if labels != session.selected:
            session.selected = labels
            if session is self._session:
                self.selection_changed.emit()

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

    # kept runs

    def keep_run(self, session: Session, kept: KeptRun) -> None:
        """Keep a run beside the others of a frame."""
        session.kept_runs.append(kept)
        self.touch(session)
        self._note_kept_runs(session)

    def change_run(self, session: Session, kept: KeptRun, **changes: Any) -> None:
        """Set attributes of a kept run, as its name or note."""
        for name, value in changes.items():
            setattr(kept, name, value)
        self.note_run_changed(session, kept)

    def note_run_changed(self, session: Session, kept: KeptRun) -> None:
        """Called after a kept run has changed."""
        self.touch(session)
        self._note_kept_runs(session)
        if kept in session.compared and session is self._session:
            self.compared_changed.emit()

    def note_measured(self, session: Session) -> None:
        """Called after it has been worked out how good a kept run is."""
        self.touch(session, looked=True)
        self._note_kept_runs(session)

    def delete_runs(self, session: Session, runs: Collection[KeptRun]) -> None:
        """Keep some runs no longer, as one undoable step."""
        there = [kept for kept in session.kept_runs if kept in runs]
        if there:
            session.undo_stack.push(DeleteRuns(self, session, there))

    def drop_run(self, session: Session, kept: KeptRun) -> None:
        """Keep a run no longer, for good."""
        session.kept_runs.remove(kept)
        self.touch(session)
        self._note_kept_runs(session)

    def take_kept_runs(self, session: Session, runs: list[KeptRun], compared: list[KeptRun]) -> None:
        """Called by commands: other runs are kept, and others of them compared."""
        for kept in runs:
            if kept not in session.kept_runs:
                kept.truth_error = None  # there may have been another truth meanwhile
        session.kept_runs = runs
        self._note_kept_runs(session)
        self._compare(session, compared[-MOST_COMPARED:])

    def compare(self, runs: Sequence[KeptRun]) -> None:
        """Show some of the present frame's kept runs beside its result, at most `MOST_COMPARED`, the latest chosen."""
        self._compare(self.session, list(runs)[-MOST_COMPARED:])

    def _compare(self, session: Session, runs: list[KeptRun]) -> None:
        if runs == session.compared:
            return
        for kept in session.compared:
            kept.hold(kept in runs)
        for number, kept in enumerate(runs):
            kept.hold(True)
            taken = [other.colour for other in runs[:number]]
            if kept.colour in taken:
                kept.colour = next(colour for colour in COLOURS if colour not in taken)
        session.compared = runs
        self.touch(session, looked=True)
        if session is self._session:
            self.compared_changed.emit()

    def restore_run(self, kept: KeptRun) -> bool:
        """Take the parameters of a kept run for the present frame, common ones and own ones of its blocks, as one
        undoable step; False if they are the present ones."""
        session, run = self.session, kept.run
        there = set(session.counts()).intersection(np.unique(run.blocks).tolist())
        own = {label: own_values(run.parameters_of(label), run.parameters) for label in there}
        changes = self._own_changes(own)
        names = _names_in(changes).union(own_values(run.parameters, session.common))
        if not names:
            return False
        common = session.common, run.parameters
        text = f"Restore parameters of {kept.name}{self._for_all(session)}"
        session.undo_stack.push(EditParameters(self, session, common, changes, names, text))
        return True

    def accept_run(self, kept: KeptRun) -> list[int]:
        """Have the results of a kept run for those of the present frame, with their parameters, as one undoable step,
        where its blocks are as they were then; the blocks that it gives results for."""
        results = self.session.still_fitting(kept)
        if results:
            where = self._for_all(self.session) if kept.run.parameters != self.session.common else ""
            self.session.undo_stack.push(AcceptRun(self, self.session, kept, results, f"Accept {kept.name}{where}"))
        return [result.block.label for result in results]

    def _note_kept_runs(self, session: Session) -> None:
        if session is self._session:
            self.kept_runs_changed.emit()

    # runs and results

    def watch(self, session: Session, run: Run) -> Watch:
        """What takes key frames of a run of a frame; those of frames that were run long before go."""
        self._watched = [*(one for one in self._watched if one is not session), session]
        while len(self._watched) > _MOST_WATCHED:
            self._watched.pop(0).key_frames.clear()
        return session.key_frames.watch(run)

    def look_back(self, past: Past | None) -> None:
        """Show what the present frame's depth was like in the course of its last run; None: what it is."""
        if past is not self.past:
            self.past = past
            self.past_changed.emit()

    def add_records(self, session: Session, label: int, records: Sequence[IterationRecord]) -> None:
        """A block that runs has gone on."""
        session.results.add_records(label, records)
        if session is self._session:
            self.records_added.emit()

    def add_previews(self, session: Session, previews: Sequence[Preview]) -> None:
        """Blocks that run have other depth."""
        session.add_previews(previews)
        if session is self._session:
            self.previews_changed.emit()

    def store_results(self, session: Session, results: Sequence[BlockResult], frame: RGBDFrame | None = None) -> None:
        """Keep blocks' results, of the frame as it was when they were begun if it may have changed since."""
        session.add_results(results, frame)
        self.touch(session)
        (self.results_added if session is self._session else self.sessions_changed).emit()

    def store_guess(self, session: Session, base: Completion, guess: Completion) -> None:
        """Keep the guess of what a completion leaves missing."""
        session.add_guess(base, guess)
        self.touch(session)
        self.note_results_changed(session)

    def end_run(self, session: Session, previews_stay: bool = False) -> None:
        """Nothing of the frame runs any more; with `previews_stay`, it will again at once."""
        session.end_run(previews_stay)
        self.note_results_changed(session)

    def clear_results(self) -> None:
        """Forget all results of the present frame, as one undoable step."""
        if self.session.results.kept:
            self.session.undo_stack.push(ClearResults(self, self.session))

    def store_error(self, session: Session, completion: Completion, error: NDArray[np.float32]) -> None:
        """Keep the expected error [m], float32 (H, W), of a completion; overtaken ones are dropped."""
        if completion is session.completion():
            session.results.note_error(completion, error)
            if session is self._session:
                self.error_changed.emit()

    # parameters

    def set_parameters(self, parameters: Parameters, blocks: int | Collection[int] | None = None) -> None:
        """Parameters of all blocks that have no values of their own, or of some blocks, as one undoable step.

        Of blocks, the values that differ from the common ones become their own. What is set while a slider is being
        moved is one step with what was set before.
        """
        if blocks is None:
            self._edit_parameters((self.parameters, parameters), {}, own_values(parameters, self.parameters).keys())
            return
        labels = [blocks] if isinstance(blocks, int) else blocks
        self._edit_own(dict.fromkeys(labels, own_values(parameters, self.parameters)))

    def set_own(self, values: OwnValues, blocks: Collection[int]) -> None:
        """Give blocks some values of their own, one parameter beside the other; those equal to the common ones go."""
        common, own = self.parameters.to_dict(), self.session.notes.own
        merged = {label: {**own.get(label, {}), **values} for label in blocks}
        self._edit_own(
            {
                label: {name: value for name, value in one.items() if value != common[name]}
                for label, one in merged.items()
            }
        )

    def reset_own(self, blocks: Collection[int]) -> None:
        """Take all values of their own from blocks."""
        self._edit_own({label: {} for label in blocks})

    def copy_own(self, source: int, blocks: Collection[int]) -> None:
        """Give blocks the very own values that another one has."""
        values = self.session.notes.own.get(source, {})
        self._edit_own(dict.fromkeys(blocks, values))

    def _edit_own(self, wanted: Mapping[int, OwnValues]) -> None:
        changes = self._own_changes(wanted)
        self._edit_parameters(None, changes, _names_in(changes))

    def _own_changes(self, wanted: Mapping[int, OwnValues]) -> OwnChange:
        """What changes if blocks are to have these own values."""
        own = self.session.notes.own
        return {
            label: (own.get(label), values or None)
            for label, values in wanted.items()
            if values != (own.get(label) or {})
        }

    def _edit_parameters(
        self,
        common: tuple[Parameters, Parameters] | None,
        own: OwnChange,
        names: Collection[str],
    ) -> None:
        if not names:
            return
        if self._session is None:
            if common is not None:
                self.set_shared(Shared(self.shared.on, common[1]))
            return
        stack = self._session.undo_stack
        last = stack.command(stack.index() - 1) if not stack.isClean() else None
        if isinstance(last, EditParameters) and stack.index() == stack.count() and last.extend(common, own, names):
            self._session.note_edit()
            self.touched.emit(self._session)
            return
        what = parameter_labels(names)[0] if len(names) == 1 else f"{len(names)} values of the filter"
        blocks = f" of {self._session.info(min(own)).name}" if len(own) == 1 else f" of {len(own)} blocks"
        where = blocks if own else self._for_all(self._session)
        stack.push(EditParameters(self, self._session, common, own, names, f"Set {what}{where}"))

    def _for_all(self, session: Session) -> str:
        """What the text of a step on a frame's common parameters ends with."""
        return " for all frames" if self.shared.reach(session) else ""

    def take_parameters(
        self, session: Session, common: OwnValues, own: Mapping[int, OwnValues | None], passing: bool = False
    ) -> None:
        """Called by commands: other values of some of the common parameters, and other own values of blocks, None for
        none; with `passing`, no undo leads back to the present ones."""
        before = session.valid_results()
        if not passing:
            session.settle_parameters()
        for label, values in own.items():
            if values:
                session.notes.own[label] = values
            else:
                session.notes.own.pop(label, None)
        session.take_common(session.common.replace(**common))
        if common and self.shared.reach(session):
            self.shared = Shared(True, session.common)
            self.shared.spread(self.sessions, passing)
            self.project_touched.emit()
        if session is self._session:
            self.parameters_changed.emit()
        if session.valid_results() != before:  # those of the values that have come back
            self.note_results_changed(session)

    def take_common(self, session: Session, common: Parameters, own: bool) -> None:
        """Called by commands: other common parameters of a frame, unless it has those of all; `own`: its own where
        parameters are for all frames."""
        session.own_parameters = own
        session.take_common(common)
        self.shared.begin(session)
        if session is self._session:
            self.parameters_changed.emit()

    def set_shared(self, shared: Shared) -> None:
        """Whether parameters are for all frames, and which: as a project has it, before its frames are opened."""
        former, self.shared = self.shared, shared
        shared.spread(self.sessions)
        if former.on and not shared.on:  # from now on they are what is stored of each frame
            for session in self.sessions:
                if session.counts() or session.unsaved:
                    self.touched.emit(session)
        self.parameters_changed.emit()
        self.project_touched.emit()

    def share_parameters(self) -> list[Session]:
        """Have the present frame's parameters in all frames without their own, now and from now on, as one undoable
        step; the open ones that had others."""
        shared = Shared(True, self.parameters)
        others = [one for one in self.sessions if not one.own_parameters and one.common != self.parameters]
        self._push_sharing(shared, own=False, text="Use parameters for all frames")
        return [one for one in others if one is not self._session]

    def keep_own_parameters(self) -> None:
        """Let the present frame's parameters be its own where they are for all frames, as one undoable step."""
        self._push_sharing(self.shared, own=True, text="Parameters for this frame alone")

    def reset_to_shared(self) -> None:
        """Let the present frame have the parameters of all frames again, as one undoable step."""
        self._push_sharing(self.shared, own=False, text="Reset to the parameters of all frames")

    def part_parameters(self) -> None:
        """Let every frame have its own parameters again, which are what they are, as one undoable step."""
        self._push_sharing(Shared(False, self.parameters), own=False, text="Parameters of each frame by itself")

    def _push_sharing(self, shared: Shared, own: bool, text: str) -> None:
        self.session.undo_stack.push(ShareParameters(self, self.session, shared, own, text))

    def take_shared(self, shared: Shared, session: Session, common: Parameters, own: bool) -> None:
        """Called by commands: whether parameters are for all frames, which those are, and those of one frame."""
        before = session.valid_results()
        session.settle_parameters()
        session.own_parameters = own
        session.take_common(common)
        self.set_shared(shared)
        self.sessions_changed.emit()
        if session.valid_results() != before:
            self.note_results_changed(session)

    def set_extraction_parameters(self, parameters: BlockParameters) -> None:
        """What blocks are extracted with the next time."""
        self.extraction_parameters = parameters
        self.extraction_changed.emit()
        self.project_touched.emit()

    def set_keeps_handmade(self, on: bool) -> None:
        """Whether blocks made by hand stay at the next extraction."""
        self.keeps_handmade = on
        self.extraction_changed.emit()
        self.project_touched.emit()

    # what commands say

    def prepare_change(self, session: Session) -> None:
        """Called before the label map of a session changes."""
        if session is self._session:
            self._end_strokes()

    def note_labels_changed(self, session: Session, patch: LabelPatch | None, change: Change | None = None) -> None:
        """Called by commands after the label map, or what is known of it, has changed; with `change`, by an edit."""
        if session is not self._session:
            self.sessions_changed.emit()
            return
        if patch is not None:
            left = session.counts()
            # a block that is yet to be painted has never been there
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
        self.results_changed.emit()

    def note_results_changed(self, session: Session) -> None:
        """Called after results have come, gone or come back."""
        (self.results_changed if session is self._session else self.sessions_changed).emit()

    def note_distrusted_changed(self, session: Session) -> None:
        """Called by commands after other depth is distrusted."""
        if session is self._session:
            self.distrusted_changed.emit()
        self.note_results_changed(session)

    def note_checked(self, session: Session) -> None:
        """Called by commands after other blocks should be looked at."""
        self.note_infos_changed(session)
        self.sessions_changed.emit()

    def note_infos_changed(self, session: Session) -> None:
        """Called by commands after a name, colour or lock has changed."""
        if session is self._session:
            self.infos_changed.emit()


def _names_in(changes: OwnChange) -> set[str]:
    """The parameters whose own values change."""
    return {name for before, after in changes.values() for name in differing(before or {}, after or {})}
