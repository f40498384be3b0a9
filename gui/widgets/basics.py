"""Small widgets and functions that the dialogs share."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAction, QActionGroup, QFont, QHelpEvent, QPainter, QPaintEvent, QPalette, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QBoxLayout,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLayout,
    QLineEdit,
    QMenu,
    QPushButton,
    QScrollArea,
    QToolButton,
    QToolTip,
    QTreeWidget,
    QVBoxLayout,
    QWidget,
)
from shiboken6 import invalidate

from ..base import theme

TAKES_FILES = "takes_files"
"""The property of a dialog on which files can be dropped; all others leave them to the window."""

_WINDOW_FRAME = QSize(8, 40)

# Plain text from outside the program: Qt would treat text that looks like HTML as rich text.


class Themed:
    """Mixin, before the class of Qt, of a widget whose own colours and icons are made by `_take_theme`.

    A hidden widget takes another theme when it is shown.
    """

    _theme_is_old = False

    def _take_theme(self) -> None:
        """Apply the theme's colours."""
        raise NotImplementedError

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)  # type: ignore[misc]  # the class of Qt has it
        if event.type() == QEvent.Type.PaletteChange:
            self._theme_is_old = True
            self._renew_theme()

    def showEvent(self, event: QShowEvent) -> None:
        self._renew_theme()
        super().showEvent(event)  # type: ignore[misc]

    def _renew_theme(self) -> None:
        if self._theme_is_old and self.isVisible():  # type: ignore[attr-defined]
            self._theme_is_old = False
            self._take_theme()


class PlainLabel(QLabel):
    """A label for plain text, such as names, paths and notes. Use QLabel only for rich text."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.setTextFormat(Qt.TextFormat.PlainText)


class ElidedLabel(PlainLabel):
    """A label of one line that takes no more than the room left: a longer text has "…", and is its tool tip."""

    def __init__(self, mode: Qt.TextElideMode = Qt.TextElideMode.ElideRight) -> None:
        super().__init__()
        self._mode = mode
        self.setMinimumWidth(1)

    def paintEvent(self, event: QPaintEvent) -> None:
        text = self.fontMetrics().elidedText(self.text(), self._mode, self.width())
        place = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        role = self.foregroundRole()
        self.style().drawItemText(
            QPainter(self), self.rect(), place.value, self.palette(), self.isEnabled(), text, role
        )

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip and not self.toolTip():
            is_cut = self.fontMetrics().horizontalAdvance(self.text()) > self.width()
            QToolTip.showText(event.globalPos(), literal_text(self.text()) if is_cut else "", self)
            return True
        return super().event(event)


def literal_text(text: str) -> str:
    """Return text for message boxes and tool tips that Qt shows literally: escaped if it looks like rich text."""
    if "<" not in text and "&lt;" not in text:
        return text
    return f'<p style="white-space: pre-wrap">{html.escape(text)}</p>'


_FLAGS = re.compile(r" \((command line: )?--[^()]*\)")


def without_flags(text: str) -> str:
    """Return a text of the library without the options of the command line that it names in brackets."""
    return _FLAGS.sub("", text)


class Message(PlainLabel):
    """A label with wrapped text in one of the theme's colours."""

    def __init__(self, lines: int = 1) -> None:
        super().__init__()
        self._tone = "muted"
        self.setWordWrap(True)
        self.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        self.setMinimumHeight(lines * self.fontMetrics().lineSpacing())
        self._paint()

    def show_message(self, text: str, tone: str = "muted") -> None:
        """Show `text` in the colour named `tone` in `theme.Colours`."""
        # long paths have no spaces to wrap at
        self.setText(without_flags(text).replace("/", "/\u200b"))
        self._tone = tone
        self._paint()

    def tone(self) -> str:
        """Return the name of the current colour."""
        return self._tone

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        # a new application style sheet also resets the label's own palette
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.StyleChange):
            self._paint()

    def _paint(self) -> None:
        palette = QPalette()
        palette.setColor(QPalette.ColorRole.WindowText, getattr(theme.colours(palette), self._tone))
        self.setPalette(palette)


def group(title: str) -> tuple[QGroupBox, QVBoxLayout]:
    """Return a titled box and the column layout in it."""
    box = QGroupBox(title)
    return box, lay_out(QVBoxLayout(box), margins=(12, 10, 12, 12), spacing=8)


Box = TypeVar("Box", bound=QBoxLayout)
Piece = QWidget | QLayout


