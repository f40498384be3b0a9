"""Playing frames in the views: those of the list, or live, of a recording, a folder or a camera; with speed, loop,
completion and recording as they play. Pausing opens the frame shown."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import chain, islice
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QHBoxLayout, QWidget

from ilf._runtime.formatting import counted
from ilf._runtime.long_work import acquired
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.errors import IlfError
from ilf.sources.frame_folder import write_frame
from ilf.sources.frame_ref import FrameRef
from ilf.stream.pacing import USUAL_RATE, latest_of, measured_rate, rate_of
from ilf.stream.stream import Stream, StreamStatistics

from ...base import theme
from ...base.commands import Command, command
from ...base.needs import Need, sentence
from ...state.document import Document
from ...state.parts import Part
from ...state.workspace import Entry
from ...views.view_data import Before, Depth
from ...widgets.basics import command_button, lay_out, menu_button
from ...widgets.file_choice import ask_path, choose_file, choose_folder
from ...work.jobs import Make, Order, Worker
from ...work.latest_request import LatestRequest
from ..context import Context, Feature
from ..documents.feature import DocumentsFeature
from ..documents.frame_files import recording_files
from ..frame_list.feature import FramesFeature
from ..menus import PLAY_MENU
from ..status import StatusFeature
from .moment import Due, Moment, moment_reader

if TYPE_CHECKING:
    from .live import MomentRecorder

# Playing, in the worker's thread.


@dataclass
class Playback:
    """How frames are played: set in the window's thread, read in the worker's.

    Attributes
    ----------
    own_rate : float
        Frames a second of what is played.
    speed : float or None
        Multiple of that; None for as many as can be read and shown, without leaving any out.
    loop : bool
        Whether the first frame follows the last.
    completes : bool
        Whether frames without a result are completed.
    flickers : bool
        Whether the change against the frame before is wanted.
    recorder : MomentRecorder or None
        Records the frames shown.
    """

    own_rate: float = USUAL_RATE
    speed: float | None = 1.0
    loop: bool = False
    completes: bool = False
    flickers: bool = False
    recorder: MomentRecorder | None = None

    @property
    def rate(self) -> float | None:
        """Frames a second; None for as many as can be read and shown."""
        return None if self.speed is None else self.speed * self.own_rate


@dataclass(frozen=True, eq=False)
class PlayedFrame:
    """A frame that is due.

    Attributes
    ----------
    row : int
    moment : Moment
    before : Before
        The frame that was shown before.
    left_out, unreadable, recorded : int
        Number of frames so far that were left out because they were late, that cannot be read, that were recorded.
    completing : StreamStatistics
        What has been completed so far.
    """

    row: int
    moment: Moment
    before: Before
    left_out: int
    unreadable: int
    recorded: int
    completing: StreamStatistics


_playing = threading.Lock()
"""Held by the thread that plays: one that was cancelled may still be completing a frame."""


def play(
    frames: Generator[Due, None, None], playback: Playback, parameters: Parameters, count: int = 0
) -> Generator[PlayedFrame, None, None]:
    """Yield frames, each read when it is due; of those that are late, only the latest. Time counts from the first one,
    which loads what completes frames.

    Parameters
    ----------
    frames : generator of Due
    playback : Playback
    parameters : Parameters
        Of the filter, to complete frames.
    count : int
        Playing ends after so many frames in a row that cannot be read; never for 0.

    Raises
    ------
    IlfError
        Why the last frame cannot be read, if none can.
    """
    before, shown, left_out, unreadable, failed = None, 0, 0, 0, 0
    problem: IlfError | None = None
    with (
        acquired(_playing),
        closing(frames),
        closing(latest_of(frames, lambda: playback.rate)) as due,
        Stream(parameters, rate=playback.rate or USUAL_RATE) as stream,
    ):
        for (row, read), late in chain(((first, 0) for first in islice(frames, 1)), due):
            left_out += late
            try:
                moment = read()
                if playback.completes and moment.depth is None:
                    depth = stream.complete(moment.frame).depth
                    moment = replace(moment, depth=depth, text="completed as it plays")
            except IlfError as error:
                unreadable, failed, problem = unreadable + 1, failed + 1, error
                if failed == count:
                    break
            else:
                before = before if row > shown else None  # the first one again
                change = moment.since(before, row - shown) if playback.flickers else Before()
                recorder = playback.recorder
                recorded = 0 if recorder is None else recorder.write(moment)
                yield PlayedFrame(row, moment, change, left_out, unreadable, recorded, stream.statistics)
                before, shown, failed = moment, row, 0
        if before is None and problem is not None:
            raise problem


def frames_from(readers: Sequence[Callable[[], Moment]], row: int, playback: Playback) -> Generator[Due, None, None]:
    """Yield the frames of a list from a row on, from the first one again if they are played in a loop."""
    yield from list(enumerate(readers))[row:]
    while playback.loop:
        yield from enumerate(readers)


# The window.

_SPEEDS: Mapping[str, tuple[str, float | None]] = {
    "speed_quarter": ("0.25\N{MULTIPLICATION SIGN}", 0.25),
    "speed_half": ("0.5\N{MULTIPLICATION SIGN}", 0.5),
    "speed_normal": ("1\N{MULTIPLICATION SIGN}", 1.0),
    "speed_double": ("2\N{MULTIPLICATION SIGN}", 2.0),
    "speed_fourfold": ("4\N{MULTIPLICATION SIGN}", 4.0),
    "speed_fastest": ("As fast as it goes", None),
}
"""Commands of the speeds: text, and multiple of the sequence's own rate."""


