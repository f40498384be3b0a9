"""Keys of the tools, which work wherever the focus is in the window."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QDockWidget, QLineEdit, QPlainTextEdit, QTextEdit, QWidget
from shiboken6 import isValid

from ..views.image_view import ImageView
from ..views.interaction import ARROWS
from ..views.linked_views import LinkedViews
from .crosshair import Crosshair
from .editor import Editor

_Modifier = Qt.KeyboardModifier
_PLAIN = _Modifier.NoModifier
_Key = Qt.Key
_BY_KEYS = (
    Qt.FocusReason.TabFocusReason,
    Qt.FocusReason.BacktabFocusReason,
    Qt.FocusReason.ShortcutFocusReason,
)


class ToolKeys(QObject):
    """Event filter for the keys of the tools: Enter finishes, Backspace removes the last part, Ctrl+Z cancels a stroke;
    other keys switch an action on while held (`hold`). In a view, arrows move the crosshair, and Space or Enter clicks
    there; after the mouse was moved, Space pans.

    They work in the whole window and its panels, but not in text and number fields and not in dialogs, and only when
    they have an effect. During keyboard navigation in the panels, Space works as usual. When a focused part of the
    window is hidden, the views get the focus.
    """

    def __init__(self, window: QWidget, editor: Editor, views: LinkedViews) -> None:
        super().__init__(window)
        self._held: dict[int, QAction] = {}
        self._finishers: list[Callable[[], bool]] = []
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

    def hold(self, key: Qt.Key, action: QAction) -> None:
        """Check an action while a key is held."""
        self._held[key] = action

    def on_enter(self, finish: Callable[[], bool]) -> None:
        """Call a function when Enter is pressed and the tool has nothing to finish; it returns whether it did
        anything."""
        self._finishers.append(finish)

    def _focus_changed(self, old: QWidget | None, new: QWidget | None) -> None:
        """Filter the events of the focused widget; a filter of the program would be called for each of its events.

        Qt gives the focus of a hidden widget to any other one, a list of frames for example: the views take it."""
        if new is None:
            return
        new.installEventFilter(self)
        if isinstance(new, ImageView):
            self._views.activate(new)
            if self._keyboard_focus and self._editor.ready:
                self.crosshair.show()
            self._keyboard_focus = False
        elif self._was_hidden(old) and self._views.isVisible() and self._belongs(new):
            self._views.active.view.setFocus()

    def _was_hidden(self, old: QWidget | None) -> bool:
        """Whether a part of the window lost the focus because it was hidden."""
        return old is not None and isValid(old) and not old.isVisible() and self._belongs(old)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle the keys of the tools. Called for every event of the widgets that have had the focus."""
        if isinstance(event, QKeyEvent):
            return self._take(watched, event)
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
        if key not in (_Key.Key_Return, _Key.Key_Enter):
            return False
        if modifiers == _PLAIN and (editor.finish() or any(finish() for finish in self._finishers)):
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
