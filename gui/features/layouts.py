"""Layouts of the window: the built-in ones, switching, saving and resetting them, and their storage."""

from __future__ import annotations

import contextlib
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import msgspec
from PySide6.QtCore import QByteArray, QEvent, QObject, QSettings, QSignalBlocker, Qt
from PySide6.QtGui import QAction, QWheelEvent
from PySide6.QtWidgets import QHBoxLayout, QInputDialog, QTabBar, QWidget

from ..base.commands import Command, command, describe
from ..views.layouts import CORRECT as CORRECT_VIEWS
from ..views.layouts import LAYOUTS
from ..views.linked_views import LinkedViews
from ..widgets.basics import lay_out, open_once
from .context import Context, Feature
from .views import ViewsFeature


@dataclass(frozen=True)
class Arrangement:
    """Arrangement of the window.

    Attributes
    ----------
    views : str
        Arrangement of the views, one of `gui.views.layouts.LAYOUTS`.
    contents : mapping of str to str
        Contents of the views: name of a cell -> name of its content; default contents for cells that are not listed.
    panels : tuple of str
        Titles of the open panels; None for the default ones.
    places : bytes
        Positions and sizes of the panels; empty for the defaults.
    sides : (str, str)
        The compared depths, A and B, as chosen; "" for automatic.
    cloud_beside : bool
        Whether the cloud is shown beside the images.
    contours : bool
        Whether blocks are drawn as outlines, without fill.
    text : str
        Displayed name of a layout.
    """

    views: str
    contents: Mapping[str, str] = field(default_factory=dict)
    panels: tuple[str, ...] | None = ()
    places: bytes = b""
    sides: tuple[str, str] = ("", "")
    cloud_beside: bool = False
    contours: bool = False
    text: str = ""


STANDARD, INSPECT, CORRECT, TUNE = "standard", "inspect", "correct", "tune"

BUILT_IN = {
    STANDARD: Arrangement("grid", panels=None, text="Standard"),
    INSPECT: Arrangement("grid-difference", panels=("Inspect", "Range"), text="Inspect"),
    CORRECT: Arrangement(CORRECT_VIEWS, contours=True, text="Correct"),
    TUNE: Arrangement("grid", panels=("Parameters", "Runs", "Convergence"), text="Tune"),
}
"""The built-in layouts by name."""

OWN = tuple(f"own_{number}" for number in range(1, 10))
"""Names of the user's own layouts, in the order of their shortcuts."""


# The views in an arrangement, and in a project.


def views_state(views: LinkedViews) -> dict[str, Any]:
    """Return layout and contents of the views as values for JSON."""
    return {
        "layout": views.sheet.layout_name,
        "contents": views.contents(),
        "sides": list(views.data.chosen_sides),
    }


def restore_views(views: LinkedViews, state: Mapping[str, Any]) -> None:
    """Restore what `views_state` has returned; unknown values are ignored."""
    contents, sides = state.get("contents"), state.get("sides")
    if state.get("layout") in LAYOUTS:
        views.sheet.set_layout(str(state["layout"]))
    for cell, content in contents.items() if isinstance(contents, Mapping) else ():
        with contextlib.suppress(ValueError):  # there is no such content
            views.set_content(str(cell), str(content))
    if isinstance(sides, list) and len(sides) == 2:
        with contextlib.suppress(ValueError):
            views.sides.choose(*map(str, sides))


# Storage of layouts between program starts.

_KEY = "layouts"


class LayoutStore:
    """Layouts by name, each in its state after a reset, with the current one and the last state of each; stored between
    program starts."""

    def __init__(self) -> None:
        self.layouts = dict(BUILT_IN)
        self.changed: dict[str, Arrangement] = {}
        """Last state of layouts, if known."""
        self.present = STANDARD
        self._read()

    @property
    def own(self) -> dict[str, Arrangement]:
        """The user's own layouts, in order."""
        return {name: self.layouts[name] for name in OWN if name in self.layouts}

    def named(self, text: str) -> str | None:
        """Return the name of the layout with this displayed name, ignoring case; None for none."""
        return next((name for name, one in self.layouts.items() if one.text.casefold() == text.casefold()), None)

    def free_name(self) -> str | None:
        """Return the first free name of an own layout; None if there is none."""
        return next((name for name in OWN if name not in self.layouts), None)

    def put(self, name: str, layout: Arrangement | None) -> None:
        """Store an own layout; None deletes it."""
        self.changed.pop(name, None)
        if layout is None:
            del self.layouts[name]
        else:
            self.layouts[name] = layout
        self.write()

    def left(self, name: str) -> Arrangement:
        """Return the last state of a layout, or its default."""
        return self.changed.get(name, self.layouts[name])

    def write(self) -> None:
        """Store all layouts."""
        stored = msgspec.json.encode((self.present, self.own, self.changed))
        # with its checksum: Qt may crash on damaged places
        QSettings().setValue(_KEY, QByteArray(zlib.compress(stored)))

    def _read(self) -> None:
        kind = tuple[str, dict[str, Arrangement], dict[str, Arrangement]]
        try:
            stored = zlib.decompress(QSettings().value(_KEY))
            present, own, changed = msgspec.json.decode(stored, type=kind)
        except (zlib.error, msgspec.DecodeError, TypeError):
            return  # there are none, or they are damaged: fall back to the built-in ones
        self.layouts |= {name: layout for name, layout in own.items() if name in OWN}
        self.changed = {name: left for name, left in changed.items() if name in self.layouts}
        self.present = present if present in self.layouts else STANDARD


