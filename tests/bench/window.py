"""The window in a real event loop, which leaves time to its threads, unlike `processEvents` or QTest's wait."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent, QEventLoop, QTimer

from gui.app.main_window import MainWindow
from gui.app.start import ignore_settings
from gui.features.edit_summary import EditSummaryFeature
from gui.features.expected_error import ErrorFeature
from gui.work.frame_runs import RunState
from ilf.segmentation.editing.painting import brush_stroke, paint

_LIMIT_S = 300


def pause(milliseconds: int) -> None:
    """Run the event loop for a while."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


def wait(reached: Callable[[], object], every_ms: int = 1) -> None:
    """Run the event loop until a condition holds, even for a moment."""
    deadline = time.perf_counter() + _LIMIT_S
    loop, timer = QEventLoop(), QTimer(interval=every_ms)
    holds = False

    def look() -> None:
        nonlocal holds
        holds = bool(reached())
        if holds or time.perf_counter() > deadline:
            loop.quit()

    timer.timeout.connect(look)
    timer.start()
    loop.exec()
    timer.stop()
    if not holds:
        raise TimeoutError("the window did not reach the expected state")


def new_window() -> MainWindow:
    """Open a window that keeps no settings."""
    ignore_settings()
    window = MainWindow(persistent=False)
    window.project.discard_silently = True
    window.resize(1440, 900)
    window.show()
    pause(300)
    return window


def end(window: MainWindow) -> None:
    """Close a window and delete it, and its timers with it."""
    window.close()
    window.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def open_frame(window: MainWindow, folder: Path) -> None:
    """Open a frame, and wait for its blocks."""
    window.documents.open_paths([folder])
    wait(lambda: window.workspace.shown is not None and window.workspace.shown.counts() and not window.loader.busy)


def settled(window: MainWindow) -> bool:
    """Return whether no run, no expected error and no summary of an edit is in progress."""
    busy = any(window.feature(kind).busy for kind in (ErrorFeature, EditSummaryFeature))
    return window.runs.state is RunState.IDLE and not busy


def paint_across(window: MainWindow, label: int) -> None:
    """Paint a stroke of a block across the frame."""
    document = window.workspace.current
    height, width = document.frame.shape
    line = np.array([[0.2 * width, 0.5 * height], [0.8 * width, 0.5 * height]])
    stroke = brush_stroke((height, width), line, 5.0)
    assert stroke is not None
    document.stroke(paint(document.labels, stroke, label, document.locked))
    document.edit(document.drop_stroke(), "Paint")
