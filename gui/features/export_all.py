"""Export of all frames of the list, in the background."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QDialog, QWidget

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.data.results import Completion
from ilf.errors import InputError
from ilf.project.exporting import (
    ExportedFrame,
    ExportStatus,
    FrameToExport,
    export_frames,
    folder_names,
    run_and_completion,
)
from ilf.run.block_choice import BlockChoice
from ilf.run.options import ExportOptions
from ilf.run.run import Run
from ilf.sources.reading import read_frame

from ..project.store import WorkStore
from ..state.document import Document
from ..state.entries import Entry
from ..widgets.basics import Message, stack
from ..widgets.file_choice import EXPORTS, remember_folder, save_folder
from ..widgets.work_row import WorkRow
from ..work.jobs import Worker
from .context import Context, Feature, PendingWork
from .documents.export import ExportDialog

ALL_FRAMES, WORKED_ON, DONE = "all", "worked on", "done"
"""Choices of frames."""

_CHOICES: dict[str, tuple[str, Callable[[Entry], bool]]] = {
    DONE: ("Frames marked as done", lambda entry: entry.summary.done),
    WORKED_ON: ("Frames that have been worked on", lambda entry: entry.summary.has_work),
    ALL_FRAMES: ("All frames of the list", lambda entry: True),
}
"""Choice -> its text, and whether it includes a frame."""

Read = Callable[[], tuple[Run, Completion | None]]
MakeRun = Callable[[RGBDFrame], Run]

# Frames of the window as frames to export.


def frames_to_export(
    entries: Sequence[Entry], store: WorkStore, make_run: MakeRun, for_all: Parameters | None
) -> list[FrameToExport]:
    """Snapshot of frames, open or not; closed frames are read when they are reached, in any thread.

    Parameters
    ----------
    entries : sequence of Entry
    store : WorkStore
        Of the states of closed frames.
    make_run : callable
        Makes the run of a frame without blocks.
    for_all : Parameters or None
        The parameters that all frames share, if any.
    """
    folders = folder_names([(entry.name, entry.id) for entry in entries])
    return [
        FrameToExport(entry.name, folder, _reader(entry, store, make_run, for_all))
        for entry, folder in zip(entries, folders, strict=True)
    ]


def _reader(entry: Entry, store: WorkStore, make_run: MakeRun, for_all: Parameters | None) -> Read:
    if entry.document is not None and entry.document.counts():
        present = _of_session(entry.document)
        return lambda: present
    if entry.document is None and entry.has_state and store.has(entry.id):
        return partial(_of_store, entry, store, for_all)
    return partial(_of_files, entry, make_run)


def _of_session(document: Document) -> tuple[Run, Completion | None]:
    """The run of an open frame, and its completion if every block has a result."""
    if document.counts().keys() - document.valid_results().keys():
        return document.run(document.state.common, extrapolate=document.state.extrapolate), None
    return document.run(document.state.common, extrapolate=document.extrapolated), document.completion()


def _of_store(entry: Entry, store: WorkStore, for_all: Parameters | None) -> tuple[Run, Completion | None]:
    state = store.read(entry.id).state
    return run_and_completion(state.with_current_settings(entry.note, for_all))


def _of_files(entry: Entry, make_run: MakeRun) -> tuple[Run, Completion | None]:
    if entry.source is None:
        raise InputError("It has not been read, and where from is not known. Open it first.")
    return make_run(read_frame(entry.source)), None


# The command, and the progress.


class ExportProgress(QDialog):
    """Progress of an export of many frames. It may be closed meanwhile."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Export all")
        self.state = Message(lines=2)
        self.work = WorkRow("export", "finished frames stay, and exporting again goes on")
        stack(self, self.state, self.work)
        self.setMinimumWidth(440)


class ExportAllFeature(Feature):
    """The command *File > Export all…*: its dialog, and the export."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.progress = ExportProgress(context.window)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take)
        self.worker.finished.connect(lambda _: self._end())
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self._end("Cancelled. Export again to go on. "))
        self.progress.work.cancelled.connect(self.worker.cancel)
        self._folder = Path()
        self._frames: list[FrameToExport] = []
        self._done: list[ExportedFrame] = []

    def ask(self) -> None:
        """Open the dialog, or show the progress of the export that is being made."""
        if self.worker.busy:
            self.progress.show()
            return
        document = self.context.workspace.current
        scopes = {name: (text, len(self._chosen(name))) for name, (text, _) in _CHOICES.items()}
        dialog = ExportDialog(
            document.run(document.state.common), True, str(save_folder() / "export"), self.context.window, scopes=scopes
        )
        usual = next(name for name in _CHOICES if scopes[name][1])
        dialog.scope.setCurrentIndex(dialog.scope.findData(usual))
        dialog.accepted.connect(
            lambda: self.export(Path(dialog.folder()), dialog.options(), str(dialog.scope.currentData()))
        )
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()

    def export(self, folder: Path, options: ExportOptions, scope: str = ALL_FRAMES) -> None:
        """Export a choice of frames in the background."""
        workspace = self.context.workspace
        shared = workspace.parameters.shared
        parameters, blocks = workspace.parameters.current, BlockChoice(workspace.parameters.extraction)
        self._frames = frames_to_export(
            self._chosen(scope),
            self.context.recorder.store,
            lambda frame: Run(frame, blocks.blocks_of(frame), parameters),
            shared.values if shared.on else None,
        )
        self._folder, self._done = folder.absolute(), []
        remember_folder(EXPORTS, self._folder)
        frames = self._frames

        def job() -> Generator[ExportedFrame, None, None]:
            yield from export_frames(frames, self._folder, options)

        self.progress.work.begin()
        self._describe()
        self.progress.show()
        self.worker.start(job)

    def pending_work(self) -> Sequence[PendingWork]:
        """The export in progress, if any."""
        return [PendingWork(f"an export of {counted(len(self._frames), 'frame')}")] if self.worker.busy else []

    def _chosen(self, scope: str) -> list[Entry]:
        _, includes = _CHOICES[scope]
        return [entry for entry in self.context.workspace.entries if includes(entry)]

    def _take(self, done: list[ExportedFrame]) -> None:
        self._done += done
        self._describe()

    def _describe(self) -> None:
        done, total = len(self._done), len(self._frames)
        self.progress.work.show_share(done / max(total, 1))
        name = self._frames[done].name if done < total else ""
        self.progress.state.show_message(f"{done} of {counted(total, 'frame')}. {name}".strip())

    def _end(self, text: str = "") -> None:
        self.progress.work.end()
        self.progress.close()
        counts = Counter(frame.status for frame in self._done)
        parts = [f"{count} {status}" for status, count in counts.items()]
        self.context.notes.show_message(f"{text}Exported to {self._folder}: {', '.join(parts) or 'nothing'}.")
        failed = [frame for frame in self._done if frame.status is ExportStatus.FAILED]
        self.context.notes.warn(
            f"Not exported: {counted(len(failed), 'frame')}", [f"{frame.name}: {frame.notes[0]}" for frame in failed]
        )

    def _fail(self, error: Exception) -> None:
        self.progress.work.end()
        self.progress.close()
        self.context.notes.report("Export all", error)