# The window.

_SWITCHES = {
    STANDARD: ("&Standard", "Blocks and parameters beside the views", "ph.layout", ""),
    INSPECT: (
        "&Inspect",
        "Views with the difference; depth profile, measurements and colour range",
        "ph.eye",
        "F3",
    ),
    CORRECT: (
        "&Correct",
        "One large view for correcting blocks, with their outlines; the others small beside it, no panels",
        "ph.pencil-line",
        "F4",
    ),
    TUNE: ("&Tune", "Views with parameters, runs and convergence", "ph.sliders", "F12"),
    **{name: (name, "A layout of your own", "", f"Ctrl+Alt+{number}") for number, name in enumerate(OWN, 1)},
}
"""Text, hint, icon and keys of the command that switches to a layout."""

_GAP = 14
"""Space between the view controls and the layouts [px]."""
_LEAST = 60
"""Width of the layouts in which at least one can be seen, and others scrolled to [px]."""

_NOT_OWN = "The current layout is built in: only your own layouts can be renamed or deleted."


class _Tabs(QTabBar):
    """Tabs of the layouts."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()  # it would turn the whole window to another layout


class LayoutsFeature(Feature):
    """Switches between layouts of the window. Changes by the user are stored with the layout."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.store = LayoutStore()
        self._last = STANDARD
        self._deleted: tuple[str, Arrangement] | None = None
        self._actions: dict[str, QAction] = {}
        for name, (text, hint, icon, keys) in _SWITCHES.items():
            hint, choose = f"{hint}; again to go back", partial(self._choose, name)
            context.actions.add([Command(f"layout_{name}", text, hint, icon, keys, checkable=True, handler=choose)])
            self._actions[name] = context.actions[f"layout_{name}"]
        self.menu = context.actions.menu("&Layout", context.window)
        context.actions.adopt("layout_menu", self.menu.menuAction())
        self.bar = _Tabs(drawBase=False, expanding=False, usesScrollButtons=True)
        self.bar.setAccessibleName("Layouts")
        self.bar.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.bar.currentChanged.connect(lambda number: self.turn(self.bar.tabData(number)))
        self._menu_bar, self._view_bar, self._corner = (
            context.window.menuBar(),
            context.feature(ViewsFeature).bar,
            QWidget(),
        )
        lay_out(QHBoxLayout(self._corner), self._view_bar, self.bar, spacing=_GAP)
        self._menu_bar.setCornerWidget(self._corner)
        self._menu_bar.installEventFilter(self)
        context.centre.turned.connect(self._fit_header)
        self._apply(self.store.left(self.store.present))
        self._show()

    def _fit_header(self) -> None:
        """Show the layouts that there is room for beside the menus and the view controls; in a narrow window, they are
        scrolled to, or in the menu only."""
        self._view_bar.updateGeometry()  # the corner learns of a tab that came or went in the view bar only later
        menus = self._menu_bar.sizeHint().width() - self._corner.sizeHint().width()
        left = self._menu_bar.width() - menus - _GAP - self._view_bar.sizeHint().width()
        self.bar.setVisible(left >= _LEAST)
        self.bar.setMaximumWidth(min(self.bar.sizeHint().width(), max(left, 0)))
        self._menu_bar.setCornerWidget(self._corner)  # updates its place

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Fit the layouts to the width of the menu bar."""
        if event.type() == QEvent.Type.Resize:
            self._fit_header()
        return False

    def _choose(self, name: str, on: bool) -> None:
        """Switch to a layout, or to the previous one."""
        if on != (name == self.present):
            self.turn(name if on else self._back())

    def _why_not_own(self) -> str:
        return "" if self.present in OWN else _NOT_OWN

    @property
    def present(self) -> str:
        """Name of the current layout."""
        return self.store.present

    def turn(self, name: str) -> None:
        """Switch to a layout in its last state."""
        if name != self.present and name in self.store.layouts:
            self.context.actions["swipe"].setChecked(False)  # its contents are not part of a layout
            self._leave(name)
            self._apply(self.store.left(name))
            self.context.centre.show_images()
            self.views.active.view.setFocus()
        self._show()

    @command("reset_layout", "&Reset layout", icon="ph.arrow-counter-clockwise")
    def reset(self) -> None:
        """Reset the current layout to its default or saved state."""
        self.store.changed.pop(self.present, None)
        self._apply(self.store.layouts[self.present])
        self.views.active.view.setFocus()

    def save(self, text: str) -> bool:
        """Save the state of the window under a name, replacing an own layout of that name; return False if that is not
        possible."""
        text = text.strip()
        name = self.store.named(text) or self.store.free_name()
        if not text:
            return False
        if name is None:
            self.notes.show_message(f"You have {len(OWN)} layouts of your own, the maximum: delete one first.")
        elif name not in OWN:
            self.notes.show_message(f"{text} is built in and cannot be replaced: choose another name.")
        else:
            now = self._arrangement()
            if name != self.present:
                self._leave(name)
            self.store.put(name, replace(now, text=text))
            self._show()
        return name in OWN

    def rename(self, text: str) -> bool:
        """Rename the current layout, one of the user's own; return False if that is not possible."""
        text = text.strip()
        is_free = self.store.named(text) in (None, self.present)
        if not is_free:
            self.notes.show_message(f"A layout {text} exists already: choose another name.")
        elif text:
            self.store.put(self.present, replace(self.store.layouts[self.present], text=text))
            self._show()
        return bool(text) and is_free

    @command("delete_layout", "&Delete layout", icon="ph.trash", why_off=_why_not_own)
    def delete(self) -> None:
        """Delete the current layout, if it is one of your own.

        The previous one is switched to; the deleted one can be restored.
        """
        name = self.present
        self.turn(self._back())
        self._deleted = name, self.store.layouts[name]
        self.store.put(name, None)
        self._show()
        text = f"Layout {self._deleted[1].text} deleted."
        self.notes.offer(text, self.context.actions["restore_layout"])

    @command(
        "restore_layout",
        "Restore layout",
        why_off=lambda self: "" if self._deleted is not None else "No layout has been deleted.",
    )
    def restore(self) -> None:
        """Restore the layout that was deleted last."""
        assert self._deleted is not None
        (name, layout), self._deleted = self._deleted, None
        place = name if name not in self.store.layouts else self.store.free_name()
        if place is not None:
            self.store.put(place, layout)
            self.turn(place)
        self._show()

    def shutdown(self) -> None:
        """Store the arrangement of the window."""
        self.store.changed[self.present] = self._arrangement()
        self.store.write()

    @command("save_layout", "Sa&ve layout as…", icon="ph.floppy-disk")
    def _ask_save(self) -> None:
        """Save the views, their contents and the panels under a name, with a shortcut."""
        present = self.store.layouts[self.present]
        proposed = present.text if self.present in OWN else ""
        self._ask("Save layout as", "Name of the layout:", proposed, self.save)

    @command("rename_layout", "Re&name layout…", why_off=_why_not_own)
    def _ask_rename(self) -> None:
        """Rename the current layout, if it is one of your own."""
        self._ask("Rename layout", "New name:", self.store.layouts[self.present].text, self.rename)

    def _ask(self, title: str, label: str, proposed: str, then: Callable[[str], bool]) -> None:
        dialog = QInputDialog(self.context.window)
        dialog.setWindowTitle(title)
        dialog.setLabelText(label)
        dialog.setTextValue(proposed)
        dialog.textValueSelected.connect(then)
        open_once(dialog)

    # implementation

    def _leave(self, following: str) -> None:
        self.store.changed[self.present] = self._arrangement()
        self._last = self.present
        self.store.present = following

    def _back(self) -> str:
        """Return the previous layout, or the standard one."""
        return self._last if self._last in self.store.layouts and self._last != self.present else STANDARD

    def _arrangement(self) -> Arrangement:
        """Return the current arrangement of the window."""
        panels, views = self.context.panels, self.views
        return Arrangement(
            views.sheet.layout_name,
            views.contents(),
            tuple(panels.open),
            panels.places(),
            views.data.chosen_sides,
            self.context.actions["cloud_beside"].isChecked(),
            self.context.actions["contours_only"].isChecked(),
        )

    def _apply(self, arrangement: Arrangement) -> None:
        """Apply an arrangement to the window."""
        if arrangement.views in LAYOUTS:
            self.views.sheet.set_layout(arrangement.views, self.store.layouts[self.present].views)
        self.views.reset_contents()
        restore_views(self.views, {"contents": arrangement.contents, "sides": [*arrangement.sides]})
        self.context.actions["cloud_beside"].setChecked(arrangement.cloud_beside)
        self.context.actions["contours_only"].setChecked(arrangement.contours)
        self.context.panels.take(arrangement.panels, arrangement.places)

    def _show(self) -> None:
        """Show the layouts in menu and bar, and mark the current one."""
        own = self.store.own
        for name, action in self._actions.items():
            action.setChecked(name == self.present)
            if name in OWN:
                action.setVisible(name in own)
                action.setText(own[name].text.replace("&", "&&") if name in own else name)
                describe(action)
        actions = self.context.actions
        self.menu.clear()
        with QSignalBlocker(self.bar):
            for _ in range(self.bar.count()):
                self.bar.removeTab(0)
            for number, name in enumerate(self.store.layouts):
                action = self._actions[name]
                self.menu.addAction(action)
                self.bar.addTab(action.text())
                self.bar.setTabData(number, name)
                self.bar.setTabToolTip(number, action.toolTip())
                if name == self.present:
                    self.bar.setCurrentIndex(number)
        actions.fill(self.menu, "| save_layout rename_layout delete_layout | reset_layout")
        self._fit_header()
        actions.refresh()
