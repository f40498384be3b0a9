"""Playing the frames of the list in the views: speed, loop, completion as they play; pausing opens the frame shown."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from ilf.data.parameters import Parameters
from ilf.errors import IlfError
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import Listing
from ilf.stream.pacing import USUAL_RATE, latest_of, measured_rate, rate_of
from ilf.stream.stream import Stream

from ...base.commands import Actions, Command, command
from ...base.needs import Need
from ...state.document import Document
from ...state.entries import Entry
from ...state.parts import Part
from ...views.view_data import Before, Depth
from ...widgets.basics import command_button, lay_out
from ...work.jobs import Order, Worker
from ..context import Context, Feature
from ..frame_list.feature import FramesFeature
from ..status import StatusFeature
from .flicker import Moment, moment_reader

# Playing, in the worker's thread.


@dataclass
class Pace:
    """How frames are played: set in the window's thread, read in the worker's.

    Attributes
    ----------
    rate : float or None
        Frames a second; None for as many as can be read and shown, without leaving any out.
    loop : bool
        Whether the first frame follows the last.
    completes : bool
        Whether frames without a result are completed.
    flickers : bool
        Whether the change against the frame before is wanted.
    """

    rate: float | None = USUAL_RATE
    loop: bool = False
    completes: bool = False
    flickers: bool = False


@dataclass(frozen=True, eq=False)
class PlayedFrame:
    """A frame that is due.

    Attributes
    ----------
    row : int
    moment : Moment
    before : Before
        The frame that was shown before.
    left_out, unreadable : int
        Number of frames so far that were left out because they were late, and because they cannot be read.
    """

    row: int
    moment: Moment
    before: Before
    left_out: int
    unreadable: int


def play(
    readers: Sequence[Callable[[], Moment]], row: int, pace: Pace, parameters: Parameters
) -> Generator[PlayedFrame, None, None]:
    """Yield the frames of a list from a row on, each read when it is due; of those that are late, only the latest.

    Parameters
    ----------
    readers : sequence of callable
        Of the frames; each raises IlfError if its frame cannot be read.
    row : int
        The first one to play.
    pace : Pace
    parameters : Parameters
        Of the filter, to complete frames.
    """
    before, shown, left_out, unreadable, failed = None, row, 0, 0, 0
    rows = latest_of(_rows(len(readers), row, pace), lambda: pace.rate)
    with closing(rows) as due, Stream(parameters, rate=pace.rate or USUAL_RATE) as stream:
        for row, late in due:
            left_out += late
            try:
                moment = readers[row]()
                if pace.completes and moment.depth is None:
                    depth = stream.complete(moment.frame).depth
                    moment = replace(moment, depth=depth, text="completed as it plays")
            except IlfError:
                unreadable, failed = unreadable + 1, failed + 1
                if failed == len(readers):
                    return
            else:
                before = before if row > shown else None  # the first one again
                change = moment.since(before, row - shown) if pace.flickers else Before()
                yield PlayedFrame(row, moment, change, left_out, unreadable)
                before, shown, failed = moment, row, 0


def _rows(count: int, row: int, pace: Pace) -> Iterator[int]:
    """The rows to be played, one after the other."""
    yield from range(row, count)
    while pace.loop:
        yield from range(count)


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

_RECENT = 20
"""Number of frames over which the rate is measured."""


class PlayFeature(Feature):
    """Plays the frames of the list. None of them is open meanwhile, so that no edit can get lost or into another frame;
    pausing opens the frame shown."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._frames = context.feature(FramesFeature)
        self._status = context.feature(StatusFeature)
        context.actions.add(self._speeds())
        self._on = context.actions["play_frames"]
        context.actions["speed_normal"].setChecked(True)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take)
        self.worker.finished.connect(lambda _: self._end())
        self.worker.failed.connect(self._fail)
        self.pace = Pace()
        self.written: dict[str, Callable[[], Depth | None]] = {}
        """Id of a frame -> what reads its depth in the latest export of this window that completed it from its
        files."""
        self.shown: PlayedFrame | None = None
        """The frame shown by playing; None once an open one is shown again."""
        self._speed: float | None = 1.0
        self._times: dict[str, float] = {}
        """Key of a frame -> its time [s], where it is known."""
        self._entries: list[Entry] = []
        self._left: Document | None = None
        """The frame that was open before."""
        self._opening = False
        """Whether the frame shown is being opened."""
        self._place: tuple[float, float, float] | None = None
        """The place that the views show when playing ends."""
        self._clock = deque[float](maxlen=_RECENT)
        context.loader.listed.connect(self._note_times)
        workspace = context.workspace
        context.views.pressed.connect(lambda: self._on.setChecked(False))
        context.refresh.add("opened frame", self._follow, Part.FRAME)
        context.refresh.add("played", self._settle, Part.FRAME | Part.LIST | Part.LOADING)
        self.bar = _PlayBar(context.actions)
        context.centre.add_before(self._frames.bar, self.bar)
        entries = workspace.entries
        context.refresh.add("play bar", lambda: self.bar.setVisible(len(entries) > 1), Part.LIST)

    def _speeds(self) -> Iterator[Command]:
        """Return the commands that set a speed."""
        for name, (text, speed) in _SPEEDS.items():
            hint = f"Play at {text} of the sequence's own rate"
            if speed is None:
                hint = "Play every frame, as many a second as can be read and shown"
            yield Command(name, text, hint, group="speed", handler=partial(self._set_speed, speed))

    @command("play_loop", "&Loop", checkable=True)
    def _set_loop(self, on: bool) -> None:
        """Go on with the first frame after the last one."""
        self.pace.loop = on

    @command("play_completed", "&Complete while playing", checkable=True)
    def _set_completes(self, on: bool) -> None:
        """Complete frames without a result as they play, as a stream does; nothing is stored."""
        self.pace.completes = on

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
        needs=Need.OTHERS,
        why_off=lambda self: "The frame shown is being opened." if self._opening else "",
    )
    def _turn(self, on: bool) -> None:
        """Play the frames of the list from this one on; again, or a click in a view, opens the frame shown."""
        icon = "ph.pause-circle" if on else "ph.play-circle"
        self.context.actions.adopt("play_frames", self._on, icon)
        if on:
            self._begin()
        else:
            self._pause()

    def _begin(self) -> None:
        """Close the current frame as on going to another one, and play from it on; after the last, from the first."""
        workspace = self.context.workspace
        self._entries, row = self._frames.shown()
        if row == len(self._entries) - 1:
            row = 0
        self.shown, self._left = None, workspace.current if workspace.has_current else None
        self._set_speed(self._speed)
        self.context.centre.show_images()
        self.context.views.keep_pictures(True)
        workspace.show(None)
        self.context.actions.refresh()
        store, parameters = self.context.recorder.store, workspace.parameters.current
        readers = [moment_reader(entry, store, self.written.get(entry.id)) for entry in self._entries]

        def start() -> None:
            if self.playing:
                self.worker.start(lambda: play(readers, max(row, 0), self.pace, parameters), paused=True)

        if self.worker.busy:  # the former one still ends
            self.worker.cancelled.connect(start, Qt.ConnectionType.SingleShotConnection)
        else:
            start()

    def _pause(self) -> None:
        """Open the frame shown."""
        self.worker.cancel()
        self._status.show_playing("")
        if self.context.workspace.has_current:
            return
        self._opening, self._place = True, self.context.views.place
        if self.shown is not None and (entry := self._entries[self.shown.row]) in self.context.workspace.entries:
            self._frames.open(entry)
        self.context.refresh.mark("played")
        self.context.actions.refresh()

    def _follow(self) -> None:
        """End playing once a frame is open: the one that was shown, or another one that was chosen."""
        workspace = self.context.workspace
        if workspace.has_current:
            same = self.shown is not None and self._entries[self.shown.row].id == workspace.current.id
            self._place = self._place if same else None
            self.shown, self._left, self._opening = None, None, False
            self._on.setChecked(False)
            self._frames.show_played(None)

    def _settle(self) -> None:
        """End playing if a frame was removed. Once a frame is open, show the place that was shown by playing; if the
        one shown could not be opened, show the former one."""
        workspace, place = self.context.workspace, self._place
        if self.playing and not all(entry in workspace.entries for entry in self._entries):
            self._on.setChecked(False)
        elif place is not None and workspace.has_current:
            self._place = None
            self.context.views.set_place(*place)
        elif self._opening and not workspace.has_current and not self.context.loader.busy:
            self.shown, self._opening = None, False
            self._frames.show_played(None)
            if self._left in workspace.open:
                workspace.show(self._left)
            else:
                self.context.views.keep_pictures(False)

    def _take(self, played: list[PlayedFrame]) -> None:
        """Show the frame that is due, while the next one is being read."""
        if not self.playing:
            return
        self.pace.flickers = self.context.views.shows("before")
        self.worker.order(Order.STEP)
        self.shown = shown = played[-1]
        moment = shown.moment
        self.context.views.show_played(moment.frame, moment.depth, moment.text, shown.before)
        self._frames.show_played(self._entries[shown.row])
        self._clock.append(time.monotonic())
        self._status.show_playing(self._text(shown))

    def _text(self, shown: PlayedFrame) -> str:
        wanted = "" if self.pace.rate is None else f" of {self.pace.rate:.1f}"
        parts = [f"{measured_rate(self._clock):.1f}{wanted} frames a second"]
        parts += [f"{shown.left_out} left out"] * bool(shown.left_out)
        parts += [f"{shown.unreadable} unreadable"] * bool(shown.unreadable)
        return f"{shown.moment.name} ({shown.row + 1} of {len(self._entries)}): {', '.join(parts)}"

    def _end(self) -> None:
        """Open the last frame."""
        if self.shown is None:
            self.context.notes.show_message("None of the frames can be read.")
        self._on.setChecked(False)

    def _fail(self, error: Exception) -> None:
        self._on.setChecked(False)
        self.context.notes.report("Play", error)

    def _set_speed(self, speed: float | None) -> None:
        self._speed = speed
        self.pace.rate = (
            None if speed is None else speed * rate_of([self._times.get(entry.key) for entry in self._entries])
        )
        self._clock.clear()

    def _note_times(self, _: FrameRef, listing: Listing) -> None:
        keys = (source.key for source in listing.sources)
        self._times |= dict(zip(keys, listing.times, strict=False))


class _PlayBar(QWidget):
    """Buttons beside the film strip: play, and a menu of the speeds with loop and completion."""

    def __init__(self, actions: Actions) -> None:
        super().__init__()
        self._speed = QToolButton(autoRaise=True)
        self._speed.setMenu(actions.menu("", self, f"{' '.join(_SPEEDS)} | play_loop play_completed"))
        self._speed.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._speed.setAccessibleName("Speed of playing")
        self._speed.setToolTip("Speed, loop, and completion while playing")
        play = command_button(actions["play_frames"])
        lay_out(QHBoxLayout(self), play, self._speed, margins=(4, 0, 4, 0), spacing=0)
        for name, (text, speed) in _SPEEDS.items():
            short = "max" if speed is None else text
            actions[name].toggled.connect(lambda on, short=short: self._speed.setText(short) if on else None)
        self._speed.setText(_SPEEDS["speed_normal"][0])
        self.hide()
