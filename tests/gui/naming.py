"""Which controls of a window have no name that could be read out."""

from collections.abc import Iterator

from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QGraphicsView,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QProgressBar,
    QScrollBar,
    QTabBar,
    QTextEdit,
    QWidget,
)

_CONTROLS = (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QGraphicsView,
    QKeySequenceEdit,
    QLineEdit,
    QPlainTextEdit,
    QProgressBar,
    QTextEdit,
)
_WITH_PARTS = (QAbstractSpinBox, QComboBox, QHeaderView, QKeySequenceEdit, QLineEdit, QTabBar)
"""What is named as a whole: its parts are Qt's own."""


def unnamed(window: QWidget) -> list[str]:
    """The controls without a name, a text or a label of their own, each with where it stands."""
    buddies = {label.buddy() for label in window.findChildren(QLabel) if label.text()}
    return [_where(control) for control in _controls(window) if control not in buddies and not _has_name(control)]


def _controls(window: QWidget) -> Iterator[QWidget]:
    for widget in window.findChildren(QWidget):
        own = widget.objectName().startswith("qt_") or isinstance(widget, (QScrollBar, QHeaderView))
        if isinstance(widget, _CONTROLS) and not own and not _is_part(widget):
            yield widget


def _is_part(widget: QWidget) -> bool:
    parent = widget.parentWidget()
    while parent is not None:
        corner = isinstance(parent, QAbstractItemView) and isinstance(widget, QAbstractButton)
        if isinstance(parent, _WITH_PARTS) or corner:
            return True
        parent = parent.parentWidget()
    return False


def _has_name(control: QWidget) -> bool:
    text = control.text() if isinstance(control, QAbstractButton) else ""
    return bool(control.accessibleName() or text)


def _where(widget: QWidget) -> str:
    steps: list[str] = []
    step: QWidget | None = widget
    while step is not None:
        steps.append(type(step).__name__ + (f"#{step.objectName()}" if step.objectName() else ""))
        step = step.parentWidget()
    return " < ".join(steps[:5])