def lay_out(
    box: Box,
    *parts: Piece | None,
    stretched: Piece | tuple[Piece, ...] = (),
    margins: tuple[int, int, int, int] = (0, 0, 0, 0),
    spacing: int | None = None,
) -> Box:
    """Fill a row or column, and return it; `None` is a space that takes the room left, as `stretched` parts do."""
    box.setContentsMargins(*margins)
    if spacing is not None:
        box.setSpacing(spacing)
    growing = stretched if isinstance(stretched, tuple) else (stretched,)
    for part in parts:
        stretch = int(any(part is one for one in growing))
        if part is None:
            box.addStretch(1)
        elif isinstance(part, QWidget):
            box.addWidget(part, stretch)
        else:
            add_layout(box, part, stretch)
    return box


def add_layout(box: QBoxLayout, part: QLayout, stretch: int = 0) -> None:
    """Add a layout to a row or column, without what PySide remembers of its items (PySide 6.11): it would take what is
    later allocated at the address of a deleted one for that item, which crashes."""
    box.addLayout(part, stretch)
    _forget_items(part)


def _forget_items(layout: QLayout) -> None:
    for place in range(layout.count()):
        item = layout.itemAt(place)
        inner = None if item is None else item.layout()
        if inner is not None:
            _forget_items(inner)
        elif item is not None:
            invalidate(item)


class Late(QWidget):
    """A place whose content is made when it is first shown."""

    def __init__(self, make: Callable[[], QWidget]) -> None:
        super().__init__()
        self._make = make

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self.layout() is None:
            content = self._make()
            content.setMinimumHeight(self.minimumHeight())
            lay_out(QVBoxLayout(self), content, spacing=0)
            self.setFocusProxy(content)
            content.show()


def stack(parent: QWidget, *parts: Piece, stretched: QWidget | None = None, spacing: int = 10) -> None:
    """Lay out the parts of a dialog one above the other; the space left is that of `stretched`, or above the last."""
    space = () if stretched is not None else (None,)
    column, margins = QVBoxLayout(parent), (14, 14, 14, 14)
    lay_out(column, *parts[:-1], *space, parts[-1], stretched=stretched or (), margins=margins, spacing=spacing)


