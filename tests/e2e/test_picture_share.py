"""The pictures have most of the window."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, QRectF
from PySide6.QtWidgets import QApplication

import ilf
from gui.features.blocks.feature import BlocksFeature
from gui.features.frame_list.feature import FramesFeature
from gui.features.layouts import BUILT_IN, CORRECT, STANDARD, LayoutsFeature
from gui.state.document import Document
from gui.views.cell import Cell
from tests.bench.window import settled, wait

BARS = {
    (name, size): 0.65 if name == CORRECT else share
    for name in BUILT_IN
    for size, share in (((1440, 900), 0.52), ((1280, 800), 0.55))
} | {(STANDARD, (1100, 700)): 0.45}
"""Layout, size of window -> minimum share of the pictures; the larger window has the names of the tools."""


def made_frame(number: int = 0) -> ilf.RGBDFrame:
    """160 x 120 pixels with a hole; the number varies it slightly."""
    rows, columns = np.mgrid[:120, :160]
    depth = (1.5 + 0.008 * rows + 0.004 * columns).astype(np.float32)
    depth[25:50, 50:80] = np.nan
    rgb = np.dstack((2 * rows, columns, rows + columns + number)).astype(np.uint8)
    return ilf.RGBDFrame(rgb, depth, name=f"made {number}")


def on_screen(window, cell: Cell) -> QRect:
    """Return the visible part of a cell's picture, in the window."""
    view = cell.view
    height, width = window.workspace.current.frame.shape
    drawn = view.transform.mapRect(QRectF(0, 0, width, height)).toAlignedRect() & view.viewport().rect()
    return drawn.translated(view.viewport().mapTo(window, QPoint()))


def share(window) -> float:
    """Return pixels of pictures over pixels of the window, 0-1."""
    parts = [on_screen(window, cell) for cell in window.views.cells.values() if cell.isVisible()]
    return sum(part.width() * part.height() for part in parts) / (window.width() * window.height())


def show_layout(window, layout: str):
    """Switch to a layout of the window."""
    window.feature(LayoutsFeature).turn(layout)
    for _ in range(5):
        QApplication.processEvents()
    window.refresh.now()


@pytest.mark.usefixtures("themed")
def test_the_picture_is_the_work(window):
    for number in range(2):
        frame = made_frame(number)
        window.workspace.open_document(Document.of(ilf.Run(frame, np.ones(frame.shape, np.int32)), None, frame.name))
    window.actions_["run_all"].trigger()
    wait(lambda: settled(window))
    assert window.feature(FramesFeature).panel.view.isVisible()
    for size in sorted({size for _, size in BARS}):
        window.resize(*size)
        for layout in (layout for layout, of_size in BARS if of_size == size):
            show_layout(window, layout)
            assert share(window) >= BARS[layout, size], (layout, size)
    show_layout(window, CORRECT)
    window.actions_["toggle_panels"].trigger()
    assert window.feature(BlocksFeature).table.isVisible()
