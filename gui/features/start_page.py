"""Start page: shown in place of the images while no frame is open, with what can be opened."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QIcon, QPainter, QPixmap, QResizeEvent, QShowEvent
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QListWidget,
    QListWidgetItem,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.installation import asset_path
from ilf.errors import InputError
from ilf.project.archive import Archive
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import list_frames

from ..base import theme
from ..base.paths import contains_frames
from ..widgets.basics import (
    TEXT_BESIDE_ICON,
    Message,
    PlainLabel,
    Themed,
    add_layout,
    command_button,
    lay_out,
    literal_text,
)
from .context import Context, Feature
from .documents.feature import DocumentsFeature
from .documents.recent import Origin, key_of, name_of
from .frame_list.thumbnails import Thumbnails, read_thumbnail, stored_thumbnail

_WIDTH, _MARGIN = 720, 16
_PICTURE, _NO_PICTURE, _LOGO = QSize(160, 120), QSize(64, 64), QSize(56, 56)
_SLACK = 4
"""Height [px] that the list needs beyond its entries."""
_MOST = 8
"""Maximum number of what is listed."""
_COMMANDS = "open", "open_sample"
_NAME, _PURPOSE = "ILF Studio", "Complete the missing depth of RGB-D frames, and watch it converge."
_DROP = "Or drop images, a folder of frames, a recording or a project anywhere in this window."
_ORIGIN = Qt.ItemDataRole.UserRole


class StartPage(Themed, QWidget):
    """The program's name and purpose, commands that open something, and what was opened last, with thumbnails.

    Parameters
    ----------
    actions : iterable of QAction
    open : callable
        Opens an `Origin` again.

    Signals
    -------
    shown()
        The page has become visible.
    """

    shown = Signal()

    def __init__(self, actions: Iterable[QAction], open: Callable[[Origin], object]) -> None:
        super().__init__()
        buttons = QGridLayout()
        buttons.setSpacing(8)
        for number, action in enumerate(actions):
            button = command_button(action, TEXT_BESIDE_ICON)
            button.setIconSize(QSize(20, 20))
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setMinimumHeight(36)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            buttons.addWidget(button, *divmod(number, 2))
            if number == 0:
                self.setFocusProxy(button)
        self.title = PlainLabel("Recent")
        self.recent = QListWidget()
        self.recent.setAccessibleName("Recent frames and projects")
        self.recent.setViewMode(QListWidget.ViewMode.IconMode)
        self.recent.setMovement(QListWidget.Movement.Static)
        self.recent.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.recent.setIconSize(_PICTURE)
        self.recent.setUniformItemSizes(True)
        self._bar_width = self.recent.verticalScrollBar().sizeHint().width() + 1
        """Width that the list leaves for its scroll bar."""
        width = (_WIDTH - 2 * _MARGIN - self._bar_width) // 4
        self._cell = QSize(width, _PICTURE.height() + 2 * self.fontMetrics().height() + 8)
        self.recent.setFrameShape(QListWidget.Shape.NoFrame)
        self.recent.viewport().setAutoFillBackground(False)
        self.recent.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        for chosen in (self.recent.itemClicked, self.recent.itemActivated):
            chosen.connect(lambda item: open(item.data(_ORIGIN)))
        self._message = Message()
        self._message.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._message.show_message(_DROP)
        middle = QWidget()
        middle.setMaximumWidth(_WIDTH)
        column = lay_out(
            QVBoxLayout(middle), None, _heading(), margins=(_MARGIN, _MARGIN, _MARGIN, _MARGIN), spacing=12
        )
        column.addSpacing(12)
        add_layout(column, buttons)
        column.addWidget(self._message)
        column.addSpacing(12)
        column.addWidget(self.title)
        column.addWidget(self.recent, 100)
        column.addStretch(1)
        row = QHBoxLayout(self)
        row.addStretch(1)
        row.addWidget(middle, 100)
        row.addStretch(1)
        self._take_theme()

    @cached_property
    def thumbnails(self) -> Thumbnails:
        thumbnails = Thumbnails(self)
        thumbnails.arrived.connect(self._take_theme)
        return thumbnails

    def show_recent(self, origins: Iterable[Origin]) -> None:
        """List what can be opened again."""
        self.recent.clear()
        for origin in origins:
            item = QListWidgetItem(name_of(origin), self.recent)
            item.setToolTip(literal_text(key_of(origin)))
            item.setData(_ORIGIN, origin)
            item.setSizeHint(self._cell)
        self._take_theme()
        for widget in (self.title, self.recent):
            widget.setVisible(self.recent.count() > 0)
        self._limit_height()

    def _limit_height(self) -> None:
        """Limit the list to its rows, so that the page is in the middle."""
        columns = max((self.recent.width() - self._bar_width) // self._cell.width(), 1)
        self.recent.setMaximumHeight(-(-self.recent.count() // columns) * self._cell.height() + _SLACK)

    def _take_theme(self) -> None:
        """Draw the thumbnails, or an icon where there is none."""
        none = theme.icon("ph.image").pixmap(_NO_PICTURE, QIcon.Mode.Disabled)
        for item in map(self.recent.item, range(self.recent.count())):
            origin = item.data(_ORIGIN)
            picture = self.thumbnails.of(key_of(origin), partial(_picture_of, origin))
            item.setIcon(_centred(none if picture is None or picture.isNull() else picture))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._limit_height()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if not event.spontaneous():  # not when a minimised window is shown again
            self.setFocus()
        self.shown.emit()


def _centred(picture: QPixmap) -> QIcon:
    """A picture in the middle of the space for pictures, so that the names of a row are at one height."""
    space = QPixmap(_PICTURE.scaled(picture.size().expandedTo(_PICTURE), Qt.AspectRatioMode.KeepAspectRatioByExpanding))
    space.fill(Qt.GlobalColor.transparent)
    area = picture.rect()
    area.moveCenter(space.rect().center())
    painter = QPainter(space)
    painter.drawPixmap(area, picture)
    painter.end()
    return QIcon(space)


def _heading() -> QHBoxLayout:
    """The program's icon and name, and what it is for."""
    logo = PlainLabel()
    logo.setPixmap(QIcon(str(asset_path("icons/ilf-studio.png"))).pixmap(_LOGO))
    name, purpose = PlainLabel(_NAME), Message()
    font = name.font()
    font.setPointSizeF(2 * font.pointSizeF())
    font.setBold(True)
    name.setFont(font)
    purpose.show_message(_PURPOSE)
    text = lay_out(QVBoxLayout(), name, purpose, spacing=0)
    return lay_out(QHBoxLayout(), logo, text, spacing=16, stretched=text)


class StartPageFeature(Feature):
    """Shows the start page while no frame is open."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._documents = context.feature(DocumentsFeature)
        self.page = StartPage([context.actions[name] for name in _COMMANDS], self._documents.open_again)
        self.page.shown.connect(self.show)
        context.views.set_empty_page(self.page)

    def show(self) -> None:
        """List what was opened last."""
        self.page.show_recent(self._documents.recent.there()[:_MOST])


def _picture_of(origin: Origin) -> NDArray[np.uint8]:
    """Read the thumbnail of a frame, the first of several, or the first in a project file; raises IlfError if there is
    none."""
    if isinstance(origin, FrameRef):
        return read_thumbnail(
            list_frames(origin.rgb, origin.options).sources[0] if contains_frames(origin.rgb) else origin
        )
    with Archive(origin) as archive:
        for name in archive.names():
            if name.startswith("thumbnails/"):
                return stored_thumbnail(archive.read(name))
    raise InputError(f"{origin} has no thumbnail.")
