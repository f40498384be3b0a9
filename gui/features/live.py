"""Playing a recording or a camera live: colour, measured and completed depth, recording, and freezing a frame to
correct it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPixmap, QResizeEvent
from PySide6.QtWidgets import (
    QDialog,
    QFileDialog,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
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

from ..state.parts import NO_PART, Part
from ..views.colours import DEPTH_MAP, depth_table
from ..views.drawings import rgb_image
from ..widgets.basics import Message, PlainLabel, give_size, lay_out
from ..widgets.file_choice import choose_file, choose_folder, last_folder
from ..widgets.notices import error_text
from ..work.latest_request import Job, LatestRequest
from .context import Context
from .documents.feature import DocumentsFeature
from .documents.frame_files import recording_files
from .panel import Panel

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


def play(path: str | None, rate: float | None, parameters: Parameters, tape: Tape) -> Generator[LiveFrame, None, str]:
    """Play a source at its rate, or the connected RealSense camera (None): yields completed frames; returns how it has
    ended."""
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
    return "The recording has ended."


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


class LiveFeature(Panel):
    """Plays recordings and cameras live, in a window that may be closed at any time, which ends playing."""

    title, group, parts = "Play live", None, NO_PART
    what = "live window"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.tape = Tape()
        self.shown: LiveFrame | None = None
        """The newest frame that was played."""
        self._undrawn: LiveFrame | None = None
        """The same, until it is drawn: frames may come faster than that."""
        self._times = deque[float](maxlen=_RECENT)
        self._problem = ""
        """Why the last recording ended, if it could not be written."""
        self._levels: tuple[int, tuple[float, float]] | None = None
        self.requests.ended.connect(lambda: self._end("Stopped."))
        self._saver = LatestRequest(self, self._tell_error, must_finish=True)
        _ = self.widget

    def make(self) -> QDialog:
        dialog = QDialog(self.context.window)
        dialog.setWindowFlag(Qt.WindowType.WindowMinMaxButtonsHint)
        dialog.finished.connect(self.requests.cancel)
        names = ("Colour", "Depth, measured", "Depth, completed")
        self.pictures = {name: LivePicture(name) for name in names}
        columns = tuple(
            lay_out(QVBoxLayout(), picture, PlainLabel(name), stretched=picture)
            for name, picture in self.pictures.items()
        )
        row = lay_out(QHBoxLayout(), *columns, spacing=8, stretched=columns)
        self.state = Message(lines=2)
        self.freeze_button = QPushButton("&Freeze", autoDefault=False)
        self.freeze_button.setToolTip("Open the frame shown here in the main window, to correct it")
        self.record_button = QPushButton("&Record…", autoDefault=False)
        self.record_button.setToolTip("Record completed frames: a file *.mcap of ROS 2, or a folder")
        self.play_button = QPushButton("&Stop", autoDefault=False)
        self.play_button.setToolTip("Stop playing, or play again from the start")
        self.freeze_button.clicked.connect(self.freeze)
        self.record_button.clicked.connect(self.toggle_recording)
        self.play_button.clicked.connect(lambda: self.requests.cancel() if self.busy else self.play(*self._what))
        buttons = lay_out(QHBoxLayout(), self.freeze_button, self.record_button, self.play_button, None)
        lay_out(QVBoxLayout(dialog), row, self.state, buttons, margins=(14, 14, 14, 14), spacing=10, stretched=row)
        give_size(dialog, 1100, 420)
        return dialog

    def refresh(self, parts: Part) -> None:
        """Draw the newest frame, unless that is done."""
        frame, self._undrawn = self._undrawn, None
        if frame is not None:
            self._show(frame)

    def ask_recording(self) -> None:
        """Choose a recording, and play it."""
        if path := choose_file(self.context.window, "Play live", _FOLDER_KEY, recording_files()):
            self.play(path)

    def ask_folder(self) -> None:
        """Choose a folder of frames, a data set or a recording that is a folder, and play it."""
        if path := choose_folder(self.context.window, "Play live", _FOLDER_KEY):
            self.play(path)

    def play(self, path: str | None = None, rate: float | None = None) -> None:
        """Play a recording, a folder, or the connected RealSense camera (None) with the current parameters; what is
        being played ends first."""
        self._what = path, rate  # also to be played again
        self.requests.cancel()
        self.widget.setWindowTitle(f"Play live: {_CAMERA if path is None else Path(path).name}")
        self.widget.show()
        self.widget.raise_()
        self._times.clear()
        self._levels = self._undrawn = None
        self.play_button.setText("&Stop")
        self.state.show_message(f"Waiting for the {_CAMERA} …" if path is None else f"Reading {path} …")
        parameters, tape = self.context.workspace.parameters.current, self.tape
        self.requests.ask(
            lambda: play(path, rate, parameters, tape), self._end, step=self._take, what="a live recording"
        )

    def pending_work(self) -> Sequence[Job]:
        """The recording in progress, if any."""
        return super().pending_work() if self.shown is not None and self.shown.recorded else ()

    def freeze(self) -> None:
        """Open the shown frame as a normal frame; playing stops. A camera's frame is first written into a folder."""
        if self.shown is None:
            return
        frame = self.shown.completion.frame
        self.requests.cancel()
        if frame.inputs is not None:
            self.open_frozen(FrameRef.of(frame.inputs))
            return
        path, _ = QFileDialog.getSaveFileName(
            self.widget, "Folder for the frozen frame", f"{last_folder(_FOLDER_KEY)}/frame", "Folder (*)"
        )
        if path:
            self._saver.ask(lambda: write_frame(path, frame), lambda _: self.open_frozen(FrameRef(path)))

    def open_frozen(self, source: FrameRef) -> None:
        """Open a frame in the main window."""
        self.context.window.raise_()
        self.context.window.activateWindow()
        self.context.feature(DocumentsFeature).open_source(source)

    def toggle_recording(self) -> None:
        """Ask where to record, or end the recording."""
        if self.record_button.text() != "&Record…":
            self.record(None)
            return
        path, _ = QFileDialog.getSaveFileName(
            self.widget, "Record", f"{last_folder(_FOLDER_KEY)}/recording.mcap", "ROS 2 recording (*.mcap);;Folder (*)"
        )
        if path:
            self.record(Path(path))

    def record(self, path: Path | None) -> None:
        """Record the following frames into a file *.mcap or a folder; None ends the recording."""
        self.tape.wanted = path
        self._problem = ""
        self.record_button.setText("&Record…" if path is None else "End &recording")

    def _take(self, frame: LiveFrame) -> None:
        self.shown = self._undrawn = frame
        self._times.append(time.monotonic())
        if frame.problem:
            self.record(None)
            self._problem = frame.problem
        self.redraw()

    def _show(self, frame: LiveFrame) -> None:
        completion, found = frame.completion, frame.statistics
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

    def fail(self, error: Exception) -> None:
        self._end(error_text(error), "warning")

    def _tell_error(self, error: Exception) -> None:
        self.state.show_message(error_text(error), "warning")

    def _end(self, why: str, tone: str = "muted") -> None:
        """Say why playing has ended, once, unless something else is to be played."""
        if self.busy or self.play_button.text() == "&Play again":
            return
        self.refresh(NO_PART)
        self.tape.wanted = None
        self.record_button.setText("&Record…")
        self.play_button.setText("&Play again")
        self.state.show_message(f"{why} {self.state.text()}" if self.shown is not None else why, tone)
