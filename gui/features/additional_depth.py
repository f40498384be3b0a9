"""The panel *Additional depth*: guide, depth of neighbours and depth by hand of the current frame."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QSettings, Qt, QTimer
from PySide6.QtWidgets import QFormLayout, QPushButton, QSpinBox, QVBoxLayout, QWidget

from ilf._runtime.formatting import counted, grouped, millimetres
from ilf._runtime.long_work import mapped_steps
from ilf.completion.completion import guide_text
from ilf.data.frame import RGBDFrame
from ilf.evaluation.hold_out import compared_steps, hold_out_steps
from ilf.io.frame_additions import load_guide
from ilf.run.run import Run
from ilf.sources.frame_ref import is_result_folder
from ilf.sources.neighbours import around, neighbour_steps

from ..base.commands import command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..state.workspace import Entry
from ..widgets.basics import TEXT, Message, add_layout, command_button, form, group, lay_out, open_once, row, scrolled
from ..widgets.docks import PanelGroup
from ..widgets.file_choice import choose_file
from ..widgets.notices import error_text
from ..work.jobs import spare_cores
from .context import Context
from .documents.frame_files import guide_files
from .guide_networks import GuideNetworksDialog
from .panel import Panel
from .parameter_effects import Depth, effect_of

GUIDE, NEIGHBOURS, BY_HAND = "Guide", "Depth of neighbours", "Depth by hand"
_SHORT = {
    "load_guide": "Load…",
    "guide_by_network": "By network…",
    "remove_guide": "Remove",
    "use_neighbours": "Use",
    "remove_neighbours": "Remove",
    "remove_by_hand": "Remove",
}
"""Texts of the commands in the panel."""
_FOLDER_KEY = "guide/folder"
_COUNT_KEY, _STEP_KEY = "neighbours/count", "neighbours/step"
_COUNT, _MAX_COUNT, _STEP, _MAX_STEP = 2, 10, 1, 99

# What is computed in a worker.


def _with_guide(frame: RGBDFrame, path: str) -> tuple[RGBDFrame, str]:
    """Read a guide from a file and fit it to the known depth; return the frame with it, and how it is used."""
    frame = frame.with_guide(load_guide(path, frame.shape, frame.rgb))
    return frame, f"It is {guide_text(frame)}."


def _comparison(without: Run, used: Run, depth: Depth | None) -> Generator[float, None, str]:
    """Complete a frame without one kind of depth and with it, unless that `depth` is known, and both once more with
    hidden known depth; return sentences on the differences."""
    bare = yield from _completed(without, 0.0)
    if depth is None:
        depth = yield from _completed(used, 0.25)
    hidden = compared_steps([hold_out_steps(run, threads=spare_cores()) for run in (without, used)])
    results = yield from mapped_steps(hidden, lambda step: 0.5 + 0.5 * step.share)
    alone, together = (result.whole for result in results)
    guide = f"It is {guide_text(used.frame)}. " if without.frame.guide is not used.frame.guide else ""
    was, now = (f"{millimetres(one.mae)} mm (RMSE {millimetres(one.rmse)})" for one in (alone, together))
    return (
        f"{guide}{_difference(bare, depth)} Mean error of hidden depth, at {together.pixels:,} pixels: {was} without "
        f"it, {now} with it."
    )


def _completed(run: Run, first: float) -> Generator[float, None, Depth]:
    with run.steps(spare_cores()) as steps:
        for _ in steps:
            yield first + 0.25 * len(steps.results) / max(len(steps.blocks), 1)
    return steps.completion().depth


def _difference(bare: Depth, used: Depth) -> str:
    """Describe how much completed depth differs, and where only one is there."""
    only = int(np.count_nonzero(np.isnan(bare) & ~np.isnan(used)))
    filled = f"; {grouped(only)} px of them are filled only with it" if only else ""
    return f"With it, {effect_of([(bare, used)]).text}{filled}."


# The panel.


class _Section(NamedTuple):
    """The part of the panel for one kind of depth."""

    content: str
    """What a view shows of it."""
    message: Message
    effect: Message
    show: QPushButton
    compare: QPushButton


class AdditionalDepthPanel(Panel):
    """Which additional depth the frame has, from where, how much it covers, and what it changes."""

    title = "Additional depth"
    icon = "ph.stack"
    group = PanelGroup.SETTINGS
    parts = Part.FRAME | Part.LIST | Part.GUIDE | Part.NEIGHBOURS | Part.BY_HAND | Part.LABELS | Part.RESULTS
    what = "work on additional depth"

    def __init__(self, context: Context) -> None:
        self._sections: dict[str, _Section] = {}
        super().__init__(context)

    def make(self) -> QWidget:
        for name, short in _SHORT.items():
            self.context.actions[name].setIconText(short)
        self._count, self._step = (
            QSpinBox(minimum=1, maximum=most, value=int(str(QSettings().value(key, usual, int))))
            for key, usual, most in ((_COUNT_KEY, _COUNT, _MAX_COUNT), (_STEP_KEY, _STEP, _MAX_STEP))
        )
        for number in (self._count, self._step):
            number.setKeyboardTracking(False)  # Escape drops what is being typed
        self._count.setToolTip("Number of frames before this one, and as many after it, whose depth is used")
        self._step.setToolTip(
            "Use every so many frames: a camera that moves slowly shows more from frames farther away"
        )
        numbers = form(("Frames &before and after", self._count), ("Every so &many frames", self._step))
        inner = QWidget()
        column = QVBoxLayout(inner)
        column.addWidget(self._section(GUIDE, "guide", ("load_guide", "guide_by_network", "remove_guide")))
        column.addWidget(self._section(NEIGHBOURS, "from_neighbours", ("use_neighbours", "remove_neighbours"), numbers))
        column.addWidget(self._section(BY_HAND, "result", ("tool_depth_by_hand", "remove_by_hand")))
        column.addStretch(1)
        self._area = scrolled(inner)
        widget = QWidget()  # the progress is in sight wherever the panel is scrolled to
        lay_out(QVBoxLayout(widget), self._area, self.work, margins=(0, 0, 4, 4), stretched=self._area)
        return widget

    def _section(self, kind: str, content: str, commands: Sequence[str], numbers: QFormLayout | None = None) -> QWidget:
        box, column = group(kind)
        section = _Section(content, Message(), Message(0), QPushButton("Show"), QPushButton("What it changes"))
        section.show.setCheckable(True)
        section.show.setToolTip(f"Show it in the view Depth in: {kind}")
        section.show.clicked.connect(lambda on: self.views.set_content("depth-in", content if on else "depth-in"))
        section.compare.setToolTip("Complete the frame without it and with it, and compare; known depth is hidden, too")
        section.compare.clicked.connect(lambda: self.compare(kind))
        column.addWidget(section.message)
        if numbers is not None:
            add_layout(column, numbers)
        buttons = [command_button(self.context.actions[name], TEXT) for name in commands]
        for button in buttons:
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        add_layout(column, row(*buttons))
        add_layout(column, row(section.show, section.compare))
        column.addWidget(section.effect)
        self._sections[kind] = section
        return box

    def refresh(self, parts: Part) -> None:
        if parts & (Part.FRAME | Part.GUIDE | Part.NEIGHBOURS | Part.BY_HAND | Part.LABELS):
            for section in self._sections.values():
                section.effect.show_message("")
            asked = self.requests.question
            if asked is not None and asked.kind == "comparison":  # with what was there before
                self.requests.cancel()
        texts = self._texts() if self.workspace.shown is not None else {}
        shown = self.views.contents()["depth-in"]
        has_blocks = bool(texts) and bool(self.workspace.current.counts())
        for kind, section in self._sections.items():
            there = bool(texts.get(kind))
            section.message.show_message(texts.get(kind) or "None in this frame.", "text" if there else "muted")
            section.show.setEnabled(there)
            section.show.setChecked(there and shown == section.content)
            section.compare.setEnabled(there and has_blocks)

    def _texts(self) -> dict[str, str]:
        """Return where each kind of depth is from, and how much it covers; "" for none."""
        frame, by_hand = self._frame, self.workspace.current.blocks.by_hand
        missing = max(int(np.count_nonzero(frame.missing)), 1)
        texts = dict.fromkeys((GUIDE, NEIGHBOURS, BY_HAND), "")
        if frame.guide is not None:
            covered = np.count_nonzero(np.isfinite(frame.guide.values) & frame.missing) / missing
            source = "another program" if frame.guide.path is None else Path(frame.guide.path).name
            texts[GUIDE] = f"From {source}; it covers {covered:.0%} of the missing pixels."
        if frame.neighbours is not None and frame.from_neighbours is not None:
            names = ", ".join(one.name for one in frame.neighbours.neighbours)
            count = int(np.count_nonzero(frame.from_neighbours))
            texts[NEIGHBOURS] = (
                f"From {names}, at {counted(count, 'pixel')}: {count / missing:.0%} of the missing ones."
            )
        if by_hand is not None:
            count = int(np.count_nonzero(by_hand.pixels))
            texts[BY_HAND] = f"Stated at {counted(count, 'pixel')}." if count else ""
        return texts

    # commands

    @command("load_guide", "Load &guide…", icon="ph.compass", needs=Need.FRAME)
    def ask_guide(self) -> None:
        """Use depth or inverse depth from another source, or a network that predicts it, where it helps."""
        if path := choose_file(self.context.window, "Load guide", _FOLDER_KEY, guide_files(), self._frame):
            self._load_guide(path)

    @command("guide_by_network", "Guide by net&work…", icon="ph.brain")
    def choose_network(self) -> None:
        """Fetch a network that predicts depth from colour, or choose one that is here, and use it as guide."""
        dialog = GuideNetworksDialog(self.context.window, self.workspace.shown is not None, self.requests, self.notes)
        open_once(dialog, lambda: self._load_guide(dialog.chosen()))

    def _why_no_neighbours(self) -> str:
        entry, place = self._entry(), self._entry().place
        others = (one for one in self.workspace.entries if one is not entry)
        if place is None or all(one.place != place for one in others):
            return "The list has no other frame of this sequence: open its folder or recording."
        if entry.source is not None and is_result_folder(entry.source):
            return "Depth of the frames beside this one was completed, not measured: open the folder of the frames."
        if self._frame.intrinsics is None:
            return "The camera's intrinsics of this frame are not known: open it with intrinsics."
        return ""

    @command("use_neighbours", "Use neig&hbours", icon="ph.stack", needs=Need.FRAME, why_off=_why_no_neighbours)
    def use_neighbours(self) -> None:
        """Use depth that the frames before and after have measured where this one has none."""
        self.reveal()
        QSettings().setValue(_COUNT_KEY, self._count.value())
        QSettings().setValue(_STEP_KEY, self._step.value())
        entry, step = self._entry(), self._step.value()
        same = [one for one in self.workspace.entries if one.place == entry.place]
        sides = around([one.source for one in same if one.source is not None], same.index(entry), len(same))
        before, after = (side[: self._count.value() * step] for side in sides)
        document, frame = self.workspace.current, self._frame

        def take(found: RGBDFrame) -> None:
            if self._is_shown(document):
                if found.from_neighbours is not None:
                    document.set_neighbours(found.neighbours, "Use neighbours")
                self.notes.show_message(f"{document.name}: {found.notes[-1]}")

        fail = partial(self.notes.report, "Use neighbours")
        self.requests.ask(lambda: neighbour_steps(frame, before, after, step=step), take, fail, kind="neighbours")
        self.work.begin()

    def compare(self, kind: str) -> None:
        """Compute what one kind of depth changes."""
        document = self.workspace.current
        used = document.run(document.state.common)
        changed: dict[str, Callable[[], Run]] = {
            GUIDE: lambda: replace(used, frame=used.frame.with_guide(None)),
            NEIGHBOURS: lambda: replace(used, frame=used.frame.with_neighbours(None)),
            BY_HAND: lambda: replace(used, blocks=replace(used.blocks, by_hand=None)),
        }
        completion = None if document.changed_blocks() or document.extrapolated else document.completion()
        depth = None if completion is None else completion.depth
        without, effect = changed[kind](), self._sections[kind].effect

        def take(text: str) -> None:
            if self._is_shown(document):
                effect.show_message(text, "text")
                QTimer.singleShot(0, lambda: self._area.ensureWidgetVisible(effect))  # once it has its height

        def fail(error: Exception) -> None:
            effect.show_message(error_text(error), "error")

        self.requests.ask(lambda: _comparison(without, used, depth), take, fail, kind="comparison")

    @command("remove_guide", "Remove guide", icon="ph.x-circle", needs=Need.GUIDE)
    def remove_guide(self) -> None:
        """Complete the frame without a guide."""
        self.workspace.current.set_guide(None, "Remove guide")

    @command("remove_neighbours", "Remove depth of neighbours", icon="ph.x-circle", needs=Need.NEIGHBOURS)
    def remove_neighbours(self) -> None:
        """Complete the frame with its own depth alone."""
        self.workspace.current.set_neighbours(None, "Remove depth of neighbours")

    # what a worker does

    def _load_guide(self, path: str) -> None:
        """Use a file or a network of this name as guide."""
        self.reveal()
        document, frame = self.workspace.current, self._frame

        def take(found: tuple[RGBDFrame, str]) -> None:
            if self._is_shown(document):
                document.set_guide(found[0].guide, "Load guide")
                self.context.refresh.now()  # which drops what is said of the guide before
                self._sections[GUIDE].effect.show_message(found[1], "text")

        self.requests.ask(
            lambda: _with_guide(frame, path), take, partial(self.notes.report, "Load guide"), kind="guide"
        )

    def _is_shown(self, document: Document) -> bool:
        """Whether a frame still is the current one; a message says if not."""
        shown = document is self.workspace.shown
        if not shown:
            self.notes.show_message(
                f"{document.name}: nothing was added, since another frame is shown now. Show it, and try again."
            )
        return shown

    @property
    def _frame(self) -> RGBDFrame:
        return self.workspace.current.frame

    def _entry(self) -> Entry:
        entry = self.workspace.current_entry
        assert entry is not None  # every open frame is in the list
        return entry
