"""Share of pictures in the window: `QT_QPA_PLATFORM=offscreen python -m tests.bench.picture_share [FRAME ...]`.

Counts the screen pixels that show the frame, over all pixels of the window, for layouts and sizes of the window at the
first start. Without a frame, one of 640 x 480 pixels is made.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PySide6.QtCore import QPoint, QRect, QRectF, QSettings
from PySide6.QtWidgets import QApplication, QToolButton

import ilf
from gui.app.main_window import MainWindow
from gui.base import theme
from gui.state.session import Session
from gui.views.view_cell import ViewCell

SIZES = ((1280, 800), (1100, 700), (1440, 900), (1920, 1080))
LAYOUTS = ("grid", "grid-difference", "grid-extraction", "row", "correct", "colour")
BARS = {("grid", (1280, 800)): 0.45, ("correct", (1280, 800)): 0.60, ("grid", (1100, 700)): 0.35}
"""Layout, size of window -> minimum share of the pictures."""


def made_frame() -> ilf.RGBDFrame:
    """640 x 480 pixels with a hole."""
    rows, columns = np.mgrid[:480, :640]
    depth = (1.5 + 0.002 * rows + 0.001 * columns).astype(np.float32)
    depth[100:200, 200:320] = np.nan
    rgb = np.dstack((rows % 256, columns % 256, (rows + columns) % 256)).astype(np.uint8)
    return ilf.RGBDFrame(rgb, depth, name="made")


def on_screen(window: MainWindow, cell: ViewCell) -> QRect:
    """Return the visible part of a cell's picture, in the window."""
    view = cell.view
    height, width = window.workspace.session.frame.shape
    drawn = view.viewportTransform().mapRect(QRectF(0, 0, width, height)).toAlignedRect() & view.viewport().rect()
    return drawn.translated(view.viewport().mapTo(window, QPoint()))


def share(window: MainWindow) -> float:
    """Return pixels of pictures over pixels of the window, 0-1."""
    parts = [on_screen(window, cell) for cell in window.views.cells.values() if cell.isVisible()]
    return sum(part.width() * part.height() for part in parts) / (window.width() * window.height())


def cut(window: MainWindow) -> list[str]:
    """Return elements that are cut off but should be fully visible: pictures, captions, the Run button, the rail."""
    wrong = []
    height, width = window.workspace.session.frame.shape
    for name, cell in window.views.cells.items():
        if cell.isVisible():
            drawn = cell.view.viewportTransform().mapRect(QRectF(0, 0, width, height))
            if not QRectF(cell.view.viewport().rect()).adjusted(-0.5, -0.5, 0.5, 0.5).contains(drawn):
                wrong.append(f"picture of {name}")
            if cell.strip.title_end > cell.strip.width():
                wrong.append(f"caption of {name}")
    for what, bar in (("run", window.tool_bar), ("panels", window.panels.rail)):
        for button in bar.findChildren(QToolButton):
            action = button.defaultAction()
            wanted = action is window.actions_["run"] if what == "run" else action is not None and action.isVisible()
            if wanted and not (button.isVisible() and window.rect().contains(_place(window, button))):
                wrong.append(f"button of {what}: {action.text()}")
    return wrong


def _place(window: MainWindow, button: QToolButton) -> QRect:
    return QRect(button.mapTo(window, QPoint()), button.size())


def show_frame(window: MainWindow, frame: ilf.RGBDFrame, size: tuple[int, int], layout: str) -> None:
    """Show a window in a size and layout."""
    window.resize(*size)
    window.show()
    if not window.workspace.has_session:
        window.workspace.add_session(Session(frame, None, frame.name))
    window.views.set_layout(layout)
    for _ in range(5):
        QApplication.processEvents()
    window.refresh.now()


def main() -> int:
    """Print the table; return 1 if a share is too small or something is cut off."""
    app = QApplication(sys.argv[:1])
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, "/nonexistent")
    theme.apply_theme(app, "dark")
    frames = [ilf.load_frame(Path(path)) for path in sys.argv[1:]] or [made_frame()]
    missed = False
    for frame in frames:
        print(f"{frame.name}, {frame.shape[1]} x {frame.shape[0]}")
        for size in SIZES:
            for layout in LAYOUTS:
                window = MainWindow(persistent=False)
                show_frame(window, frame, size, layout)
                found, wrong, bar = share(window), cut(window), BARS.get((layout, size), 0.0)
                missed |= found < bar or bool(wrong)
                wanted = f"  (at least {bar:.0%})" if bar else ""
                print(f"  {size[0]} x {size[1]}  {layout:16} {found:6.1%}{wanted} {f'cut: {wrong}' if wrong else ''}")
                window.close()
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
