"""Start page: shown in place of the images while no frame is open, with what can be opened."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QIcon, QImage, QPainter, QPixmap, QResizeEvent, QShowEvent
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
from ilf.errors import IlfError
from ilf.project.archive import Archive
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import list_frames

from ..base import theme
from ..project.loading import contains_frames
from ..views.pixel_items import rgb_image
from ..widgets.basics import TEXT_BESIDE_ICON, Message, PlainLabel, Themed, command_button, lay_out, literal_text
from ..work.jobs import Worker
from .context import Context, Feature
from .documents.feature import DocumentsFeature
from .frame_list.thumbnails import read_thumbnail, stored_thumbnail
from .project.feature import ProjectFeature
from .project.recent import Origin, is_missing, key_of, name_of

_WIDTH, _MARGIN = 720, 16
_PICTURE, _NO_PICTURE, _LOGO = QSize(160, 120), QSize(64, 64), QSize(56, 56)
_SLACK = 4
"""Height [px] that the list needs beyond its entries."""
_MOST_PROJECTS, _MOST = 4, 8
"""Maximum number of projects, and of all that is listed."""
_COMMANDS = "open", "open_sample"
_NAME, _PURPOSE = "ILF Studio", "Complete the missing depth of RGB-D frames, and watch it converge."
_DROP = "Or drop images, a folder of frames, a recording or a project anywhere in this window."
_ORIGIN = Qt.ItemDataRole.UserRole


class StartPage(Themed, QWidget):
    """The program's name and purpose, commands that open something, and what was opened last, with thumbnails.

    Signals
    -------
    chosen(object)
        What the user wants to open again, an `Origin`.
    shown()
        The page has become visible.
    """

    chosen = Signal(object)
    shown = Signal()

    def __init__(self, actions: Iterable[QAction]) -> None:
        super().__init__()
        self.pictures: dict[str, QPixmap] = {}
        """Key of what was opened -> its thumbnail, an empty one where there is none."""
        buttons = QGridLayout()
        buttons.setSpacing(8)
        for number, action in enumerate(actions):
            button = command_button(action, TEXT_BESIDE_ICON)
            button.setIconSize(QSize(20, 20))
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setMinimumHeight(36)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            buttons.addWidget(button, *divmod(number, 2))
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
        self.recent.itemClicked.connect(self._choose)
        self.recent.itemActivated.connect(self._choose)
        self._message = Message()
        self._message.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._message.show_message(_DROP)
        middle = QWidget()
        middle.setMaximumWidth(_WIDTH)
        column = lay_out(
            QVBoxLayout(middle), None, _heading(), margins=(_MARGIN, _MARGIN, _MARGIN, _MARGIN), spacing=12
        )
        column.addSpacing(12)
        column.addLayout(buttons)
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

    def show_picture(self, key: str, picture: QPixmap) -> None:
        """Show the thumbnail of what has this key."""
        self.pictures[key] = picture
        self._take_theme()

    def _choose(self, item: QListWidgetItem) -> None:
        self.chosen.emit(item.data(_ORIGIN))

    def _limit_height(self) -> None:
        """Limit the list to its rows, so that the page is in the middle."""
        columns = max((self.recent.width() - self._bar_width) // self._cell.width(), 1)
        self.recent.setMaximumHeight(-(-self.recent.count() // columns) * self._cell.height() + _SLACK)

    def _take_theme(self) -> None:
        """Draw the thumbnails, or an icon where there is none."""
        none = theme.icon("ph.image", self.palette()).pixmap(_NO_PICTURE, QIcon.Mode.Disabled)
        for item in map(self.recent.item, range(self.recent.count())):
            picture = self.pictures.get(key_of(item.data(_ORIGIN)), none)
            item.setIcon(_centred(none if picture.isNull() else picture))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._limit_height()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
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
    """Shows the start page while no frame is open, and makes its thumbnails in the background."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._projects, self._frames = context.feature(ProjectFeature).recent, context.feature(DocumentsFeature).recent
        self._listed: list[Origin] = []
        self.page = StartPage([context.actions[name] for name in _COMMANDS])
        self.page.chosen.connect(self._open)
        self.page.shown.connect(self.show)
        self._worker = Worker(self)
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda _: self._make_missing())

    def begin(self) -> None:
        """Put the page into its place."""
        self.context.views.set_empty_page(self.page)

    def show(self) -> None:
        """List what was opened last, the projects first, and make the missing thumbnails."""
        projects, frames = (
            [origin for origin in menu.origins if not is_missing(origin)] for menu in (self._projects, self._frames)
        )
        self._listed = [*projects[:_MOST_PROJECTS], *frames][:_MOST]
        self.page.show_recent(self._listed)
        self._make_missing()

    def _make_missing(self) -> None:
        missing = [origin for origin in self._listed if key_of(origin) not in self.page.pictures]
        if missing and not self._worker.busy:
            self._worker.start(lambda: _pictures(missing))

    def _take(self, batch: list[tuple[str, QImage]]) -> None:
        for key, image in batch:
            self.page.show_picture(key, QPixmap.fromImage(image))

    def _open(self, origin: Origin) -> None:
        (self._projects if origin in self._projects.origins else self._frames).open(origin)


def _pictures(origins: Iterable[Origin]) -> Generator[tuple[str, QImage], None, None]:
    """Make thumbnails, empty ones where there is none; runs in a worker thread."""
    for origin in origins:
        image = QImage()
        with suppress(IlfError, OSError, cv2.error):
            if isinstance(origin, FrameRef):
                first = list_frames(origin.rgb, origin.options).sources[0] if contains_frames(origin.rgb) else origin
                image = rgb_image(read_thumbnail(first))
            elif (picture := _picture_in(origin)) is not None:
                image = rgb_image(picture)
        yield key_of(origin), image


def _picture_in(project: Path) -> NDArray[np.uint8] | None:
    """Return the first thumbnail in a project file, None if there is none; IlfError if it is no project file."""
    with Archive(project) as archive:
        name = next((name for name in archive.names() if name.startswith("thumbnails/")), None)
        return None if name is None else stored_thumbnail(archive.read(name))
