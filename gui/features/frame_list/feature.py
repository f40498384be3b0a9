"""List of frames: display, navigation, and commands on its frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QEvent, QObject, QPoint, QUrl
from PySide6.QtGui import QDesktopServices, QGuiApplication
from PySide6.QtWidgets import QApplication, QMenu, QVBoxLayout, QWidget

from ilf.project.project import Stage

from ...base import theme
from ...base.commands import Command, command
from ...base.needs import Need
from ...state.parts import Part
from ...state.workspace import Entry
from ...widgets.basics import lay_out
from ...widgets.docks import PanelGroup
from ..context import Context
from ..edit_summary import EditSummaryFeature
from ..panel import Panel
from ..project.feature import ProjectFeature
from .limiter import OpenFrameLimiter
from .model import ENTRY
from .panel import FramesPanel

_HEIGHT_SHARE = 0.0375
_HEIGHTS = 30, 60
"""Height of the strip: share of the window's height, minimum and maximum [px]."""
_KEY = "frames/film_strip"
_STRIP = (
    "Show the frames under the images while there are several and their panel is closed; the bar has the colour of the "
    "state"
)


class FramesFeature(Panel):
    """The list of frames, in two shapes: rows in the dock, or a strip under the images while that is closed."""

    title = "Frames"
    icon = "ph.image"
    group = PanelGroup.WORK
    parts = Part.FRAME | Part.LABELS | Part.RESULTS
    deferred = Part.LIST | Part.CONTENT | Part.SOME_RESULTS
    awaits = Need.OTHERS
    more_commands = (
        Command("film_strip", "Film &strip", _STRIP, "ph.film-strip", checkable=True, on=True, remembered=_KEY),
    )

    _wanted: Entry | None = None
    """The frame that is being opened; *Next frame* continues from it."""
    _left: Entry | None = None
    """The frame that was shown then."""
    _played: Entry | None = None
    """The frame shown by playing, while none is open."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.open_frames = OpenFrameLimiter(context)
        context.workspace.on(Part.FRAME, self._forget_wanted)
        self.panel = panel = FramesPanel(context.recorder.store.thumbnail)
        panel.model.noted.connect(context.workspace.set_note)
        panel.view.opened.connect(self.open)
        panel.view.note_requested.connect(self._note)
        panel.view.removal_requested.connect(self.remove)
        panel.view.customContextMenuRequested.connect(self._show_menu)
        self.dock, self.bar = QWidget(), QWidget()
        self._in_place, self._in_bar = lay_out(QVBoxLayout(self.dock)), lay_out(QVBoxLayout(self.bar), panel)
        self.bar.hide()
        context.centre.add_before(context.feature(EditSummaryFeature).line, self.bar)
        also = (context.actions["film_strip"].toggled,)
        context.refresh.add("film strip", self._find_place, Part.LIST, also=also)
        self.dock.installEventFilter(self)
        context.panels.turned.connect(self._find_place)  # also as it closes behind another tab
        _ = self.widget  # in one of its shapes

    def make(self) -> QWidget:
        return self.panel

    # its two places

    @property
    def in_dock(self) -> QWidget:
        """What the dock contains. While that is closed, the list is in a bar under the images."""
        return self.dock

    def _find_place(self) -> None:
        """Move the list to where it belongs, and show or hide the strip."""
        context, docked = self.context, self.title in self.context.panels.open  # also behind another tab
        if self.panel.parentWidget() is not (self.dock if docked else self.bar):
            focused = QApplication.focusWidget()
            had_focus = focused is not None and self.panel.isAncestorOf(focused)
            (self._in_place if docked else self._in_bar).addWidget(self.panel)
            self.panel.show()  # at once: it may be given the focus
            if had_focus and not docked:
                context.views.active.view.setFocus()
        least, most = _HEIGHTS
        self.panel.set_bar(0 if docked else min(max(round(_HEIGHT_SHARE * context.window.height()), least), most))
        shown = not docked and len(context.workspace.entries) > 1 and context.actions.is_on("film_strip")
        self.bar.setVisible(shown)
        (context.centre.installEventFilter if shown else context.centre.removeEventFilter)(self)  # its height matters
        self.redraw()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the dock as it opens, and the height of the window."""
        opens = watched is self.dock and event.type() == QEvent.Type.Show
        if opens or (watched is self.context.centre and event.type() == QEvent.Type.Resize):
            self._find_place()
        return super().eventFilter(watched, event)

    @command("next_frame", "Next frame", icon="ph.caret-down", keys="Ctrl+PgDown", needs=Need.OTHERS)
    def _next(self) -> None:
        """Show the next frame in the order of the list."""
        self.turn(1)

    @command("previous_frame", "Previous frame", icon="ph.caret-up", keys="Ctrl+PgUp", needs=Need.OTHERS)
    def _previous(self) -> None:
        """Show the previous frame in the order of the list."""
        self.turn(-1)

    # display

    def refresh(self, parts: Part) -> None:
        """Show the frames, their states and which is the current one."""
        self._show_list()

    def _show_list(self) -> None:
        self.panel.show_entries(list(self.workspace.entries), self._present())

    def show_played(self, entry: Entry | None) -> None:
        """Mark the frame shown by playing as the current one; None once an open one is shown again."""
        self._played = entry
        self._show_list()

    def _present(self) -> Entry | None:
        return self._played or self.workspace.current_entry

    def _forget_wanted(self) -> None:
        if self._present() is not self._left:  # else this tells of the turn before
            self._wanted = None

    # navigation

    def open(self, entry: Entry) -> None:
        """Show a frame of the list."""
        if entry is not self._present():
            self._wanted, self._left = entry, self._present()
        self.context.loader.open_entry(entry)

    def turn(self, steps: int) -> None:
        """Show the next or previous frame in the order of the list; the first follows the last."""
        shown, row = self.shown()
        if len(shown) > 1:
            self._go_to(shown[(row + steps) % len(shown)] if row >= 0 else shown[0 if steps > 0 else -1])

    @command(
        "next_untouched",
        "Next &untouched frame",
        icon="ph.caret-double-down",
        keys="Ctrl+Shift+PgDown",
        needs=Need.OTHERS,
    )
    def next_untouched(self) -> None:
        """Show the next frame that has not been worked on."""
        none_left = "All frames shown in the list have been worked on."
        self._go_to_next(lambda one: one.document is None and one.summary.stage is Stage.UNTOUCHED, none_left)

    @command("mark_done", "Mark as &done", icon="ph.check-circle", keys="Ctrl+Return", needs=Need.FRAME)
    def mark_done(self) -> None:
        """Mark the current frame as done and show the next one that is not; if it is done, remove the mark."""
        entry = self._present()
        if entry is None:
            return
        done = not entry.summary.done
        self.workspace.set_done(entry, done)
        if not done:
            self.notes.show_message(f"{entry.name} is no longer marked as done.")
        elif len(self.workspace.entries) == 1:
            self.notes.show_message(f"{entry.name} is marked as done.")
        else:
            self._go_to_next(lambda other: not other.summary.done, "All frames shown in the list are done.")

    def _go_to_next(self, wanted: Callable[[Entry], bool], none_left: str) -> None:
        """Show the next wanted frame, the first after the last; a message if there is none."""
        shown, row = self.shown()
        entry = next((entry for entry in (*shown[row + 1 :], *shown[: row + 1]) if wanted(entry)), None)
        if entry is None:
            self.notes.show_message(none_left)
        else:
            self._go_to(entry)

    def shown(self) -> tuple[list[Entry], int]:
        """Return the shown entries, and the row of the current frame or the one being opened; -1 if not shown."""
        self._show_list()
        return self.panel.model.entries, self.panel.model.row_of(self._wanted or self._present())

    def _go_to(self, entry: Entry) -> None:
        self.panel.view.choose(self.panel.model.index_of(entry))
        self.open(entry)

    # commands on frames

    @command("note_frame", "Note on the frame", icon="ph.note-pencil", needs=Need.LISTED)
    def write_note(self) -> None:
        """Write a note on the current frame."""
        self._show_list()
        index = self.panel.view.currentIndex()
        entry = index.data(ENTRY) if index.isValid() else self.panel.model.present
        if entry is not None:
            self._note(entry)

    def _note(self, entry: Entry) -> None:
        """Edit the note on a frame in the open panel."""
        self.context.panels.reveal("Frames")
        self.panel.view.write_note(self.panel.model.index_of(entry))

    def remove(self, entries: Sequence[Entry]) -> None:
        """Remove frames from the list, and close those that are open, after asking once about the work on them."""
        row = self.panel.model.row_of(entries[0])

        def remove() -> None:
            self.workspace.remove_entries(entries)
            self._show_list()
            shown = self.panel.model.entries
            if shown and self.workspace.shown is None:
                self._go_to(shown[min(max(row, 0), len(shown) - 1)])

        self.context.feature(ProjectFeature).ask_remove(entries, remove)

    def _show_menu(self, at: QPoint) -> None:
        chosen = self.panel.view.chosen()
        if not chosen:
            return
        first, several, menu = chosen[0], len(chosen) > 1, QMenu(self.panel)
        paths = "\n".join(entry.key for entry in chosen)

        def add(icon: str, text: str, do: Callable[[], object]) -> None:
            menu.addAction(theme.icon(icon), text, lambda: do())

        if not several:
            add("ph.image", "&Open", lambda: self.open(first))
            add("ph.note-pencil", "&Note…", lambda: self._note(first))
            add("ph.folder-open", "Show in &file manager", lambda: _show_files(first))
        add("ph.copy", "&Copy paths" if several else "&Copy path", lambda: QGuiApplication.clipboard().setText(paths))
        removal = f"&Remove {len(chosen)} frames from the list" if several else "&Remove from the list"
        add("ph.x", removal, lambda: self.remove(chosen))
        menu.aboutToHide.connect(menu.deleteLater)
        menu.popup(self.panel.view.viewport().mapToGlobal(at))


def _show_files(entry: Entry) -> None:
    source = entry.source
    place = Path(entry.key if source is None or source.frame is None else source.rgb)
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(place if place.is_dir() else place.parent)))
