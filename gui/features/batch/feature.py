"""Batches of frames of the list: one batch at a time, in the background."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.cancellation import current_cancel_events, set_cancel_events
from ilf._runtime.formatting import counted
from ilf.batch.batch import Batch, open_batch
from ilf.batch.frame_record import FrameOutcome, FrameStatus
from ilf.batch.frames import BatchFrame, frames_of_files
from ilf.batch.pictures import write_contact_sheet, write_video
from ilf.batch.settings import BatchSettings
from ilf.errors import IlfError
from ilf.io.depth import depth_in_metres, read_depth_values
from ilf.run.options import DEPTH_FILES, RECORD_FILE
from ilf.run.run import RunConfiguration
from ilf.sources.frame_ref import FrameRef

from ...base.commands import Command
from ...state.entries import Entry
from ...widgets.notices import error_text
from ...work.jobs import Worker
from ..context import Context, Feature, PendingWork
from ..documents.export import stored_options
from ..documents.feature import DocumentsFeature
from ..frame_list.feature import FramesFeature
from .dialog import SELECTED_FRAMES, BatchDialog

# A batch, step by step, for any thread.


@dataclass(frozen=True)
class BatchRequest:
    """Settings of a batch.

    Attributes
    ----------
    frames : tuple of BatchFrame
        All frames of the list.
    only : tuple of BatchFrame
        Frames to complete.
    folder : Path
        Folder for the results.
    settings : BatchSettings
    jobs : int
        Number of processes.
    retry_failed, anew : bool
        As in `open_batch`.
    sheet, video : bool
        Whether to write a contact sheet and a video of the previews.
    """

    frames: tuple[BatchFrame, ...]
    only: tuple[BatchFrame, ...]
    folder: Path
    settings: BatchSettings
    jobs: int = 1
    retry_failed: bool = False
    anew: bool = False
    sheet: bool = False
    video: bool = False


class BatchResult(NamedTuple):
    """Where a batch has written the completed depth of a frame: its folder, and the units per metre of a depth PNG."""

    folder: Path
    units: float

    def read(self) -> NDArray[np.float32] | None:
        """Read the depth [m], float32 (H, W), NaN = missing; None if it was not written.

        Raises
        ------
        IlfError
            If it cannot be read.
        """
        for name, units in (("npy", 1.0), ("tiff", 1.0), ("png", self.units)):
            path = self.folder / DEPTH_FILES[name]
            if path.exists():
                return depth_in_metres(read_depth_values(path), units)
        return None


@dataclass(frozen=True)
class BatchOpened:
    """An opened batch, before its first frame."""

    batch: Batch


def batch_steps(request: BatchRequest) -> Generator[BatchOpened | FrameOutcome, None, list[FrameOutcome]]:
    """Complete the frames: yield the opened batch, then the outcome of each frame; return all outcomes.

    The manifest is written however the batch ends.

    Raises
    ------
    IlfError
        As from `open_batch` and `Batch.outcomes`, or if a picture cannot be written.
    """
    batch = open_batch(
        request.frames,
        request.folder,
        request.settings,
        only=request.only,
        anew=request.anew,
        retry_failed=request.retry_failed,
    )
    yield BatchOpened(batch)
    cancel_events = current_cancel_events()
    try:
        with closing(batch.outcomes(jobs=request.jobs)) as outcomes:
            yield from outcomes
    finally:
        set_cancel_events()  # writing the manifest is not cancelled
        found = batch.write_manifest()
    set_cancel_events(*cancel_events)
    for write in _pictures(request):
        write(request.folder, found)
    return found


def _pictures(request: BatchRequest) -> Sequence[Callable[[Path, Sequence[FrameOutcome]], Path]]:
    return [write_contact_sheet] * request.sheet + [write_video] * request.video


class BatchFeature(Feature):
    """The command *File > Batch…*: its dialog and the batch."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        context.actions.add(
            (
                Command(
                    "batch",
                    "&Batch…",
                    "Complete many frames of the list from their files, in the background, each into its own folder",
                    icon="ph.film-strip",
                    handler=self.ask,
                    why_off=self._why_no_frames,
                ),
            )
        )
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
        self._total, self._done, self._failed, self._completed = 0, 0, 0, 0

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
        request = BatchRequest(
            tuple(frames),
            tuple(frame for frame, entry in zip(frames, entries, strict=True) if entry.id in ids),
            Path(dialog.folder.text().strip()).expanduser().absolute(),
            self._settings(),
            dialog.jobs.value(),
            dialog.retry.isChecked(),
            dialog.anew.isChecked(),
            dialog.sheet.isChecked(),
            dialog.video.isChecked(),
        )
        self._ids = {frame.key: entry.id for frame, entry in zip(frames, entries, strict=True)}
        self._units = request.settings.options.depth_units
        self._folder, self._total = request.folder, len(request.only)
        self._done, self._failed, self._completed = 0, 0, 0
        dialog.begin()
        self.worker.start(lambda: batch_steps(request))

    def pending_work(self) -> Sequence[PendingWork]:
        """The batch in progress, if any."""
        return [PendingWork("a batch of frames")] if self.worker.busy else []

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if all threads have ended."""
        ended = self.worker.shutdown()
        if "dialog" in vars(self):
            self.dialog.close()
        return ended

    def _settings(self) -> BatchSettings:
        workspace = self.context.workspace
        configuration = RunConfiguration(workspace.parameters.current, workspace.parameters.extraction)
        return BatchSettings(configuration, replace(stored_options(), run_record=True))

    def _frames(self) -> list[Entry]:
        return [entry for entry in self.context.workspace.frames.entries if entry.source is not None]

    def _chosen(self) -> list[Entry]:
        chosen = {entry.id for entry in self.context.feature(FramesFeature).panel.view.chosen()}
        return [entry for entry in self._frames() if entry.id in chosen]

    def _take(self, items: list[BatchOpened | FrameOutcome]) -> None:
        outcomes: list[FrameOutcome] = []
        for item in items:
            if isinstance(item, BatchOpened):
                outcomes += [*item.batch.finished, *item.batch.failed]
            else:
                outcomes.append(item)
                self._completed += item.status is FrameStatus.COMPLETED
        self._done += len(outcomes)
        self._failed += sum(outcome.status is FrameStatus.FAILED for outcome in outcomes)
        for outcome in outcomes:
            id = self._ids.get(outcome.frame)
            if id is not None and outcome.status is FrameStatus.COMPLETED:
                self.results[id] = BatchResult(self._folder / outcome.folder, self._units)
        if outcomes:
            self.dialog.table.outcomes.add(outcomes)
        left = self._total - self._done
        self.dialog.work.show_share(self._done / max(self._total, 1), self._completed / max(self._completed + left, 1))
        self.dialog.state.show_message(self._text())

    def _text(self) -> str:
        failed = f", {self._failed} failed" if self._failed else ""
        return f"{self._done} of {counted(self._total, 'frame')}{failed}"

    def _finish(self, _: object) -> None:
        self._end(f"{self._text()}. Written to {self._folder}", "warning" if self._failed else "muted")

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
        self.context.feature(DocumentsFeature).open_source(
            FrameRef(str(Path(self.dialog.folder.text().strip()).expanduser().absolute()))
        )

    def _why_no_frames(self) -> str:
        return (
            ""
            if any(entry.source is not None for entry in self.context.workspace.frames.entries)
            else "Open a frame first."
        )
