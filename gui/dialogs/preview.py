"""A picture of what a dialog is about to open."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QFrame, QVBoxLayout

from gui.views.colour_maps import depth_table
from gui.views.images import rgb_image
from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel
from ilf.drawing.levels import robust_depth_levels, to_indices

_SIZE = QSize(304, 204)


class Preview(QFrame):
    """A picture in a box of fixed size, with its name below."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name
        self.picture = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self.picture.setFixedSize(_SIZE)
        self.picture.setFrameShape(QFrame.Shape.StyledPanel)
        self._caption = Message()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addWidget(self.picture)
        column.addWidget(self._caption)
        self.show_rgb(None)

    def show_rgb(self, rgb: NDArray[np.uint8] | None) -> None:
        """Show uint8 (H, W, 3), or nothing."""
        if rgb is None:
            self.picture.clear()
            self._caption.say(self._name)
            return
        height, width = rgb.shape[:2]
        self._caption.say(f"{self._name}, {width} x {height}")
        self.picture.setPixmap(
            QPixmap.fromImage(rgb_image(rgb)).scaled(
                _SIZE - QSize(4, 4), Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            )
        )

    def show_depth(self, depth: NDArray[np.generic] | None) -> None:
        """Show depth (H, W) in any unit by its colours, missing pixels black, or nothing."""
        if depth is None:
            self.show_rgb(None)
            return
        values = depth.astype(np.float32)
        values[~(values > 0)] = np.nan
        self.show_rgb(depth_table("turbo")[to_indices(values, *robust_depth_levels(values))][..., :3])
