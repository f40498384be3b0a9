"""Frame times of the point cloud view: `QT_QPA_PLATFORM=offscreen python -m tests.bench.cloud_frames`.

For frames and views of several sizes: time per rendered frame while the mouse turns the cloud (median and 95 % of a
hundred), time from the last move until the whole cloud is visible, time until new colours are visible, and the longest
time that the window's thread was busy.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt, QTimer
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

import ilf
from gui.app.main_window import MainWindow
from gui.state.session import Session
from gui.views.cloud.cloud_view import CloudView
from gui.views.cloud.colouring import ColourBy
from gui.views.cloud.drawing import IDLE_MS

FRAMES = (640, 480), (1280, 720), (1920, 1080)
VIEWS = (660, 560), (1320, 760), (2560, 1400)
MOVES = 100
WAIT_S = 20.0


def frame_of(width: int, height: int) -> ilf.RGBDFrame:
    """A wavy, noisy surface with a jump, without missing depth."""
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    noise = np.random.default_rng(0).normal(0, 0.004, (height, width))
    waves = 0.8 * np.sin(9 * columns / width) * np.cos(7 * rows / height)
    depth = (2 + waves + noise + 0.7 * (columns > width / 2)).astype(np.float32)
    rgb = np.stack([columns % 256, rows % 256, (columns + rows) % 256], axis=-1).astype(np.uint8)
    lens = ilf.CameraIntrinsics(0.9 * width, 0.9 * width, width / 2, height / 2)
    return ilf.RGBDFrame(rgb, depth, lens, name=f"{width} x {height}")


class Held:
    """Measures the longest time [s] that this thread worked between two turns of the event loop."""

    def __init__(self) -> None:
        self.longest = 0.0
        self._last = time.thread_time()
        self._timer = QTimer(interval=1)
        self._timer.timeout.connect(self._tick)
        self._timer.start()

    def _tick(self) -> None:
        now = time.thread_time()
        self.longest, self._last = max(self.longest, now - self._last), now


def wait(until: Callable[[], bool]) -> float:
    """Run the event loop until a condition holds; return the time [s]."""
    begun = time.perf_counter()
    while not until():
        QApplication.processEvents()
        time.sleep(0.001)  # gives time to other threads
        if time.perf_counter() - begun > WAIT_S:
            raise TimeoutError("the cloud is not complete")
    return time.perf_counter() - begun


def turn(cloud: CloudView, place: QPointF) -> float:
    """Drag to a point and paint; return the time [s]."""
    canvas, left, none = cloud.canvas, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    event = QMouseEvent(QEvent.Type.MouseMove, place, canvas.mapToGlobal(place), left, left, none)
    begun = time.perf_counter()
    QApplication.sendEvent(canvas, event)
    canvas.repaint()
    return time.perf_counter() - begun


def measure(window: MainWindow, frame: ilf.RGBDFrame, view: tuple[int, int]) -> str:
    """Print one line of the table."""
    cloud, canvas = window.cloud, window.cloud.canvas
    canvas.setFixedSize(*view)
    QApplication.processEvents()
    window.workspace.add_session(Session(frame, frame.name, f"{frame.name} {view}"))
    appeared = wait(lambda: len(canvas.scene) == frame.depth.size)
    wait(lambda: canvas.drawing.is_full)
    held = Held()
    start = QPointF(view[0] / 2, view[1] / 2)
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=start.toPoint())
    times = []
    for move in range(3, MOVES):
        times.append(turn(cloud, start + QPointF(3 * move, 20 * np.sin(move / 9))))
        QApplication.processEvents()
    settled = wait(lambda: canvas.drawing.is_full)
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton)
    cloud.set_colour_by(ColourBy.DEPTH)
    before = canvas.scene
    coloured = wait(lambda: canvas.scene is not before and canvas.drawing.is_full)
    cloud.set_colour_by(ColourBy.COLOUR)
    median, most = (1000 * float(np.percentile(times, share)) for share in (50, 95))
    window.workspace.frames.close(window.workspace.session)
    return (
        f"{frame.name:>12}  {view[0]:>4} x {view[1]:<4}  {median:6.1f} {most:6.1f}  {1000 * settled:6.0f}  "
        f"{1000 * appeared:6.0f}  {1000 * coloured:6.0f}  {1000 * held.longest:6.0f}"
    )


def main() -> None:
    """Print the table; times in ms. The time to the whole cloud includes the delay of `IDLE_MS`."""
    application = QApplication.instance() or QApplication([])
    window = MainWindow(persistent=False)
    window.show()
    window.centre.show_cloud()
    print(f"times in ms; drawing of the whole cloud starts {IDLE_MS} ms after the last move")
    print("       frame         view  moving   95 %   whole  appears  colours  longest held")
    for size in FRAMES:
        frame = frame_of(*size)
        for view in VIEWS:
            print(measure(window, frame, view), flush=True)
    window.close()
    application.processEvents()


if __name__ == "__main__":
    main()
