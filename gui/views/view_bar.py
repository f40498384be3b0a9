"""What is shown of the frame: opacity of the blocks and layout, at the side of the views' tab."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QSlider, QToolButton, QWidget

from gui.views.layouts import LAYOUT_TEXTS, LAYOUTS
from gui.views.linked_views import LinkedViews
from gui.widgets.plain_text import PlainLabel

_OPACITY = 45
_SPACE = 6


class ViewBar(QWidget):
    """Slider and box that go with the linked views, and buttons for actions.

    Parameters
    ----------
    views : LinkedViews
    actions : iterable of QAction or None
        A button for each, None for some space.
    """

    def __init__(self, views: LinkedViews, actions: Iterable[QAction | None]) -> None:
        super().__init__()
        self.opacity = QSlider(Qt.Orientation.Horizontal)
        self.opacity.setRange(0, 100)
        self.opacity.setAccessibleName("Opacity of the blocks")
        self.opacity.setFixedWidth(80)
        self.opacity.setToolTip("Opacity of the blocks over the colour image")
        self.opacity.valueChanged.connect(lambda value: views.set_overlay_opacity(value / 100))
        self.opacity.setValue(_OPACITY)
        self.layouts = QComboBox()
        self.layouts.setAccessibleName("Views")
        for name, text in LAYOUT_TEXTS.items():
            self.layouts.addItem(text, name)
        self.layouts.setToolTip("Which views are shown; a double-click on a title shows one large or alone")
        self.layouts.activated.connect(lambda _: views.set_layout(self.layouts.currentData()))
        views.layoutChanged.connect(lambda name: self.layouts.setCurrentIndex(LAYOUTS.index(name)))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 4, 1)
        layout.setSpacing(4)
        self._spare = (PlainLabel("Blocks"), self.opacity)
        for widget in (*self._spare, self.layouts):
            layout.addWidget(widget)
        for action in actions:
            if action is None:
                layout.addSpacing(_SPACE)
                continue
            button = QToolButton()
            button.setAutoRaise(True)
            button.setDefaultAction(action)
            layout.addWidget(button)
        layout.setSizeConstraint(QHBoxLayout.SizeConstraint.SetNoConstraint)
        self._full = layout.sizeHint()
        spare = sum(widget.sizeHint().width() + layout.spacing() for widget in self._spare)
        self._least = self._full - QSize(spare, 0)

    def sizeHint(self) -> QSize:
        return self._full

    def minimumSizeHint(self) -> QSize:
        return self._least

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # in a narrow window the opacity is done without
        for widget in self._spare:
            widget.setVisible(event.size().width() >= self._full.width())
