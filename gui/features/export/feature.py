"""Exports of frames, one at a time, in the background."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from ilf._runtime.formatting import counted
from ilf.batch.folder_sink import open_folder
from ilf.batch.frames import frames_of_files
from ilf.batch.settings import BatchSettings
from ilf.data.frame import RGBDFrame
from ilf.evaluation.evaluation import Progress
from ilf.project.exporting import ExportedFrame, ExportStatus, FrameToExport, export_frames
from ilf.run.block_choice import BlockChoice
from ilf.run.options import RECORD_FILE
from ilf.run.run import Run
from ilf.sources.frame_ref import FrameRef

from ...state.document import Document
from ...state.entries import Entry
from ...state.parts import Part
from ...widgets.file_choice import EXPORTS, EXPORTS_OF_FRAMES, remember_folder
from ...widgets.notices import DESTROY, ask, error_text
from ...work.jobs import Worker
from ..context import Context, Feature, PendingWork
from ..documents.feature import DocumentsFeature
from ..frame_list.feature import FramesFeature
from ..sequence.flicker import written_depth
from ..sequence.playing import PlayFeature
from ..status import StatusFeature
from .dialog import ALL, DONE, SELECTED, THIS, WORKED_ON, Export, ExportDialog
from .jobs import (
    Step,
    batch_steps,
    frame_as_shown,
    frames_to_export,
    present_frame,
    report_file_steps,
    subjects_of,
)

_PARTS = Part.FRAME | Part.LIST | Part.LABELS | Part.RESULTS | Part.PARAMETERS | Part.INVALID_MASK
_MAX_NAMED = 3


class ExportFeature(Feature):
    """The export dialog, and the export in progress."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._status, self._playing = context.feature(StatusFeature), context.feature(PlayFeature)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take)
        self.worker.finished.connect(lambda _: self._end())
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self._end("Cancelled: export again to go on. "))
        self._ids: dict[str, str] = {}
        """Name of a folder -> id of its frame, while frames are completed from their files."""
        self._export: Export | None = None
        self._total = 0
        self._done: list[ExportedFrame] = []

    @cached_property
    def dialog(self) -> ExportDialog:
        """The dialog, made on first use."""
        dialog = ExportDialog(self.context.window)
        dialog.requested.connect(self._begin)
        dialog.cancelled.connect(self.worker.cancel)
        dialog.opened.connect(self._open)
        documents = self.context.feature(DocumentsFeature)
        dialog.results_requested.connect(lambda folder: documents.open_source(FrameRef(str(folder))))
        self.context.refresh.add("export", self._describe, _PARTS)
        return dialog

    def ask(self, scope: str = THIS, from_files: bool = False, only_report: bool = False) -> None:
        """Open the dialog for some frames, or to show the export in progress; for `ALL` and window results, for those
        that are done or worked on, if any."""
        dialog = self.dialog
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()
        if self.worker.busy:
            return
        self._describe()
        if scope == ALL and not from_files:
            scope = next(name for name in (DONE, WORKED_ON, ALL) if self._entries(name))
        dialog.prepare(scope, from_files, only_report)

    def start(self, export: Export) -> None:
        """Export in the background; only said if an export is in progress."""
        if self.worker.busy:
            self.context.notes.show_message("An export is in progress. Wait until it has ended.")
            return
        entries = self._entries(export.scope)
        self._export, self._done, self._ids = export, [], {}
        parts: list[Iterator[Step]] = []
        self._total = len(entries) if export.options.filenames() else 0
        if export.from_files:
            parts.append(self._batch(export, entries))
        elif self._total:
            parts.append(export_frames(self._frames(export.scope, entries), export.folder, export.options))
        if export.report is not None:
            parts.append(self._report(export.report, export, entries))
        if not export.from_files:
            remember_folder(EXPORTS if export.scope == THIS else EXPORTS_OF_FRAMES, export.folder)

        def job() -> Generator[Step, None, None]:
            for steps in parts:
                yield from steps

        self.dialog.begin()
        self.worker.start(job)
        self._show_frames()

    def pending_work(self) -> Sequence[PendingWork]:
        """The export in progress, if any."""
        return [PendingWork(f"an export of {counted(max(self._total, 1), 'frame')}")] if self.worker.busy else []

    # frames

    def _entries(self, scope: str) -> list[Entry]:
        """Return the frames of a choice."""
        workspace = self.context.workspace
        entries = list(workspace.entries)
        if scope == THIS:
            return [] if workspace.current_entry is None else [workspace.current_entry]
        if scope == SELECTED:
            chosen = {entry.id for entry in self.context.feature(FramesFeature).panel.view.chosen()}
            return [entry for entry in entries if entry.id in chosen]
        if scope == ALL:
            return entries
        return [entry for entry in entries if (entry.summary.done if scope == DONE else entry.summary.has_work)]

    def _frames(self, scope: str, entries: Sequence[Entry]) -> list[FrameToExport]:
        workspace, store = self.context.workspace, self.context.recorder.store
        if scope == THIS:
            return [frame_as_shown(workspace.current)]
        shared = workspace.parameters.shared
        parameters, blocks = workspace.parameters.current, BlockChoice(workspace.parameters.extraction)

        def make_run(frame: RGBDFrame) -> Run:
            return Run(frame, blocks.blocks_of(frame), parameters)

        return frames_to_export(entries, store, make_run, shared.values if shared.on else None)

    def _batch(self, export: Export, chosen: Sequence[Entry]) -> Iterator[Step]:
        workspace = self.context.workspace
        entries = [entry for entry in workspace.entries if entry.source is not None]
        frames = frames_of_files([entry.source for entry in entries if entry.source is not None])
        self._ids = {frame.folder: entry.id for frame, entry in zip(frames, entries, strict=True)}
        wanted = {entry.id for entry in chosen}
        only = [frame for frame in frames if self._ids[frame.folder] in wanted]
        self._total = len(only)
        options = replace(export.options, run_record=True)
        settings = BatchSettings(
            workspace.parameters.current, BlockChoice(workspace.parameters.extraction), options=options
        )
        again = {"anew": export.anew, "retry_failed": export.retry}
        make = partial(open_folder, frames, export.folder, settings, only=only, **again)
        return batch_steps(make, export.jobs, export.pictures)

    def _report(self, path: Path, export: Export, chosen: Sequence[Entry]) -> Generator[Progress, None, None]:
        store, shared = self.context.recorder.store, self.context.workspace.parameters.shared
        subjects = subjects_of(chosen, store, shared.values if shared.on else None)
        return report_file_steps(path, subjects, export.test)

    # the dialog

    def _describe(self) -> None:
        if self.worker.busy or not self.dialog.isVisible():
            return
        workspace = self.context.workspace
        counts = {scope: len(self._entries(scope)) for scope in (THIS, DONE, WORKED_ON, SELECTED, ALL)}
        if not workspace.has_current:
            self.dialog.describe(None, None, "", counts)
            return
        run, completion = present_frame(workspace.current)
        self.dialog.describe(run, completion, behind(workspace.current), counts)

    def _begin(self, export: Export) -> None:
        """Start the export; ask first if it would replace files."""
        replaced = self._replaced(export)
        if not replaced:
            self._accept(export)
            return
        more = ", ".join(replaced[:_MAX_NAMED])
        more += f" and {len(replaced) - _MAX_NAMED} more" * (len(replaced) > _MAX_NAMED)
        text = f"{export.folder} has files of an earlier export. Replace them?"
        ask(self.dialog, "Replace files?", text, f"{more}.", (("&Replace", DESTROY, lambda: self._accept(export)),))

    def _accept(self, export: Export) -> None:
        self.dialog.remember(export)
        self.start(export)

    def _replaced(self, export: Export) -> list[str]:
        """Return the files that there are already, relative to the folder. A batch skips what is complete."""
        if export.from_files:
            return []
        frames = self._frames(export.scope, self._entries(export.scope)) if export.options.filenames() else []
        files = [Path(frame.folder, name) for frame in frames for name in self.dialog.files.names()]
        files += [] if export.report is None else [export.report]
        return [str(file.name if file.is_absolute() else file) for file in files if (export.folder / file).exists()]

    def _take(self, steps: list[Step]) -> None:
        done = [step for step in steps if isinstance(step, ExportedFrame)]
        self._done += done
        self.dialog.add(done)
        assert self._export is not None
        for frame in done:
            id = self._ids.get(frame.folder.name)
            if id is not None and frame.status is not ExportStatus.FAILED:
                self._playing.written[id] = partial(written_depth, frame.folder, self._export.options.depth_units)
        if isinstance(steps[-1], Progress):
            self.dialog.work.show_share(steps[-1].share)
            self.dialog.message.show_message(f"Report: {steps[-1].text}")
        else:
            self._show_frames()

    def _show_frames(self) -> None:
        count, left = len(self._done), self._total - len(self._done)
        written = sum(frame.status is ExportStatus.WRITTEN for frame in self._done)
        self.dialog.work.show_share(count / max(self._total, 1), written / max(written + left, 1))
        self.dialog.message.show_message(f"{count} of {counted(self._total, 'frame')}")
        self._status.show_exporting(f"Exporting {count} of {max(self._total, 1)}")

    def _end(self, text: str = "") -> None:
        """Say what was written; what was not, and what is lost, in the dialog or else in one message."""
        export, done = self._export, self._done
        assert export is not None
        counts = Counter(frame.status for frame in done)
        parts = [f"{counts[status]} {status}" for status in ExportStatus if counts[status]]
        report = None if text else export.report
        parts += [] if report is None else [report.name]
        failed = [f"{frame.name}: {frame.notes[0]}" for frame in done if frame.status is ExportStatus.FAILED]
        notes = failed[:_MAX_NAMED] if failed or len(done) != 1 else list(done[0].notes)
        summary = f"{text}Exported to {export.folder}: {', '.join(parts) or 'nothing'}."
        self.dialog.end("\n".join([summary, *notes]), "warning" if text or failed else "good")
        self._status.show_exporting("")
        self.context.notes.show_message(" ".join([summary, *notes]))
        if not self.dialog.isVisible():
            self.context.notes.warn(f"Not exported: {counted(len(failed), 'frame')}", failed)
        if report is not None and self.dialog.opens.isChecked():
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(report.absolute())))

    def _fail(self, error: Exception) -> None:
        self.dialog.end(error_text(error), "error")
        self._status.show_exporting("")
        if not self.dialog.isVisible():
            self.context.notes.report("Export", error)

    def _open(self, frame: ExportedFrame) -> None:
        """Open the run of a frame; show why a failed one has none."""
        record = frame.folder / RECORD_FILE
        if frame.status is not ExportStatus.FAILED and record.exists():
            self.context.feature(DocumentsFeature).open_run(record)
        else:
            self.dialog.message.show_message(f"{frame.name}: {' '.join(frame.notes) or 'no run record'}", "warning")


def behind(document: Document) -> str:
    """Describe which blocks of a frame lack up-to-date results; "" for none."""
    counts = document.counts()
    without = len(counts.keys() - document.valid_results().keys())
    otherwise = len(document.changed_blocks()) - without
    lacks = {
        "Not run in their current state, so that their missing depth stays missing": without,
        "Run with other parameters than the current ones": otherwise,
    }
    sentences = [f"{what}: {count} of {len(counts)} blocks." for what, count in lacks.items() if count]
    return " ".join([*sentences, "Run them first (F5)."] if sentences else [])