def _speed_command(name: str) -> Command:
    text, speed = _SPEEDS[name]
    hint = f"Play at {text} of the sequence's own rate"
    if speed is None:
        hint = "Play every frame, as many a second as can be read and shown"
    return Command(
        name, text, hint, group="speed", on=name == "speed_normal", handler=lambda play: play.set_speed(speed)
    )


_RECENT = 20
"""Number of frames over which the rate is measured."""

_FOLDER_KEY = "live/folder"
_NO_CAMERA = 'Install pyrealsense2 first: pip install "ilf-studio[sensors]".'


def _why_no_camera(_: PlayFeature) -> str:
    return "" if find_spec("pyrealsense2") else _NO_CAMERA


class PlayFeature(Feature):
    """Plays frames: those of the list, or live. None is open meanwhile, so that no edit can get lost or into another
    frame; pausing opens the frame shown."""

    awaits = Need.OTHERS
    more_commands = tuple(map(_speed_command, _SPEEDS))

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._frames = context.feature(FramesFeature)
        self._status = context.feature(StatusFeature)
        self._on = context.actions["play_frames"]
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take)
        self.worker.finished.connect(lambda _: self._on.setChecked(False))
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(self._start)
        self.playback = Playback()
        self.written: dict[str, Callable[[], Depth | None]] = {}
        """Id of a frame -> what reads its depth in the latest export of this window that completed it from its
        files."""
        self.shown: PlayedFrame | None = None
        """The frame shown by playing; None once an open one is shown again."""
        self._entries: list[Entry] = []
        """What is played of the list; nothing if it is played live."""
        self._live: tuple[str | None, float | None] | None = None
        """The recording or folder that is played live, None for the camera, and the rate that was given."""
        self._job: Make | None = None
        """What waits for the end of what was played before."""
        self._completed = False
        """Whether the list was completed while playing before frames were played live."""
        self._left: Document | None = None
        """The frame that was open before."""
        self._opening = False
        """Whether the frame shown is being opened."""
        self._place: tuple[float, float, float] | None = None
        """The place that the views show when playing ends."""
        self._clock = deque[float](maxlen=_RECENT)
        self._saver = LatestRequest(self, must_finish=True)
        self.bar = self._make_bar()
        context.centre.add_before(self._frames.bar, self.bar)
        self._listen()

    def _listen(self) -> None:
        """Follow the frames and what the user does elsewhere."""
        context, entries = self.context, self.workspace.entries
        context.views.pressed.connect(lambda: self._on.setChecked(False))
        context.refresh.add("opened frame", self._follow, Part.FRAME)
        context.refresh.add("played", self._settle, Part.FRAME | Part.LIST | Part.LOADING)
        self._on.toggled.connect(lambda _: context.refresh.mark("play bar"))
        context.refresh.add("play bar", lambda: self.bar.setVisible(len(entries) > 1 or self.playing), Part.LIST)

    def _make_bar(self) -> QWidget:
        """Return the buttons beside the film strip, play and a menu of what belongs to it."""
        actions = self.context.actions
        menu = actions.menu("", self.context.window, PLAY_MENU)
        texts = {name: "max" if speed is None else text for name, (text, speed) in _SPEEDS.items()}
        chosen = next(text for name, text in texts.items() if actions.is_on(name))
        button = menu_button(menu, chosen, "Speed, loop, completion and recording while playing")
        button.setAccessibleName("Speed of playing")
        for name, text in texts.items():
            actions[name].toggled.connect(lambda on, text=text: button.setText(text) if on else None)
        bar = QWidget(visible=False)
        lay_out(QHBoxLayout(bar), command_button(self._on), button, margins=(4, 0, 4, 0), spacing=0)
        return bar

    @command("play_loop", "&Loop", checkable=True)
    def _set_loop(self, on: bool) -> None:
        """Go on with the first frame after the last one."""
        self.playback.loop = on

    @command("play_completed", "&Complete while playing", checkable=True)
    def _set_completes(self, on: bool) -> None:
        """Complete frames without a result as they play, as a stream does; nothing is stored."""
        self.playback.completes = on

    @command("play_recorded", "&Record…", checkable=True)
    def _set_recorded(self, on: bool) -> None:
        """Record frames with completed depth as they play, until playing ends: a file *.mcap of ROS 2, or a folder."""
        from .live import MomentRecorder

        recorder, self.playback.recorder = self.playback.recorder, None
        if recorder is not None and (count := recorder.close()):
            self.notes.show_message(f"{counted(count, 'frame')} recorded: {recorder.path}")
        kinds = "ROS 2 recording (*.mcap);;Folder (*)"
        if path := ask_path(self.context.window, "Record", "recording.mcap", kinds) if on else "":
            try:
                self.playback.recorder = MomentRecorder(path)
            except IlfError as error:
                self.notes.report("Record", error)
        self.context.actions["play_recorded"].setChecked(self.playback.recorder is not None)

    @command("play_recording", "&Recording…", needs=Need.NOT_PLAYING)
    def _play_recording(self) -> None:
        """Play a recording at its rate, and complete it as it plays."""
        if path := choose_file(self.context.window, "Play live", _FOLDER_KEY, recording_files()):
            self.play_live(path)

    @command("play_folder", "&Folder…", needs=Need.NOT_PLAYING)
    def _play_folder(self) -> None:
        """Play the frames of a folder or data set, and complete them as they play."""
        if path := choose_folder(self.context.window, "Play live", _FOLDER_KEY):
            self.play_live(path)

    @command("play_camera", "RealSense &camera", needs=Need.NOT_PLAYING, why_off=_why_no_camera)
    def _play_camera(self) -> None:
        """Play the connected RealSense camera, and complete its frames as they come."""
        self.play_live()

    def play_live(self, path: str | None = None, rate: float | None = None) -> None:
        """Play a recording, a folder, or the connected RealSense camera (None), which need not be in the list, and
        complete it with the current parameters as it plays.

        Parameters
        ----------
        path : str or None
        rate : float, optional
            Frames a second; those of its timestamps if left out, or 10 without any.
        """
        self._on.setChecked(False)
        completed = self.context.actions["play_completed"]
        self._completed = completed.isChecked()
        completed.setChecked(True)
        self._live = path, rate
        self._on.setChecked(True)

    def _why_off(self) -> str:
        if self._opening:
            return "The frame shown is being opened."
        return "" if self.playing else sentence(Need.OTHERS & self.context.missing())

    @property
    def playing(self) -> bool:
        """Whether frames are played."""
        return self._on.isChecked()

    @command(
        "play_frames",
        "&Play",
        icon="ph.play-circle",
        keys="K",
        checkable=True,
        why_off=_why_off,
    )
    def _turn(self, on: bool) -> None:
        """Play the frames of the list from this one on; again, or a click in a view, opens the frame shown."""
        self._on.setIcon(theme.icon("ph.pause-circle" if on else "ph.play-circle"))
        if on:
            self._begin()
        else:
            self._pause()

    def _begin(self) -> None:
        """Close the current frame as on going to another one, and play."""
        workspace, playback = self.workspace, self.playback
        frames = self._from_list() if self._live is None else self._from_source(*self._live)
        parameters, count = workspace.parameters.current, len(self._entries)
        self._job = lambda: play(frames(), playback, parameters, count)
        self.shown, self._left = None, workspace.shown
        self._clock.clear()
        self.context.centre.show_images()
        self.views.keep_pictures(True)
        workspace.show(None)
        self._status.show_playing("Reading the first frame\N{HORIZONTAL ELLIPSIS}")
        self.context.actions.refresh()
        self._start()

    def _start(self) -> None:
        """Play what waits, once what was played before has ended."""
        if self._job is not None and not self.worker.busy:
            job, self._job = self._job, None
            self.worker.start(job, paused=True)

    def _from_list(self) -> Callable[[], Generator[Due, None, None]]:
        """Return what gives the frames of the list from the current one on; after the last, from the first."""
        self._entries, row = self._frames.shown()
        row = 0 if row == len(self._entries) - 1 else max(row, 0)
        self.playback.own_rate = rate_of([self.context.loader.times.get(entry.key) for entry in self._entries])
        store = self.context.recorder.store
        readers = [moment_reader(entry, store, self.written.get(entry.id)) for entry in self._entries]
        return lambda: frames_from(readers, row, self.playback)

    def _from_source(self, path: str | None, rate: float | None) -> Callable[[], Generator[Due, None, None]]:
        """Return what gives the frames of a recording, a folder or the camera."""
        from .live import live_frames

        self._entries = []

        def open_source() -> Generator[Due, None, None]:
            usual, frames = live_frames(path)
            self.playback.own_rate = rate or usual
            return frames

        return open_source

    def _pause(self) -> None:
        """Open the frame shown."""
        self._job = None
        self.worker.cancel()
        if self.playback.recorder is not None:  # else its file may just be asked for
            self.context.actions["play_recorded"].setChecked(False)
        self._status.show_playing("")
        if self._live is not None:
            self.context.actions["play_completed"].setChecked(self._completed)
        self._live = None
        if self.workspace.shown is not None:
            return
        self._opening, self._place = True, self.views.transform.place
        if self.shown is not None:
            self._open(self.shown)
        self.context.refresh.mark("played")
        self.context.actions.refresh()

    def _open(self, shown: PlayedFrame) -> None:
        """Open a frame that was played, if it is still there; that of a camera is first written into a folder."""
        if self._entries:
            if (entry := self._entries[shown.row]) in self.workspace.entries:
                self._frames.open(entry)
        elif shown.moment.frame.inputs is not None:
            self.context.feature(DocumentsFeature).open_source(FrameRef.of(shown.moment.frame.inputs))
        else:
            self._ask_folder(shown.moment.frame)

    def _ask_folder(self, frame: RGBDFrame) -> None:
        """Write a frame of a camera into a folder and open it, unless the user cancels."""

        def fail(error: Exception) -> None:
            self.notes.report("Not saved", error)
            self._ask_folder(frame)

        if path := ask_path(self.context.window, "Folder for the frame shown", "frame", "Folder (*)"):
            open_source = self.context.feature(DocumentsFeature).open_source
            self._saver.ask(lambda: write_frame(path, frame), lambda _: open_source(FrameRef(path)), fail)
        self.context.refresh.mark("played")

    def _follow(self) -> None:
        """End playing once a frame is open: the one that was shown, or another one that was chosen."""
        if self.workspace.shown is not None:
            self._place = self._place if self._opening else None
            self.shown, self._left, self._opening = None, None, False
            self._on.setChecked(False)
            self._frames.show_played(None)

    def _settle(self) -> None:
        """End playing if a frame was removed. Once a frame is open, show the place that was shown by playing; if the
        one shown could not be opened, show the former one."""
        workspace, place = self.workspace, self._place
        if self.playing and not all(entry in workspace.entries for entry in self._entries):
            self._on.setChecked(False)
        elif place is not None and workspace.shown is not None:
            self._place = None
            self.views.transform.look_at(*place)
        elif self._opening and workspace.shown is None and not (self.context.loader.busy or self._saver.busy):
            self.shown, self._opening = None, False
            self._frames.show_played(None)
            if self._left in workspace.open:
                workspace.show(self._left)
            else:
                self.views.keep_pictures(False)

    def _take(self, played: list[PlayedFrame]) -> None:
        """Show the frame that is due, while the next one is being read."""
        if not self.playing:
            return
        self.playback.flickers = self.views.shows("before")
        self.worker.order(Order.STEP)
        former, self.shown = self.shown, played[-1]
        shown, moment = self.shown, self.shown.moment
        if former is not None and shown.completing.scenes > max(former.completing.scenes, 1):
            self.views.ranges.reset_for_frame()
        self.views.show_played(moment.frame, moment.depth, moment.text, shown.before)
        self._frames.show_played(self._entries[shown.row] if self._entries else None)
        self._clock.append(time.monotonic())
        self._status.show_playing(self._text(shown))

    def _text(self, shown: PlayedFrame) -> str:
        wanted = "" if self.playback.rate is None else f" of {self.playback.rate:.1f}"
        parts = [f"{measured_rate(self._clock):.1f}{wanted} frames a second"]
        parts += [f"{shown.left_out} left out"] * bool(shown.left_out)
        parts += [f"{shown.unreadable} unreadable"] * bool(shown.unreadable)
        latency = shown.completing
        if latency.frames:
            parts.append(f"latency {1000 * latency.median:.0f} ms (95 %: {1000 * latency.worst:.0f} ms)")
        parts += [f"{counted(shown.recorded, 'frame')} recorded"] * bool(shown.recorded)
        place = f" ({shown.row + 1} of {len(self._entries)})" if self._entries else ""
        return f"{shown.moment.name}{place}: {', '.join(parts)}"

    def _fail(self, error: Exception) -> None:
        self.notes.report("Play", error)
        self._on.setChecked(False)

    def shutdown(self) -> None:
        """End the recording: its file is complete, and removed if nothing was recorded."""
        if self.playback.recorder is not None:
            self.playback.recorder.close()

    def set_speed(self, speed: float | None) -> None:
        """Play so many times as fast as the sequence's own rate; None for as fast as it goes."""
        self.playback.speed = speed
        self._clock.clear()
