"""The central widget of the window: the images, and the point cloud in its own tab or beside them."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QHBoxLayout, QSplitter, QStackedWidget, QTabBar, QVBoxLayout, QWidget

from ..widgets.basics import lay_out

_SHARES = 3, 2
"""Initial widths of the images and the cloud, side by side."""


class Centre(QStackedWidget):
    """The images, with strips below them, and the cloud, one of them visible; or both side by side.

    Parameters
    ----------
    views : QWidget
        The images.

    Attributes
    ----------
    tabs : QTabBar
        Selects what is visible; the window shows it elsewhere.

    Signals
    -------
    turned()
        Another tab or arrangement is shown.
    """

    turned = Signal()

    def __init__(self, views: QWidget) -> None:
        super().__init__()
        self._split = QSplitter(Qt.Orientation.Horizontal)
        self._split.setChildrenCollapsible(False)
        self._split.addWidget(views)
        self.images = QWidget()
        self._column = lay_out(QVBoxLayout(self.images), self._split, spacing=0, stretched=self._split)
        self.tabs = QTabBar()
        self.tabs.setDrawBase(False)
        self.tabs.setExpanding(False)
        self.tabs.setDocumentMode(True)
        self.tabs.setAccessibleName("Images or point cloud")
        self.addWidget(self.images)
        self.tabs.addTab("Images")
        self.tabs.currentChanged.connect(self.setCurrentIndex)
        self.currentChanged.connect(self._follow)

    def add_strip(self, strip: QWidget) -> None:
        """Add a strip below the images."""
        self._column.addWidget(strip)

    def add_before(self, strip: QWidget, widget: QWidget) -> None:
        """Add a widget at the left of a strip, or of a widget in its row; it takes at most half of the row."""
        parent = strip.parentWidget()
        layout = None if parent is None else parent.layout()
        if isinstance(layout, QHBoxLayout):
            layout.insertWidget(layout.indexOf(strip), widget)
            return
        row = QWidget()
        self._column.replaceWidget(strip, row)
        lay_out(QHBoxLayout(row), widget, strip, spacing=0, stretched=(widget, strip))

    @property
    def shows_cloud_alone(self) -> bool:
        """Whether the cloud is visible and the images are not."""
        return self.currentWidget() is self._cloud

    def picture(self) -> QPixmap:
        """Return what is shown, without the strips below the images."""
        return (self._cloud if self.shows_cloud_alone else self._split).grab()

    def show_images(self) -> None:
        """Switch to the images if they are hidden."""
        self.setCurrentWidget(self.images)

    def show_cloud(self) -> None:
        """Switch to the cloud if it is hidden."""
        if self.indexOf(self._cloud) >= 0:
            self.setCurrentWidget(self._cloud)

    def set_side_by_side(self, on: bool) -> None:
        """Put the cloud beside the images, or back into its tab; it stays visible."""
        if on:
            self.show_images()
            self.removeWidget(self._cloud)
            self.tabs.removeTab(1)
            self._split.addWidget(self._cloud)
            for index, share in enumerate(_SHARES):
                self._split.setStretchFactor(index, share)
            whole = max(self.width(), 1)
            self._split.setSizes([whole * share // sum(_SHARES) for share in _SHARES])
            self._cloud.show()
        else:
            self.add_cloud(self._cloud)
        self.turned.emit()

    def _follow(self, index: int) -> None:
        self.tabs.setCurrentIndex(index)
        if self.shows_cloud_alone:
            self._cloud.setFocus()  # so that its keys work
        self.turned.emit()

    def add_cloud(self, cloud: QWidget) -> None:
        """Add the point cloud in a tab of its own."""
        self._cloud = cloud
        self.addWidget(cloud)
        index = self.tabs.addTab("Point cloud")
        self.tabs.setTabToolTip(index, "Depth as a 3D point cloud; the View menu puts it beside the images")
