"""Keys of the tools, which work wherever the focus is in the window; and the crosshair, a pointer that keys move."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QDockWidget,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)
from shiboken6 import isValid

from ..views.image_view import ImageView
from ..views.interaction import ARROWS, PointerEvent, PointerKind
from ..views.linked_views import LinkedViews
from .editor import Editor

FAR = 10
"""Pixels of a long step."""
_ABOUT = (
    "Arrow keys move the crosshair (Shift: 10 px, Ctrl: to the next border). Space clicks; hold it and move to drag."
)


class Crosshair:
    """A pixel of the frame that keys move, and where they click and drag.

    The mouse takes over when it moves, except during a drag by keys.
    """

    def __init__(self, editor: Editor, views: LinkedViews) -> None:
        self._editor = editor
        self._views = views
        self._at: tuple[int, int] | None = None
        self._press: PointerEvent | None = None
        self._explained = False
        self.active = False
        """Whether keys have moved it since the mouse was moved last."""

    def show(self) -> None:
        """Show it where the mouse was last, where it was before, or in the middle of what is seen."""
        seen = self._views.active.view.visible_box()
        middle = (seen[1].start + seen[1].stop) // 2, (seen[0].start + seen[0].stop) // 2
        self._put(*((self._at if self.active else None) or self._views.navigation.pixel or self._at or middle))
        if not self._explained:
            self._explained = True
            self._editor.show_message(_ABOUT)

    def move(self, key: int, far: bool, to_border: bool) -> None:
        """Move it by an arrow key: by a pixel, by `FAR`, or to the next border of blocks."""
        if not self.active or self._at is None:
            self.show()
        assert self._at is not None
        along, down = ARROWS[key]
        step = self._to_border(along, down) if to_border else FAR if far else 1
        self._put(self._at[0] + step * along, self._at[1] + step * down)

    def press(self, modifiers: Qt.KeyboardModifier) -> None:
        """Press the button, with modifiers that hold until it is released."""
        self._press = replace(
            self._event(PointerKind.PRESS),
            shift=bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            ctrl=bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
        )
        self._editor.pointer(self._press)

    def release(self) -> None:
        """Release the button."""
        if self._press is not None:
            event = self._event(PointerKind.RELEASE)
            self._press = None
            self._editor.pointer(event)

    def give_way(self, event: PointerEvent) -> bool:
        """Leave the tool to the mouse when it moves or presses; False during a drag by keys."""
        if event.kind in (PointerKind.HOVER, PointerKind.PRESS):
            self.active &= self._press is not None
        return self._press is None

    def _put(self, x: int, y: int) -> None:
        """Put it on a pixel, or on the next one of the frame, and keep that in sight."""
        height, width = self._editor.document.frame.shape
        x, y = min(max(x, 0), width - 1), min(max(y, 0), height - 1)
        rows, columns = self._views.active.view.visible_box()
        if not (rows.start <= y < rows.stop and columns.start <= x < columns.stop):
            self._views.transform.look_at(x + 0.5, y + 0.5, self._views.transform.scale)
        self._at, self.active = (x, y), True
        self._views.navigation.point_at(self._at)
        self._editor.pointer(self._event(PointerKind.HOVER if self._press is None else PointerKind.MOVE))

    def _event(self, kind: PointerKind) -> PointerEvent:
        assert self._at is not None
        x, y = self._at[0] + 0.5, self._at[1] + 0.5
        if self._press is not None:
            return replace(self._press, kind=kind, x=x, y=y)
        return PointerEvent(kind, x, y, pixel=1 / self._views.transform.scale)

    def _to_border(self, along: int, down: int) -> int:
        """Return the number of pixels to the next block in a direction, or to the end of the frame."""
        assert self._at is not None
        x, y = self._at
        labels = self._editor.document.labels
        line, start = (labels[y], x) if along else (labels[:, x], y)
        ahead = line[start :: along + down]
        others = np.flatnonzero(ahead != ahead[0])
        return int(others[0]) if len(others) else len(ahead)


# The keys.

_Modifier = Qt.KeyboardModifier
_PLAIN = _Modifier.NoModifier
_Key = Qt.Key
_ENTER = _Key.Key_Return, _Key.Key_Enter
_LEAVING = *_ENTER, _Key.Key_Escape
_BY_KEYS = (
    Qt.FocusReason.TabFocusReason,
    Qt.FocusReason.BacktabFocusReason,
    Qt.FocusReason.ShortcutFocusReason,
)


class ToolKeys(QObject):
    """Event filter for the keys of the tools: Enter finishes, Backspace removes the last part, Ctrl+Z cancels a stroke;
    other keys switch an action on while held. In a view, arrows move the crosshair, and Space or Enter clicks
    there; after the mouse was moved, Space pans.

    They work in the whole window and its panels, but not in text and number fields and not in dialogs, and only when
    they have an effect. During keyboard navigation in the panels, Space works as usual. When a focused part of the
    window is hidden, the views get the focus; so they do when Enter takes a typed number, or Escape drops it.

    Parameters
    ----------
    window : QWidget
    editor : Editor
    views : LinkedViews
    held : mapping of int to QAction
        Key -> an action that is checked while the key is held.
    """

    def __init__(self, window: QWidget, editor: Editor, views: LinkedViews, held: Mapping[int, QAction]) -> None:
        super().__init__(window)
        self._held = held
        self.on_enter: Callable[[], bool] = lambda: False
        """Called when Enter is pressed and the tool has nothing to finish; returns whether it did anything."""
        self.on_unused: Callable[[QKeyEvent], bool] = lambda event: False
        """Called with a key that nothing in the window has used; returns whether it was used now."""
        self._window = window
        self._editor = editor
        self._views = views
        self.crosshair = Crosshair(editor, views)
        self._keyboard_focus = False
        """Whether the focus was last moved by keys."""
        window.installEventFilter(self)
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.focusChanged.connect(self._focus_changed)

    def _focus_changed(self, old: QWidget | None, new: QWidget | None) -> None:
        """Filter the events of the focused widget; a filter of the program would be called for each of its events.

        Qt gives the focus of a hidden widget to any other one, a list of frames for example: the views take it."""
        if new is None:
            return
        new.installEventFilter(self)
        was_hidden = self._was_hidden(old)
        self._keyboard_focus &= not was_hidden
        if isinstance(new, ImageView):
            self._views.activate(new)
            if self._keyboard_focus and self._editor.ready:
                self.crosshair.show()
            self._keyboard_focus = False
        elif was_hidden and self._views.isVisible() and self._belongs(new):
            self._views.active.view.setFocus()

    def _was_hidden(self, old: QWidget | None) -> bool:
        """Whether a part of the window lost the focus because it was hidden."""
        return old is not None and isValid(old) and not old.isVisible() and self._belongs(old)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle the keys of the tools. Called for every event of the widgets that have had the focus."""
        if isinstance(event, QKeyEvent):
            return self._take(watched, event) or (watched is self._window and self.on_unused(event))
        if isinstance(event, QFocusEvent):
            if event.reason() == Qt.FocusReason.MouseFocusReason:
                self._keyboard_focus = False
            elif event.reason() in _BY_KEYS:
                # Qt gives the same reason when the focused widget is hidden or disabled
                usable = isinstance(watched, QWidget) and watched.isVisible() and watched.isEnabled()
                self._keyboard_focus |= event.lostFocus() and usable
            elif event.reason() == Qt.FocusReason.PopupFocusReason:
                self._let_go_of_space()  # the key will be released in the popup
        if watched is self._window and event.type() == QEvent.Type.WindowDeactivate:
            self._let_go_of_space()
            for action in self._held.values():
                action.setChecked(False)
        return False

    def _take(self, watched: QObject, event: QKeyEvent) -> bool:
        """Handle a key event; True if it was for the tools and must not be passed on."""
        if event.type() == QEvent.Type.KeyRelease and event.key() == _Key.Key_Space and not event.isAutoRepeat():
            self._let_go_of_space()  # wherever the focus is now
        if isinstance(watched, QAbstractSpinBox) and event.key() in _LEAVING and self._belongs(watched):
            if event.type() == QEvent.Type.KeyPress:
                self._leave(watched, event.key() in _ENTER)
            event.accept()  # no shortcut
            return True
        if isinstance(watched, QAbstractSpinBox) and _goes_to_window(watched, event):
            event.ignore()  # the shortcut undoes what the window did
            return event.type() == QEvent.Type.ShortcutOverride
        if isinstance(watched, QAbstractItemView) and event.key() == _Key.Key_F2:  # it renames what it lists
            event.accept()
            return event.type() == QEvent.Type.ShortcutOverride
        if not isinstance(watched, QWidget) or not self._applies_to(watched):
            return False
        if event.key() in self._held and event.modifiers() == _PLAIN and event.type() != QEvent.Type.ShortcutOverride:
            if not event.isAutoRepeat() and self._held[event.key()].isEnabled():
                self._held[event.key()].setChecked(event.type() == QEvent.Type.KeyPress)
            return True
        if not (self._views.isVisible() or self._editor.tool.points_only):  # the point cloud is shown instead
            return False
        if event.type() == QEvent.Type.ShortcutOverride:
            return self._override(event)
        if event.key() == _Key.Key_Space and not event.modifiers() & _Modifier.AltModifier:
            navigating = self._keyboard_focus and watched is not self._window
            if event.type() == QEvent.Type.KeyPress and not event.isAutoRepeat() and not navigating:
                self._press_space(watched, event)
            return not navigating
        return event.type() == QEvent.Type.KeyPress and self._press(watched, event)

    def _leave(self, field: QAbstractSpinBox, take: bool) -> None:
        """Take what was typed into a number field, or drop it, and give the focus back to the views."""
        if take:
            field.interpretText()
        else:
            field.setProperty("value", field.property("value"))
        field.clearFocus()
        self._views.active.view.setFocus()

    def _press_space(self, watched: QWidget, event: QKeyEvent) -> None:
        """Click at the crosshair, or let the mouse pan."""
        if self.crosshair.active and self._views.isAncestorOf(watched):
            self.crosshair.press(event.modifiers())
        else:
            self._views.navigation.set_space(True)

    def _let_go_of_space(self) -> None:
        self._views.navigation.set_space(False)
        self.crosshair.release()

    def _applies_to(self, watched: QWidget) -> bool:
        focus = QApplication.focusWidget() or self._window
        if watched is not focus or not self._editor.ready or QApplication.activePopupWidget() is not None:
            return False
        return self._belongs(watched) and not _accepts_text(watched)

    def _belongs(self, widget: QWidget) -> bool:
        """Whether a widget is in the window or in a floating panel of it."""
        top = widget.window()
        return top is self._window or (isinstance(top, QDockWidget) and top.parentWidget() is self._window)

    def _override(self, event: QKeyEvent) -> bool:
        """During a stroke, prevent Ctrl+Z from undoing the previous step, and widgets from using Escape."""
        if self._editor.busy and event.matches(QKeySequence.StandardKey.Undo):
            event.accept()
            return True
        return self._editor.busy and event.key() == _Key.Key_Escape

    def _press(self, watched: QWidget, event: QKeyEvent) -> bool:
        key, editor = event.key(), self._editor
        if editor.busy and event.matches(QKeySequence.StandardKey.Undo):
            return editor.cancel()
        modifiers, in_view = event.modifiers() & ~_Modifier.KeypadModifier, self._views.isAncestorOf(watched)
        if key == _Key.Key_Backspace and modifiers == _PLAIN:
            return editor.undo_last()
        if key in ARROWS and in_view and not modifiers & _Modifier.AltModifier:
            far, to_border = (bool(modifiers & one) for one in (_Modifier.ShiftModifier, _Modifier.ControlModifier))
            self.crosshair.move(key, far, to_border)
            return True
        if key not in _ENTER:
            return False
        if modifiers == _PLAIN and (editor.finish() or self.on_enter()):
            return True
        clicks = in_view and self.crosshair.active
        if clicks:
            self.crosshair.press(modifiers)
            self.crosshair.release()
        return clicks


def _accepts_text(widget: QWidget) -> bool:
    if isinstance(widget, (QTextEdit, QPlainTextEdit)):
        return not widget.isReadOnly()
    return isinstance(widget, (QLineEdit, QAbstractSpinBox))


def _goes_to_window(field: QAbstractSpinBox, event: QKeyEvent) -> bool:
    """Whether a key undoes or redoes, and nothing typed into the number field is left to it."""
    line, standard = field.lineEdit(), QKeySequence.StandardKey
    if event.matches(standard.Undo):
        return not line.isUndoAvailable()
    return event.matches(standard.Redo) and not line.isRedoAvailable()
