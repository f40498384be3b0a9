"""List of frames: display, navigation, and commands on its frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QPoint, QSettings, QTimer, QUrl
from PySide6.QtGui import QAction, QDesktopServices, QGuiApplication
from PySide6.QtWidgets import QMenu

from ilf._runtime.formatting import counted
from ilf.project.project import Stage
from ilf.project.thumbnail import thumbnail_part
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import Listing

from ...base import theme
from ...base.commands import Command
from ...base.needs import Need
from ...project.store import WorkStore
from ...state.document import Document
from ...state.entries import Entry
from ...state.workspace import Workspace
from ...widgets.file_choice import choose_file, choose_folder
from ..context import Context, Feature
from ..documents.feature import DocumentsFeature
from ..documents.frame_files import recording_files
from .model import counts
from .panel import FramesPanel
from .place import FramesPlace

# How many frames stay open: the least recently shown ones are closed once their state is stored.

MAX_OPEN_FRAMES = 8
_KEY = "frames/most_open"

Then = Callable[[Exception | None], None]


class OpenFrameLimiter(QObject):
    """Closes frames to limit the memory for long lists. They are reopened in the same state, without undo history.

    A frame is closed only if its current state is stored, or if nothing has been done to it; never while it is shown
    or running.

    Parameters
    ----------
    workspace : Workspace
    is_busy : callable
        Returns whether work on a session is in progress.
    is_left : callable
        Returns whether another frame was shown before a session had blocks, so that there is nothing to store.
    is_stored : callable
        Returns whether a state of the frame with an id is stored.
    flush : callable
        Stores all changes, then calls its argument: with None on success, or with the exception.
    """

    def __init__(
        self,
        workspace: Workspace,
        is_busy: Callable[[Document], bool],
        is_left: Callable[[Document], bool],
        is_stored: Callable[[str], bool],
        flush: Callable[[Then], None],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.max_open = max(int(str(QSettings().value(_KEY, MAX_OPEN_FRAMES, int))), 0) or MAX_OPEN_FRAMES
        self._workspace = workspace
        self._is_busy = is_busy
        self._is_left = is_left
        self._is_stored = is_stored
        self._settle = flush
        self._recently_shown: list[Document] = []
        """In the order in which they were shown; the current one is the last."""
        workspace.frames.session_changed.connect(self._look)
        workspace.touched.connect(self._close_surplus_after)
        workspace.frames.sessions_changed.connect(self._forget_closed)

    def _forget_closed(self) -> None:
        self._recently_shown = [document for document in self._recently_shown if document in self._workspace.open]

    def _look(self) -> None:
        workspace = self._workspace
        if workspace.has_current:
            present = workspace.current
            self._recently_shown = [*(one for one in self._recently_shown if one is not present), present]
            self.close_surplus()

    def _close_surplus_after(self, document: Document) -> None:
        """Tidy after work on a frame that is not shown, such as propagation through a list."""
        if document not in self._recently_shown and len(self._workspace.open) > self.max_open:
            self.close_surplus()

    def close_surplus(self) -> None:
        """Close surplus frames as far as possible."""
        for document in self._surplus():
            if self._is_left(document) and not document.unsaved and not document.counts():
                self._workspace.unload(document, stored=False)
        going = [(document, document.stamp) for document in self._surplus()]
        if going:
            self._settle(lambda error: self._put_away(going) if error is None else None)

    def _surplus(self) -> list[Document]:
        """Return the frames beyond the maximum number, the least recently shown first."""
        documents = self._workspace.open
        never = [document for document in documents if document not in self._recently_shown]
        idle = [
            document
            for document in (*never, *self._recently_shown)
            if document in documents and not self._workspace.is_shown(document) and not self._is_busy(document)
        ]
        return idle[: max(len(documents) - self.max_open, 0)]

    def _put_away(self, going: Sequence[tuple[Document, tuple[int, ...]]]) -> None:
        """Close the stored frames that have not changed since."""
        still = self._surplus()
        for document, stamp in going:
            if document in still and document.stamp == stamp and self._is_stored(document.id):
                self._workspace.unload(document)


_FOLDER_KEY = "open/frames"
_SOON_MS = 120
"""Delay of updates of the whole list [ms]."""


class FramesFeature(Feature):
    """Shows the frames in their panel, and applies the user's choices to the workspace."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.panel = panel = FramesPanel()
        self.place = FramesPlace(context, panel)
        store, loader = context.recorder.store, context.loader
        loader.stored = store
        panel.thumbnails.stored = partial(_stored_picture, store)
        self.open_frames = OpenFrameLimiter(
            context.workspace,
            self._is_busy,
            loader.is_postponed,
            store.has,
            context.recorder.flush,
            self,
        )
        self._wanted: Entry | None = None
        """The frame that is being opened; *Next frame* continues from it."""
        self._played: Entry | None = None
        """The frame shown by playing, while none is open."""
        self._soon = QTimer(self, singleShot=True, interval=_SOON_MS)
        self._soon.timeout.connect(self.show)
        context.actions.add(self._commands())
        self._connect_list()
        self._follow()
        self.show()

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "open_folder",
                "Open &folder of frames…",
                "List the frames of a folder or sequence, and open the first; the others are read when they are shown",
                icon="ph.folders",
                keys="Ctrl+Shift+F",
                handler=self.ask_folder,
            ),
            Command(
                "open_recording",
                "Open reco&rding…",
                "List the frames of a recording: a ROS bag or a camera recording; "
                "a ROS 2 bag is opened as a folder of frames",
                icon="ph.film-strip",
                handler=self.ask_recording,
            ),
            Command(
                "next_frame",
                "&Next frame",
                "Show the next frame in the order of the list",
                icon="ph.caret-down",
                keys="Ctrl+PgDown",
                handler=lambda: self.turn(1),
                why_off=self.why_no_other,
            ),
            Command(
                "previous_frame",
                "&Previous frame",
                "Show the previous frame in the order of the list",
                icon="ph.caret-up",
                keys="Ctrl+PgUp",
                handler=lambda: self.turn(-1),
                why_off=self.why_no_other,
            ),
            Command(
                "next_untouched",
                "Next &untouched frame",
                "Show the next frame that has not been worked on",
                icon="ph.caret-double-down",
                keys="Ctrl+Shift+PgDown",
                handler=self.next_untouched,
                why_off=self.why_no_other,
            ),
            Command(
                "mark_done",
                "Mark as &done",
                "Mark the current frame as done and show the next one that is not; if it is done, remove the mark",
                icon="ph.check-circle",
                keys="Ctrl+Return",
                handler=self.mark_done,
                needs=Need.FRAME,
            ),
            Command(
                "note_frame",
                "N&ote on the frame",
                "Write a note on the current frame",
                icon="ph.note-pencil",
                handler=self.write_note,
                why_off=self._why_empty,
            ),
        )

    def _connect_list(self) -> None:
        panel, context = self.panel, self.context
        panel.filter_changed.connect(self.show)
        panel.noted.connect(context.workspace.set_note)
        panel.view.opened.connect(self.open)
        panel.view.note_requested.connect(self._note)
        panel.view.removal_requested.connect(self.remove)
        panel.view.customContextMenuRequested.connect(self._show_menu)
        context.loader.listed.connect(self._tell_listed)

    def _follow(self) -> None:
        """Connect the signals that change the list or its rows."""
        workspace, context = self.context.workspace, self.context
        entries = workspace.entries
        for signal in (entries.added, entries.removed):
            signal.connect(lambda *_: self._soon.start())
        entries.changed.connect(self._note_changed)
        workspace.touched.connect(self._note_touched)
        context.refresh.add(
            "frames",
            self._show_present,
            (
                workspace.frames.session_changed,
                workspace.frames.sessions_changed,
                workspace.labels_changed,
                workspace.runs.results_changed,
            ),
            (workspace.runs.results_added,),
        )

    def _is_busy(self, document: Document) -> bool:
        """Whether work on a frame is in progress."""
        context = self.context
        return (
            document in context.runs.running
            or context.loader.is_extracting(document)
            or any(way.document is document for way in context.pending_work())
        )

    # display

    def show(self) -> None:
        """Update the whole list: frames, order, and counts of the states."""
        self._soon.stop()
        entries = self.context.workspace.entries
        present, model = self._present(), self.panel.model
        self.panel.show_counts(counts(entries))
        row = model.row_of(present)
        model.set_entries(self.panel.frame_filter.shown(entries, present))
        self._show_present()
        if model.row_of(present) != row:
            self.panel.scroll_to_present(present)

    def _show_present(self) -> None:
        """Update the row of the current frame."""
        present = self._present()
        if present is not None and self.panel.model.row_of(present) < 0:
            self._soon.start()
        if present is not self.panel.model.present:
            self._wanted = None
            self.panel.show_present(present)
        elif present is not None:
            self.panel.model.note_changed(present)

    def show_played(self, entry: Entry | None) -> None:
        """Mark the frame shown by playing as the current one; None once an open one is shown again."""
        self._played = entry
        self._show_present()

    def _present(self) -> Entry | None:
        if self._played is not None:
            return self._played
        workspace = self.context.workspace
        return workspace.entries.of(workspace.current.id) if workspace.has_current else None

    def _note_touched(self, document: Document) -> None:
        entry = self.context.workspace.entries.of(document.id)
        if entry is not None:
            self._note_changed(entry)

    def _note_changed(self, entry: Entry) -> None:
        self.panel.model.note_changed(entry)
        if not self._soon.isActive():
            self._soon.start()

    def why_no_other(self) -> str:
        """The list has no other frame; "" if it has."""
        more = len(self.context.workspace.entries) > 1
        return "" if more else "The list has no other frame: open more frames, or a folder of frames."

    def _why_empty(self) -> str:
        return "" if len(self.context.workspace.entries) else "Open a frame first."

    # navigation

    def open(self, entry: Entry) -> None:
        """Show a frame of the list."""
        if entry is not self._present():
            self._wanted = entry
        self.context.loader.open_entry(entry)

    def turn(self, steps: int) -> None:
        """Show the next or previous frame in the order of the list; the first follows the last."""
        shown, row = self.shown()
        if len(shown) > 1:
            self._go_to(shown[(row + steps) % len(shown)] if row >= 0 else shown[0 if steps > 0 else -1])

    def next_untouched(self) -> None:
        """Show the next frame that has not been worked on."""
        self._go_to_next(_is_untouched, "All frames shown in the list have been worked on.")

    def mark_done(self) -> None:
        """Mark the current frame as done, and show the next one that is not; if it is done, remove the mark."""
        entry = self._present()
        if entry is None:
            return
        done = not entry.summary.done
        self.context.workspace.set_done(entry, done)
        if not done:
            self.context.notes.show_message(f"{entry.name} is no longer marked as done.")
        elif len(self.context.workspace.entries) == 1:
            self.context.notes.show_message(f"{entry.name} is marked as done.")
        else:
            self._go_to_next(lambda other: not other.summary.done, "All frames shown in the list are done.")

    def _go_to_next(self, wanted: Callable[[Entry], bool], none_left: str) -> None:
        """Show the next wanted frame, the first after the last; a message if there is none."""
        shown, row = self.shown()
        entry = next((entry for entry in (*shown[row + 1 :], *shown[: row + 1]) if wanted(entry)), None)
        if entry is None:
            self.context.notes.show_message(none_left)
        else:
            self._go_to(entry)

    def shown(self) -> tuple[list[Entry], int]:
        """Return the shown entries, and the row of the current frame or the one being opened; -1 if not shown."""
        if self._soon.isActive():
            self.show()
        return self.panel.model.entries, self.panel.model.row_of(self._wanted or self._present())

    def _go_to(self, entry: Entry) -> None:
        self.panel.view.setCurrentIndex(self.panel.model.index_of(entry))
        self.open(entry)

    # commands on frames

    def ask_folder(self) -> None:
        """Open a folder of frames that the user chooses."""
        if chosen := choose_folder(self.context.window, "Open folder of frames", _FOLDER_KEY):
            self.context.feature(DocumentsFeature).open_source(FrameRef(chosen))

    def ask_recording(self) -> None:
        """Open a recording that the user chooses."""
        if chosen := choose_file(self.context.window, "Open recording", _FOLDER_KEY, recording_files()):
            self.context.feature(DocumentsFeature).open_source(FrameRef(chosen))

    def write_note(self) -> None:
        """Edit the note on the selected frame."""
        index = self.panel.view.currentIndex()
        entry = self.panel.model.entries[index.row()] if index.isValid() else self._present()
        if entry is not None:
            self._note(entry)

    def _note(self, entry: Entry) -> None:
        """Edit the note on a frame in the open panel."""
        self.context.panels.reveal("Frames")
        self.panel.write_note(entry)

    def remove(self, entries: Sequence[Entry]) -> None:
        """Remove frames from the list, and close those that are open."""
        row = self.panel.model.row_of(entries[0])

        def go_on() -> None:
            self.show()
            shown = self.panel.model.entries
            if shown and not self.context.workspace.has_current:
                self._go_to(shown[min(max(row, 0), len(shown) - 1)])

        self.context.feature(DocumentsFeature).remove_entries(entries, go_on)

    def _tell_listed(self, how: FrameRef, listing: Listing) -> None:
        count = len(listing.sources)
        text = f"{how.name}: {counted(count, 'frame')}."
        self.context.notes.show_message(" ".join((text, *listing.notes)))

    def _show_menu(self, at: QPoint) -> None:
        chosen = self.panel.view.chosen()
        if not chosen:
            return
        menu = QMenu(self.panel)
        for icon, text, do in self._commands_on(chosen):
            action = QAction(theme.icon(icon, menu.palette()), text, menu)
            action.triggered.connect(lambda _=False, do=do: do())
            menu.addAction(action)
        menu.aboutToHide.connect(menu.deleteLater)
        menu.popup(self.panel.view.viewport().mapToGlobal(at))

    def _commands_on(self, chosen: Sequence[Entry]) -> list[tuple[str, str, Callable[[], object]]]:
        """Return the commands on the selected frames: icon, text, handler."""
        first, several = chosen[0], len(chosen) > 1
        paths = "\n".join(entry.key for entry in chosen)
        removal = f"&Remove {len(chosen)} frames from the list" if several else "&Remove from the list"
        of_one: list[tuple[str, str, Callable[[], object]]] = [
            ("ph.image", "&Open", lambda: self.open(first)),
            ("ph.note-pencil", "&Note…", lambda: self._note(first)),
            ("ph.folder-open", "Show in &file manager", lambda: _show_files(first)),
        ]
        return [
            *([] if several else of_one),
            ("ph.copy", "&Copy paths" if several else "&Copy path", lambda: QGuiApplication.clipboard().setText(paths)),
            ("ph.x", removal, lambda: self.remove(chosen)),
        ]

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if no thread of the feature is left."""
        self._soon.stop()
        return self.panel.shutdown()


def _stored_picture(store: WorkStore, id: str) -> bytes | None:
    """Return the stored thumbnail of a frame, None if there is none."""
    name = thumbnail_part(id)
    return store.part(name) if store.has_part(name) else None


def _is_untouched(entry: Entry) -> bool:
    return entry.document is None and entry.summary.stage is Stage.UNTOUCHED


def _show_files(entry: Entry) -> None:
    source = entry.source
    place = Path(entry.key if source is None or source.frame is None else source.rgb)
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(place if place.is_dir() else place.parent)))
