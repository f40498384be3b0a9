"""The central widget of the window: the images, and the point cloud in its own tab or beside them."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QSplitter, QTabWidget, QVBoxLayout, QWidget

from .cloud.cloud_view import CloudView

_SHARES = 3, 2
"""Initial widths of the images and the cloud, side by side."""


class Centre(QTabWidget):
    """Tabs for the images, with strips below them, and for the cloud; or one tab with both side by side.

    Parameters
    ----------
    views : QWidget
        The images.
    cloud : CloudView

    Signals
    -------
    turned()
        Another tab or arrangement is shown.
    """

    turned = Signal()

    def __init__(self, views: QWidget, cloud: CloudView) -> None:
        super().__init__()
        self.setDocumentMode(True)
        self._cloud = cloud
        self._split = QSplitter(Qt.Orientation.Horizontal)
        self._split.setChildrenCollapsible(False)
        self._split.addWidget(views)
        self.images = QWidget()
        column = QVBoxLayout(self.images)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self._split, 1)
        self._column = column
        self.addTab(self.images, "Images")
        self._add_cloud_tab()
        self.currentChanged.connect(lambda _: self._take_focus())
        self.currentChanged.connect(lambda _: self.turned.emit())

    def set_corner(self, corner: QWidget) -> None:
        """Show a widget beside the tabs, visible only with the images."""
        self.setCornerWidget(corner)
        self.currentChanged.connect(lambda _: corner.setVisible(not self.shows_cloud_alone))

    def add_strip(self, strip: QWidget) -> None:
        """Add a strip below the images."""
        self._column.addWidget(strip)

    @property
    def shows_cloud_alone(self) -> bool:
        """Whether the cloud is visible and the images are not."""
        return self.currentWidget() is self._cloud

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
            self.removeTab(self.indexOf(self._cloud))
            self._split.addWidget(self._cloud)
            for index, share in enumerate(_SHARES):
                self._split.setStretchFactor(index, share)
            whole = max(self.width(), 1)
            self._split.setSizes([whole * share // sum(_SHARES) for share in _SHARES])
            self._cloud.show()
            self.show_images()
        else:
            self._add_cloud_tab()
        self.turned.emit()

    def _take_focus(self) -> None:
        """Focus the cloud when it becomes visible, so that its keys work."""
        if self.shows_cloud_alone:
            self._cloud.setFocus()

    def _add_cloud_tab(self) -> None:
        index = self.addTab(self._cloud, "Point cloud")
        self.setTabToolTip(index, "Depth as a 3D point cloud; the View menu puts it beside the images")
