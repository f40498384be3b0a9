"""Batches of frames of the list: one batch at a time, in the background."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path

from ilf._runtime.cancellation import current_cancel_events, set_cancel_events
from ilf._runtime.formatting import counted
from ilf.batch.batch import Batch, open_batch
from ilf.batch.frame_record import FrameOutcome, FrameStatus
from ilf.batch.frames import frames_of_files
from ilf.batch.settings import BatchSettings
from ilf.errors import IlfError
from ilf.run.block_choice import BlockChoice
from ilf.run.options import RECORD_FILE
from ilf.sources.frame_ref import FrameRef

from ...state.entries import Entry
from ...widgets.notices import error_text
from ...work.jobs import Worker
from ..context import Context, Feature, PendingWork
from ..documents.export import stored_options
from ..documents.feature import DocumentsFeature
from ..frame_list.feature import FramesFeature
from .dialog import SELECTED_FRAMES, BatchDialog
from .result import BatchResult

# A batch, step by step, for any thread.


def batch_steps(
    batch: Callable[[], Batch], jobs: int = 1, pictures: Sequence[Callable[[Path, Sequence[FrameOutcome]], Path]] = ()
) -> Generator[Batch | FrameOutcome, None, list[FrameOutcome]]:
    """Open a batch and complete its frames: yield the batch, then the outcome of each frame; return all outcomes.

    The manifest is written however the batch ends; then the pictures, unless it was cancelled.

    Raises
    ------
    IlfError
        As from `open_batch` and `Batch.outcomes`, or if a picture cannot be written.
    """
    opened = batch()
    yield opened
    cancel_events = current_cancel_events()
    try:
        with closing(opened.outcomes(jobs=jobs)) as outcomes:
            yield from outcomes
    finally:
        set_cancel_events()  # writing the manifest is not cancelled
        found = opened.write_manifest()
    set_cancel_events(*cancel_events)
    for write in pictures:
        write(opened.folder, found)
    return found


class BatchFeature(Feature):
    """The command *File > Batch…*: its dialog and the batch."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take)
        self.worker.finished.connect(self._finish)
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self._end("Cancelled. Start again to resume."))
        self.results: dict[str, BatchResult] = {}
        """Id of a frame -> its result in the latest batch of this window that completed it."""
        self._ids: dict[str, str] = {}
        """Name of a frame in the batch -> its id."""
        self._units = 1.0
        self._folder = Path()
        self._total = self._completed = 0
        """Number of frames to complete, and of those completed since the start."""

    @cached_property
    def dialog(self) -> BatchDialog:
        """The dialog, created on first use."""
        dialog = BatchDialog(self.context.window)
        dialog.begun.connect(self.start)
        dialog.cancelled.connect(self.worker.cancel)
        dialog.opened.connect(self._open_outcome)
        dialog.results_requested.connect(self._open_results)
        return dialog

    def ask(self) -> None:
        """Open the dialog, for a new batch or for the progress of the current one."""
        if not self.worker.busy:
            self.dialog.set_frames(len(self._frames()), len(self._chosen()))
        self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()

    def start(self) -> None:
        """Start the batch with the settings of the dialog."""
        if self.worker.busy:
            return
        dialog, entries = self.dialog, self._frames()
        frames = frames_of_files([entry.source for entry in entries if entry.source is not None])
        chosen = self._chosen() if dialog.scope.currentData() == SELECTED_FRAMES else entries
        ids = {entry.id for entry in chosen}
        only = [frame for frame, entry in zip(frames, entries, strict=True) if entry.id in ids]
        settings = self._settings()
        self._ids = {frame.key: entry.id for frame, entry in zip(frames, entries, strict=True)}
        self._units, self._folder = settings.options.depth_units, dialog.chosen_folder()
        self._total, self._completed = len(only), 0
        again = {"anew": dialog.anew.isChecked(), "retry_failed": dialog.retry.isChecked()}
        batch = partial(open_batch, frames, self._folder, settings, only=only, **again)
        jobs, pictures = dialog.jobs.value(), dialog.pictures()
        dialog.begin()
        self.worker.start(lambda: batch_steps(batch, jobs, pictures))

    def pending_work(self) -> Sequence[PendingWork]:
        """The batch in progress, if any."""
        return [PendingWork("a batch of frames")] if self.worker.busy else []

    def _settings(self) -> BatchSettings:
        workspace = self.context.workspace
        parameters, blocks = workspace.parameters.current, BlockChoice(workspace.parameters.extraction)
        return BatchSettings(parameters, blocks, options=replace(stored_options(), run_record=True))

    def _frames(self) -> list[Entry]:
        return [entry for entry in self.context.workspace.entries if entry.source is not None]

    def _chosen(self) -> list[Entry]:
        chosen = {entry.id for entry in self.context.feature(FramesFeature).panel.view.chosen()}
        return [entry for entry in self._frames() if entry.id in chosen]

    def _take(self, items: list[Batch | FrameOutcome]) -> None:
        outcomes: list[FrameOutcome] = []
        for item in items:
            if isinstance(item, Batch):
                outcomes += [*item.finished, *item.failed]
            else:
                outcomes.append(item)
                self._completed += item.status is FrameStatus.COMPLETED
        for outcome in outcomes:
            id = self._ids.get(outcome.frame)
            if id is not None and outcome.status is FrameStatus.COMPLETED:
                self.results[id] = BatchResult(self._folder / outcome.folder, self._units)
        rows = self.dialog.table.outcomes
        rows.add(outcomes)
        left = self._total - len(rows.rows)
        self.dialog.work.show_share(
            len(rows.rows) / max(self._total, 1), self._completed / max(self._completed + left, 1)
        )
        self.dialog.state.show_message(self._text())

    def _failed(self) -> int:
        return sum(row.status is FrameStatus.FAILED for row in self.dialog.table.outcomes.rows)

    def _text(self) -> str:
        failed = f", {self._failed()} failed" if self._failed() else ""
        return f"{len(self.dialog.table.outcomes.rows)} of {counted(self._total, 'frame')}{failed}"

    def _finish(self, _: object) -> None:
        self._end(f"{self._text()}. Written to {self._folder}", "warning" if self._failed() else "muted")

    def _end(self, text: str, tone: str = "muted") -> None:
        self.dialog.end(text, tone)
        if not self.dialog.isVisible():
            self.context.notes.show_message(f"Batch: {text}")

    def _fail(self, error: Exception) -> None:
        self.dialog.end(error_text(error), "error")
        if not isinstance(error, IlfError) or not self.dialog.isVisible():
            self.context.notes.report("The batch stopped", error)

    def _open_outcome(self, outcome: FrameOutcome) -> None:
        """Open the run of a completed frame; show the message of a failed one."""
        record = self._folder / outcome.folder / RECORD_FILE
        if outcome.status is FrameStatus.COMPLETED and record.exists():
            self.context.feature(DocumentsFeature).open_run(record)
        else:
            self.dialog.state.show_message(f"{outcome.frame}: {outcome.message}", "warning")

    def _open_results(self) -> None:
        self.context.feature(DocumentsFeature).open_source(FrameRef(str(self.dialog.chosen_folder())))
