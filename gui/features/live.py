"""Playing a recording or a camera live: colour, measured and completed depth, recording, and freezing a frame to
correct it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent, QPixmap, QResizeEvent
from PySide6.QtWidgets import (
    QDialog,
    QFileDialog,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.cancellation import acquired
from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.data.results import Completion
from ilf.drawing.colours import robust_depth_levels, to_indices
from ilf.errors import IlfError
from ilf.sources.frame_folder import write_frame
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading import read_frame
from ilf.sources.realsense import camera_pairs
from ilf.sources.registration import register
from ilf.sources.source import Source
from ilf.stream.pacing import USUAL_RATE, measured_rate, rate_of
from ilf.stream.recording import StreamRecorder, stamped
from ilf.stream.stream import Stream, StreamStatistics

from ..views.colours import DEPTH_MAP, depth_table
from ..views.pixel_items import rgb_image
from ..widgets.basics import Message, PlainLabel, give_size, lay_out
from ..widgets.file_choice import choose_file, choose_folder, last_folder
from ..widgets.notices import error_text
from ..work.jobs import Worker
from .context import Context, Feature, PendingWork
from .documents.feature import DocumentsFeature
from .documents.frame_files import recording_files

_CAMERA = "RealSense camera"

_FOLDER_KEY = "live/folder"
_RECENT = 20
"""Number of frames over which the rate is measured."""

# Playing, in the worker's thread.


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """A completed frame, the rate of its source, what the stream has done so far, the number of recorded frames, and
    why recording ended."""

    completion: Completion
    rate: float
    statistics: StreamStatistics
    recorded: int
    problem: str = ""


class Tape:
    """What is to be recorded: set in the window's thread, used in the worker's."""

    def __init__(self) -> None:
        self.wanted: Path | None = None
        """The file or folder into which the following frames are recorded; None for none."""
        self._recorder: StreamRecorder | None = None

    def write(self, completion: Completion, stamp: int) -> tuple[int, str]:
        """Write a frame if wanted; return the number of frames written, and why recording ended."""
        wanted = self.wanted
        try:
            if self._recorder is not None and self._recorder.path != wanted:
                self.close()
            if wanted is None:
                return 0, ""
            if self._recorder is None:
                self._recorder = StreamRecorder(wanted)
            self._recorder.write(stamped(completion, stamp, with_error=False))
        except IlfError as error:
            count = 0 if self._recorder is None else self._recorder.count
            self.wanted = None
            self.close()
            return count, str(error)
        return self._recorder.count, ""

    def close(self) -> None:
        """End the present recording."""
        if self._recorder is not None:
            self._recorder.close()
            self._recorder = None


_playing = threading.Lock()
"""Held by the thread that plays: one that was cancelled may still be completing a frame."""


def play(path: str | None, rate: float | None, parameters: Parameters, tape: Tape) -> Generator[LiveFrame, None, None]:
    """Play a source at its rate, or the connected RealSense camera (None): yields completed frames."""
    with acquired(_playing), closing(tape):
        if path is None:
            usual, frames = USUAL_RATE, _captured()
        else:
            source = Source(path)
            usual, frames = (
                rate_of(source.timestamps or ()),
                _readable(partial(read_frame, source.ref(key)) for key in source.keys),
            )
        chosen = rate or usual
        with closing(frames), Stream(parameters, rate=chosen) as stream, closing(stream.play(frames)) as played:
            for completion in played:
                recorded, problem = tape.write(completion, time.time_ns())
                yield LiveFrame(completion, chosen, stream.statistics, recorded, problem)


def _captured() -> Generator[RGBDFrame, None, None]:
    """The frames of the connected camera; the first must be valid."""
    with closing(camera_pairs()) as pairs:
        yield register(next(pairs))
        yield from _readable(partial(register, pair) for pair in pairs)


def _readable(readers: Iterable[Callable[[], RGBDFrame]]) -> Generator[RGBDFrame, None, None]:
    """The frames that can be read; one without any depth, for example, is left out."""
    for read in readers:
        with suppress(IlfError):
            yield read()


# The window.


class LivePicture(PlainLabel):
    """A picture that fills its place."""

    def __init__(self, name: str) -> None:
        super().__init__(alignment=Qt.AlignmentFlag.AlignCenter)
        self.setAccessibleName(name)
        self.setMinimumSize(QSize(200, 150))
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        self._whole = QPixmap()

    def show_rgb(self, rgb: NDArray[np.uint8]) -> None:
        """Show uint8 (H, W, 3)."""
        self._whole = QPixmap.fromImage(rgb_image(rgb))
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        if not self._whole.isNull():
            self.setPixmap(self._whole.scaled(self.size(), Qt.AspectRatioMode.KeepAspectRatio))


class LiveWindow(QDialog):
    """Shows the frames that are played. It may be closed at any time, which ends playing.

    Signals
    -------
    frozen(FrameRef)
        The frame to be opened as a normal one.
    """

    frozen = Signal(object)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Play live")
        self.setWindowFlag(Qt.WindowType.WindowMinMaxButtonsHint)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take)
        self.worker.finished.connect(lambda _: self._end("The recording has ended."))
        self.worker.failed.connect(lambda error: self._end(error_text(error), "warning"))
        self.worker.cancelled.connect(lambda: self._end("Stopped."))
        self.tape = Tape()
        self.shown: LiveFrame | None = None
        """The frame shown at present."""
        self._times = deque[float](maxlen=_RECENT)
        self._problem = ""
        """Why the last recording ended, if it could not be written."""
        self._levels: tuple[int, tuple[float, float]] | None = None

        names = ("Colour", "Depth, measured", "Depth, completed")
        self.pictures = {name: LivePicture(name) for name in names}
        columns = tuple(
            lay_out(QVBoxLayout(), picture, PlainLabel(name), stretched=picture)
            for name, picture in self.pictures.items()
        )
        row = lay_out(QHBoxLayout(), *columns, spacing=8, stretched=columns)
        self.state = Message(lines=2)
        self.saver = Worker(self, must_finish=True)
        self.saver.finished.connect(self.frozen)
        self.saver.failed.connect(lambda error: self.state.show_message(error_text(error), "warning"))
        self.freeze_button = QPushButton("&Freeze", autoDefault=False)
        self.freeze_button.setToolTip("Open the frame shown here in the main window, to correct it")
        self.record_button = QPushButton("&Record…", autoDefault=False)
        self.record_button.setToolTip("Record completed frames: a file *.mcap of ROS 2, or a folder")
        self.play_button = QPushButton("&Stop", autoDefault=False)
        self.play_button.setToolTip("Stop playing, or play again from the start")
        self.freeze_button.clicked.connect(self.freeze)
        self.record_button.clicked.connect(self.toggle_recording)
        self.play_button.clicked.connect(self.toggle)
        buttons = lay_out(QHBoxLayout(), self.freeze_button, self.record_button, self.play_button, None)
        lay_out(QVBoxLayout(self), row, self.state, buttons, margins=(14, 14, 14, 14), spacing=10, stretched=row)
        give_size(self, 1100, 420)

    def play(self, path: str | None, rate: float | None, parameters: Parameters) -> None:
        """Play a source, or the connected RealSense camera (None); what is being played ends first."""
        self._what = path, rate, parameters  # also to be played again
        self.setWindowTitle(f"Play live: {_CAMERA if path is None else Path(path).name}")
        if self.worker.busy:
            self.worker.cancel()
            self.worker.cancelled.connect(self._begin, Qt.ConnectionType.SingleShotConnection)
        else:
            self._begin()

    def freeze(self) -> None:
        """Open the shown frame as a normal frame; playing stops. A camera's frame is first written into a folder."""
        if self.shown is None:
            return
        frame = self.shown.completion.frame
        self.worker.cancel()
        if frame.inputs is not None:
            self.frozen.emit(FrameRef.of(frame.inputs))
            return
        path, _ = QFileDialog.getSaveFileName(
            self, "Folder for the frozen frame", f"{last_folder(_FOLDER_KEY)}/frame", "Folder (*)"
        )
        if path:
            self.save(frame, path)

    def save(self, frame: RGBDFrame, folder: str) -> None:
        """Write a frame into a folder, and open it from there."""

        def job() -> Generator[None, None, FrameRef]:
            yield None
            write_frame(folder, frame)
            return FrameRef(folder)

        if not self.saver.busy:
            self.saver.start(job)

    def toggle(self) -> None:
        """Stop, or play again."""
        if self.worker.busy:
            self.worker.cancel()
        else:
            self._begin()

    def toggle_recording(self) -> None:
        """Ask where to record, or end the recording."""
        if self.record_button.text() != "&Record…":
            self.record(None)
            return
        path, _ = QFileDialog.getSaveFileName(
            self, "Record", f"{last_folder(_FOLDER_KEY)}/recording.mcap", "ROS 2 recording (*.mcap);;Folder (*)"
        )
        if path:
            self.record(Path(path))

    def record(self, path: Path | None) -> None:
        """Record the following frames into a file *.mcap or a folder; None ends the recording."""
        self.tape.wanted = path
        self._problem = ""
        self.record_button.setText("&Record…" if path is None else "End &recording")

    def closeEvent(self, event: QCloseEvent) -> None:
        self.worker.cancel()
        super().closeEvent(event)

    def _begin(self) -> None:
        path, rate, parameters = self._what
        self._times.clear()
        self._levels = None
        self.play_button.setText("&Stop")
        self.state.show_message(f"Waiting for the {_CAMERA} …" if path is None else f"Reading {path} …")
        tape = self.tape
        self.worker.start(lambda: play(path, rate, parameters, tape))

    def _take(self, frames: list[LiveFrame]) -> None:
        now = time.monotonic()
        self._times.extend(now for _ in frames)
        problem = next((frame.problem for frame in frames if frame.problem), "")
        if problem:
            self.record(None)
            self._problem = problem
        self._show(frames[-1])

    def _show(self, frame: LiveFrame) -> None:
        completion, found = frame.completion, frame.statistics
        self.shown = frame
        if self._levels is None or self._levels[0] != found.scenes:  # the same colours while the scene stays the same
            self._levels = found.scenes, robust_depth_levels(completion.depth)
        levels = self._levels[1]
        table = depth_table(DEPTH_MAP)[..., :3]
        colour, measured, completed = self.pictures.values()
        colour.show_rgb(completion.frame.rgb)
        measured.show_rgb(table[to_indices(completion.frame.depth, *levels)])
        completed.show_rgb(table[to_indices(completion.depth, *levels)])
        recorded = f"; recorded: {counted(frame.recorded, 'frame')}" if frame.recorded else ""
        self.state.show_message(
            f"{completion.frame.name}: {measured_rate(self._times):.1f} of {frame.rate:.1f} frames a second; latency "
            f"{1000 * found.median:.0f} ms (median), {1000 * found.worst:.0f} ms (95 %); "
            f"{counted(found.frames, 'frame')} completed, {found.dropped} dropped, {counted(found.scenes, 'scene')}"
            f"{recorded}. {self._problem}",
            "warning" if self._problem else "muted",
        )

    def _end(self, why: str, tone: str = "muted") -> None:
        self.tape.wanted = None
        self.record_button.setText("&Record…")
        self.play_button.setText("&Play again")
        self.state.show_message(f"{why} {self.state.text()}" if self.shown is not None else why, tone)


class LiveFeature(Feature):
    """Plays recordings and cameras live, in their window."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.window = LiveWindow(context.window)
        self.window.frozen.connect(self._open)

    def ask_recording(self) -> None:
        """Choose a recording, and play it."""
        if path := choose_file(self.context.window, "Play live", _FOLDER_KEY, recording_files()):
            self.play(path)

    def ask_folder(self) -> None:
        """Choose a folder of frames, a data set or a recording that is a folder, and play it."""
        if path := choose_folder(self.context.window, "Play live", _FOLDER_KEY):
            self.play(path)

    def play(self, path: str | None = None, rate: float | None = None) -> None:
        """Play a recording, a folder, or the connected RealSense camera (None) with the current parameters."""
        self.window.show()
        self.window.raise_()
        self.window.play(path, rate, self.context.workspace.parameters.current)

    def pending_work(self) -> list[PendingWork]:
        """The recording in progress, if any."""
        shown = self.window.shown
        return [PendingWork("a live recording")] if self.window.worker.busy and shown and shown.recorded else []

    def _open(self, source: FrameRef) -> None:
        self.context.window.raise_()
        self.context.window.activateWindow()
        self.context.feature(DocumentsFeature).open_source(source)
