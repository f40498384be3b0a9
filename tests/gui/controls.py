"""The controls that a user sees in a window, and those of them that show no text."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QScrollBar,
    QToolButton,
    QWidget,
)

_KINDS = (QAbstractButton, QComboBox, QAbstractSlider, QAbstractSpinBox, QLineEdit)


def controls(window: QWidget) -> list[QWidget]:
    """Return the buttons, lists, sliders and fields that are on the screen; scroll bars are none."""
    found = (widget for widget in window.findChildren(QWidget) if isinstance(widget, _KINDS))
    return [
        widget
        for widget in found
        if widget.isVisible()
        and not widget.visibleRegion().isEmpty()
        and not isinstance(widget, QScrollBar)
        and not isinstance(widget.parent(), (QComboBox, QAbstractSpinBox))
    ]


def without_text(window: QWidget) -> list[QWidget]:
    """Return the controls that show no text."""
    return [widget for widget in controls(window) if not _text(widget)]


def _text(widget: QWidget) -> str:
    if isinstance(widget, QToolButton):
        icon_only = widget.toolButtonStyle() is Qt.ToolButtonStyle.ToolButtonIconOnly and not widget.icon().isNull()
        return "" if icon_only else widget.text()
    if isinstance(widget, QComboBox):
        return widget.currentText()
    if isinstance(widget, (QAbstractButton, QAbstractSpinBox)):
        return widget.text()
    return widget.text() or widget.placeholderText() if isinstance(widget, QLineEdit) else ""
