"""The layouts of the window: turning to them, keeping them, and going back."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable

from PySide6.QtCore import QEvent, QSettings, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QInputDialog, QMenu, QToolButton, QWidget

from ...base import theme
from ...base.actions import Actions
from ...base.commands import Command
from ...views.layouts import CORRECT as CORRECT_VIEWS
from ...views.layouts import LAYOUTS
from ..context import Desk, Part
from ..menus import insert_menu
from .layout import BUILT_IN, CORRECT, INSPECT, OWN, STANDARD, TUNE, Arrangement, Layout, LayoutStore

# The commands that have to do with layouts of the window.

_ICONS = {STANDARD: "ph.layout", INSPECT: "ph.eye", CORRECT: "ph.pencil-line", TUNE: "ph.sliders"}
_KEYS = {INSPECT: "F3", CORRECT: "F4", TUNE: "F12"}

COMMANDS = (
    *(
        Command(
            f"layout_{layout.name}",
            f"&{layout.text}",
            _ICONS[layout.name],
            _KEYS.get(layout.name, ""),
            f"{layout.hint}; or back",
            checkable=True,
        )
        for layout in BUILT_IN
    ),
    *(
        Command(f"layout_{name}", name, "", f"Ctrl+Alt+{number}", "A layout of your own; or back", checkable=True)
        for number, name in enumerate(OWN, 1)
    ),
    Command(
        "save_layout",
        "&Save layout as…",
        "ph.floppy-disk",
        "",
        "Keep the views, what they show, and the panels as they are now under a name, with a key",
    ),
    Command("rename_layout", "Re&name layout…", "", "", "Give the present layout, one of your own, another name"),
    Command("delete_layout", "&Delete layout", "ph.trash", "", "Delete the present layout, one of your own"),
    Command("restore_layout", "Restore layout", "", "", "Bring back the layout that was deleted last"),
    Command(
        "reset_layout",
        "&Reset layout",
        "ph.arrow-counter-clockwise",
        "",
        "Bring the present layout back to what it is from the first, or was saved as",
    ),
)


# The layouts at the end of the menu bar, each a click away.

_MOST_WIDTH = 460
"""Layouts for which there is no room in so many pixels are in the menu alone."""


class _LayoutButton(QToolButton):
    """Turns to its layout as its action does, but never back."""

    def nextCheckState(self) -> None:
        if not self.isChecked():
            super().nextCheckState()


class LayoutBar(QWidget):
    """A button for each layout; that of the present one is marked, and a click on it changes nothing."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(0, 0, 6, 0)
        self._row.setSpacing(2)
        self._buttons: dict[QAction, QToolButton] = {}
        self._paint()

    def set_actions(self, actions: Iterable[QAction]) -> None:
        """Have buttons for these."""
        wanted = list(actions)
        if list(self._buttons) != wanted:
            self._make(wanted)
        width = 0
        for action, button in self._buttons.items():
            width += button.sizeHint().width() + self._row.spacing()
            button.setVisible(width <= _MOST_WIDTH or action.isChecked())
        self.adjustSize()

    def _make(self, wanted: list[QAction]) -> None:
        for button in self._buttons.values():
            button.hide()
            button.deleteLater()
        self._buttons = {}
        for action in wanted:
            button = _LayoutButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self._row.addWidget(button)
            self._buttons[action] = button

    def changeEvent(self, event: QEvent) -> None:
        """Take the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._paint()

    def _paint(self) -> None:
        colours = theme.colours(self.palette())
        sheet = (
            "QToolButton { border: none; padding: 1px 7px; background: transparent; "
            f"color: {colours.muted.name()}; }}"
            f"QToolButton:hover {{ color: {colours.text.name()}; }}"
            f"QToolButton:checked {{ color: {colours.text.name()}; border-bottom: 2px solid {colours.accent.name()}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)


# What the user has chosen to see over the pictures, known from session to session.

_KEY = "views"
_CHOICES = "contours_only", "block_names", "show_missing"


def remember_choices(actions: Actions) -> None:
    """Choose what was chosen the last time, and keep what is chosen from now on."""
    settings = QSettings()
    for name in _CHOICES:
        action = actions[name]
        action.setChecked(settings.value(f"{_KEY}/{name}", False, bool) is True)
        action.toggled.connect(lambda on, name=name: QSettings().setValue(f"{_KEY}/{name}", on))


_NOT_OWN = "The present layout is always there: only your own can be renamed or deleted."


class LayoutsPart(Part):
    """Turns the window from one layout to another. What the user changes in one stays with it."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        desk.actions.add(COMMANDS)
        self.store = LayoutStore(desk.panels.remembers)
        self._last = STANDARD
        self._views, self._lasting = desk.views.layout_name, desk.views.lasting_layout
        self._turning = False
        self._deleted: Layout | None = None
        names = [*(layout.name for layout in BUILT_IN), *OWN]
        self._actions: dict[str, QAction] = {name: desk.actions[f"layout_{name}"] for name in names}
        for name, action in self._actions.items():
            action.triggered.connect(lambda _=False, name=name: self.toggle(name))
        for name, do in {
            "save_layout": self._ask_save,
            "rename_layout": self._ask_rename,
            "delete_layout": self.delete,
            "restore_layout": self.restore,
            "reset_layout": self.reset,
        }.items():
            desk.actions[name].triggered.connect(lambda _=False, do=do: do())
        desk.views.layoutChanged.connect(self._follow_views)
        self.menu = QMenu("&Layout", desk.window)
        self.bar = LayoutBar()

    def begin(self) -> None:
        """Stand in the menus, and take the layout of the last time."""
        insert_menu(self.desk.window.menuBar(), self.menu, self.desk.actions["full_screen"])
        self._take(self.store.left(self.store.present))
        self._show()
        if self.desk.panels.remembers:
            remember_choices(self.desk.actions)

    @property
    def present(self) -> str:
        """Name of the layout that the window is in."""
        return self.store.present

    def toggle(self, name: str) -> None:
        """Turn to a layout, or, if it is the present one, to the one before it."""
        self.turn(self._back() if name == self.present else name)

    def turn(self, name: str) -> None:
        """Turn to a layout, as it was left."""
        if name != self.present and name in self.store.layouts:
            self._leave(name)
            self._take(self.store.left(name))
        self._show()

    def reset(self) -> None:
        """Bring the present layout back to what it is from the first, or was saved as."""
        self.store.changed.pop(self.present, None)
        self.desk.panels.forget_folded()
        self._take(self.store.layouts[self.present].arrangement)

    def save(self, text: str) -> bool:
        """Keep the window as it is under a name, in the place of an own layout so called; False if that cannot be."""
        text = text.strip()
        known = self.store.named(text)
        name = self.store.free_name() if known is None else known.name
        if not text:
            return False
        if known is not None and not self.store.is_own(known.name):
            self.desk.notes.tell(f"{known.text} is always there and is not replaced: choose another name.")
            return False
        if name is None:
            self.desk.notes.tell(f"There are {len(OWN)} layouts of your own, and no more keys: delete one first.")
            return False
        now = self._arrangement()
        if name != self.present:
            self._leave(name)
        self.store.put(name, text, now)
        self._show()
        keys = self._actions[name].shortcut().toString()
        self.desk.notes.tell(f"Layout {text} saved" + (f"; {keys} turns to it." if keys else "."))
        return True

    def rename(self, text: str) -> bool:
        """Give the present layout, one of the user's own, another name; False if that cannot be."""
        text = text.strip()
        known = self.store.named(text)
        if not text or not self.store.is_own(self.present):
            return False
        if known is not None and known.name != self.present:
            self.desk.notes.tell(f"There is a layout {known.text} already: choose another name.")
            return False
        self.store.put(self.present, text, self.store.layouts[self.present].arrangement)
        self._show()
        return True

    def delete(self) -> None:
        """Delete the present layout, one of the user's own, and turn to the one before it; it can be brought back."""
        name = self.present
        if not self.store.is_own(name):
            return
        self.turn(self._back())
        self._deleted = self.store.delete(name)
        self._show()
        self.desk.notes.offer(f"Layout {self._deleted.text} deleted.", self.desk.actions["restore_layout"])

    def restore(self) -> None:
        """Bring back the layout that was deleted last, if its place is free still."""
        deleted, self._deleted = self._deleted, None
        if deleted is None:
            return
        name = deleted.name if deleted.name not in self.store.layouts else self.store.free_name()
        if name is not None:
            self.store.put(name, deleted.text, deleted.arrangement)
            self.turn(name)
        self._show()

    def shutdown(self) -> bool:
        """Keep how the window is arranged for the next time."""
        self.store.changed[self.present] = self._arrangement()
        self.store.write()
        return True

    def _ask_save(self) -> None:
        present = self.store.layouts[self.present]
        proposed = present.text if self.store.is_own(self.present) else ""
        self._ask("Save layout as", "Name of the layout:", proposed, self.save)

    def _ask_rename(self) -> None:
        self._ask("Rename layout", "New name:", self.store.layouts[self.present].text, self.rename)

    def _ask(self, title: str, label: str, proposed: str, then: Callable[[str], bool]) -> None:
        dialog = QInputDialog(self.desk.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setWindowTitle(title)
        dialog.setLabelText(label)
        dialog.setTextValue(proposed)
        dialog.textValueSelected.connect(then)
        dialog.open()

    # how it is done

    def _leave(self, following: str) -> None:
        self.store.changed[self.present] = self._arrangement()
        self._last = self.present
        self.store.present = following

    def _back(self) -> str:
        """The layout before the present one, or one that is always there."""
        return self._last if self._last in self.store.layouts and self._last != self.present else STANDARD

    def _arrangement(self) -> Arrangement:
        """How the window is arranged now."""
        panels, views = self.desk.panels, self.desk.views
        return Arrangement(
            self._views,
            views.contents(),
            tuple(panels.open),
            panels.places(),
            views.sides.chosen,
            self.desk.actions["cloud_beside"].isChecked(),
        )

    def _take(self, arrangement: Arrangement) -> None:
        """Arrange the window so."""
        views = self.desk.views
        self._turning = True
        try:
            if arrangement.views in LAYOUTS:
                views.set_layout(arrangement.views, self.store.layouts[self.present].arrangement.views)
            views.reset_contents()
            for cell, content in arrangement.contents.items():
                with contextlib.suppress(ValueError):  # what there is no longer is passed over
                    views.set_content(cell, content)
            with contextlib.suppress(ValueError):
                views.sides.choose(*arrangement.sides)
            self.desk.actions["cloud_beside"].setChecked(arrangement.cloud_beside)
        finally:
            self._turning = False
        self.desk.panels.take(arrangement.panels, arrangement.places)

    def _follow_views(self, name: str) -> None:
        """Views that are arranged for correcting, or no longer, bring the panels of that layout with them; not so in an
        own layout, which may have any views, nor while one looks at a single view, or at two depths, from there."""
        lasting = self.desk.views.lasting_layout
        if not self._turning and not self.store.is_own(self.present):
            comes, goes = lasting == CORRECT_VIEWS, self.present == CORRECT
            if comes != goes:
                self._views = self._lasting
                self._leave(CORRECT if comes else self._back())
                there = self.store.left(self.present)
                self.desk.panels.take(there.panels, there.places)
                self._show()
        self._views, self._lasting = name, lasting

    def _show(self) -> None:
        """Say in menu and bar which layouts there are, and which is present."""
        own = {layout.name: layout.text for layout in self.store.own}
        for name, action in self._actions.items():
            action.setChecked(name == self.present)
            if name in OWN:
                action.setVisible(name in own)
                action.setText(own.get(name, name).replace("&", "&&"))
        shown = [self._actions[name] for name in self.store.layouts]
        actions = self.desk.actions
        self.menu.clear()
        self.menu.addActions(shown)
        self.menu.addSeparator()
        self.menu.addActions([actions[name] for name in ("save_layout", "rename_layout", "delete_layout")])
        self.menu.addSeparator()
        self.menu.addAction(actions["reset_layout"])
        self.bar.set_actions(shown)
        self.desk.window.menuBar().setCornerWidget(self.bar)  # with the room that it needs now
        actions.allow("" if self.store.is_own(self.present) else _NOT_OWN, "rename_layout", "delete_layout")
        actions.allow("" if self._deleted is not None else "No layout has been deleted.", "restore_layout")