def scrolled(content: QWidget) -> QScrollArea:
    """Return an area that scrolls its content up and down where it has no room, and is as wide as the content."""
    area = QScrollArea()
    area.setWidget(content)
    area.setWidgetResizable(True)
    for part in (area.viewport(), content):  # the background is that of what is around it
        part.setAutoFillBackground(False)
    area.setFrameShape(QScrollArea.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # what it contains has the focus
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setMinimumWidth(content.minimumSizeHint().width() + area.verticalScrollBar().sizeHint().width())
    return area


def give_size(dialog: QDialog, width: int, height: int) -> None:
    """Give a dialog its first size, or what the screen has room for beside the window's frame."""
    room = dialog.screen().availableSize() - _WINDOW_FRAME
    dialog.resize(QSize(width, height).boundedTo(room))


def page(*parts: Piece) -> QWidget:
    """Return a page of a panel: its parts one above the other, of which the last takes the space left."""
    page = QWidget()
    lay_out(QVBoxLayout(page), *parts, stretched=parts[-1], margins=(8, 6, 4, 4), spacing=6)
    return page


def row(*widgets: QWidget) -> QHBoxLayout:
    """Return widgets side by side: a text field takes the space left; without one, it is on the right."""
    fields = tuple(widget for widget in widgets if isinstance(widget, QLineEdit))
    return lay_out(QHBoxLayout(), *widgets, *(() if fields else (None,)), stretched=fields, spacing=8)


def form(*rows: tuple[str | PlainLabel, Piece], parent: QWidget | None = None) -> QFormLayout:
    """Return labelled fields below each other, which take the width."""
    form = QFormLayout(parent)
    form.setContentsMargins(0, 0, 0, 0)
    form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
    for label, field in rows:
        form.addRow(label, field)
    return form


def answers(
    dialog: QDialog, kind: QDialogButtonBox.StandardButton, text: str = "", hint: str = ""
) -> tuple[QDialogButtonBox, QPushButton]:
    """Return the buttons that accept a dialog, and cancel it, and the one that accepts it."""
    box = QDialogButtonBox(kind | QDialogButtonBox.StandardButton.Cancel)
    box.accepted.connect(dialog.accept)
    box.rejected.connect(dialog.reject)
    button = box.button(kind)
    button.setText(text or button.text())
    button.setToolTip(hint)
    return box, button


def open_once(dialog: QDialog, accepted: Callable[[], object] = lambda: None) -> None:
    """Open a dialog, which is deleted when it is closed; call `accepted` if the user accepts it."""
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.accepted.connect(accepted)
    dialog.open()


TEXT, TEXT_BESIDE_ICON = Qt.ToolButtonStyle.ToolButtonTextOnly, Qt.ToolButtonStyle.ToolButtonTextBesideIcon


def command_button(action: QAction, style: Qt.ToolButtonStyle = Qt.ToolButtonStyle.ToolButtonIconOnly) -> QToolButton:
    """Return a button of a command; without a text it is flat, which shows whether it is switched on."""
    button = QToolButton(autoRaise=style is Qt.ToolButtonStyle.ToolButtonIconOnly)
    button.setDefaultAction(action)
    button.setToolButtonStyle(style)
    return button


def flat_button(
    hint: str, clicked: Callable[[], object] = lambda: None, text: str = "", name: str = "", icon: str = ""
) -> QToolButton:
    """Return a flat button with a hint, which is also its accessible name if there is no other."""
    button = QToolButton(autoRaise=True)
    button.setText(text)
    if icon:
        button.setIcon(theme.icon(icon))
    button.setToolTip(hint)
    button.setAccessibleName(name or hint)
    button.clicked.connect(clicked)
    return button


def menu_button(menu: QMenu, text: str, hint: str) -> QToolButton:
    """Return a flat button that opens a menu, without Qt's arrow."""
    button = flat_button(hint, text=text)
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    button.setStyleSheet("QToolButton::menu-indicator { image: none; }")
    button.setMenu(menu)
    return button


def add_choices(
    menu: QMenu, texts: Mapping[Any, str], chosen: object, choose: Callable[[Any], object]
) -> dict[Any, QAction]:
    """Add entries to a menu, of which one is checked, and return them by their values; `choose` is given the value of
    one that the user takes."""
    group, actions = QActionGroup(menu), {}
    for value, text in texts.items():
        actions[value] = action = menu.addAction(text)
        action.setCheckable(True)
        action.setChecked(value == chosen)
        action.triggered.connect(lambda _=False, value=value: choose(value))
        group.addAction(action)
    return actions


def combo(texts: Mapping[Any, str] | Sequence[str], hint: str = "", name: str = "") -> QComboBox:
    """Return a list of values, shown by their texts; the values of a sequence are its indices."""
    box = QComboBox()
    box.setToolTip(hint)
    box.setAccessibleName(name)
    for value, text in texts.items() if isinstance(texts, Mapping) else enumerate(texts):
        box.addItem(text, value)
    return box


def typed_list() -> QComboBox:
    """Return a list into which other values can be typed; Enter goes on to the default button of the dialog."""
    box = QComboBox(editable=True)
    box.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
    box.setCompleter(None)  # type: ignore[arg-type]  # it would swallow Enter
    return box


def use_even_digits(widget: QWidget) -> None:
    """Give digits one width in a widget, so that changing numbers stay in their place."""
    font = QFont(widget.font())
    font.setFeature(QFont.Tag("tnum"), 1)
    widget.setFont(font)


def label_of(text: str, field: QWidget) -> PlainLabel:
    """Return the label of a field, whose mnemonic moves the focus to it."""
    label = PlainLabel(text)
    label.setBuddy(field)
    return label


def row_list(name: str, hint: str, headers: Sequence[str], stretched: int) -> QTreeWidget:
    """Return a list of rows of text, in which one column takes the space left."""
    rows = QTreeWidget()
    rows.setStyleSheet("QTreeView::item { padding: 3px 0; }")
    rows.setAccessibleName(name)
    rows.setToolTip(hint)
    rows.setHeaderLabels(headers)
    rows.setRootIsDecorated(False)
    rows.setUniformRowHeights(True)
    rows.header().setStretchLastSection(False)
    rows.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    rows.header().setSectionResizeMode(stretched, QHeaderView.ResizeMode.Stretch)
    return rows


# Placeholder text of empty lists.


def paint_hint(view: QAbstractItemView, text: str) -> None:
    """Paint `text` in the middle of a view's empty viewport, and a frame while it has the keyboard focus, for which no
    row stands; call it from the view's paintEvent."""
    painter, colours = QPainter(view.viewport()), theme.colours(view.palette())
    if view.hasFocus():
        painter.setPen(colours.accent)
        painter.drawRect(view.viewport().rect().adjusted(0, 0, -1, -1))
    painter.setPen(colours.muted)
    area = view.viewport().rect().adjusted(16, 8, -16, -8)
    painter.drawText(area, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, text)
    painter.end()
