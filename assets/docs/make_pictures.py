"""Make the pictures of the window and of the tour: `python assets/docs/make_pictures.py`.

Performs the steps of `tour.md` in the real window, with mouse and commands, on the bundled sample, and saves pictures.
The figures that the tour quotes are read from the window; if the text lacks one, the script prints it and exits with
status 1, so text and program stay consistent.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtCore import QEventLoop, QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QPixmap
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QTabWidget, QWidget

from gui.app.main_window import MainWindow
from gui.app.start import ignore_settings
from gui.base import theme
from gui.features.accuracy.hold_out import HoldOutDialog
from gui.features.accuracy.panel import AccuracyPanel
from gui.features.blocks.feature import BlocksFeature
from gui.features.expected_error import ErrorFeature
from gui.features.extraction import ExtractionPanel
from gui.features.sweep.feature import SweepFeature
from gui.work.frame_runs import RunState
from ilf._runtime.installation import asset_path
from ilf.evaluation.evaluation import evaluate_blocks, evaluate_completion
from ilf.evaluation.hold_out import evaluate_hold_out
from ilf.run.run import Run

HERE = Path(__file__).parent
IMAGES = HERE / "images"
PICTURES = IMAGES / "tour"
SIZE = (1440, 900)
_LEFT = Qt.MouseButton.LeftButton
_PATIENCE_S = 60
_QUALITY = 90

SHADE = (545.0, 125.0), (570.0, 125.0), (593.0, 125.0), (596.0, 150.0), (598.0, 171.0), (560.0, 171.0), (529.0, 170.0)
"""Around the lamp shade, nearly [px]."""

BLOCK = 10
"""The lamp with its shade, which the sensor does not see."""
PROFILE = (563.0, 70.0), (563.0, 235.0)
"""From the wall down over the shade to the lamp's foot [px]."""


def pause(milliseconds: int) -> None:
    """Let the window work for a while; the threads, too, which they would not get to do in QTest's own wait."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


class Tour:
    """The window, what is done in it, and the figures that it shows."""

    def __init__(self) -> None:
        ignore_settings()
        self.window = MainWindow(persistent=False)
        self.window.project.discard_silently = True
        self.window.resize(*SIZE)
        self.window.show()
        pause(300)
        self.figures: dict[str, str] = {}

    def wait(self, reached: Callable[[], object]) -> None:
        """Let the window work until something holds, and show it."""
        deadline = time.perf_counter() + _PATIENCE_S
        while not reached():
            if time.perf_counter() > deadline:
                raise TimeoutError("the window has not reached the state of the tour")
            pause(20)
        pause(150)

    def settle(self) -> None:
        """Wait until no work is in progress."""
        runs, errors = self.window.runs, self.window.feature(ErrorFeature)
        pause(300)
        self.wait(lambda: runs.state is RunState.IDLE and not errors.busy)
        pause(1500)

    def open(self) -> None:
        """Open the sample and run it."""
        window, workspace = self.window, self.window.workspace
        window.documents.open_paths([asset_path("samples/room")])
        self.wait(lambda: workspace.shown is not None and workspace.shown.counts() and not window.loader.busy)
        self.do("run")
        self.settle()

    def do(self, *names: str) -> None:
        """Give commands."""
        for name in names:
            self.window.actions_[name].trigger()
            pause(50)

    def place(self, slot: str, x: float, y: float) -> tuple[QWidget, QPoint]:
        """Where a pixel is in a view."""
        view = self.window.views.cells[slot].view
        return view.viewport(), view.transform.map(QPointF(x, y)).toPoint()

    def drag(self, slot: str, *points: tuple[float, float], release: bool = True) -> None:
        """Draw with the left button held, and let go of it."""
        viewport, first = self.place(slot, *points[0])
        QTest.mousePress(viewport, _LEFT, pos=first)
        for point in points[1:]:
            QTest.mouseMove(viewport, self.place(slot, *point)[1])
            pause(20)
        if release:
            QTest.mouseRelease(viewport, _LEFT, pos=self.place(slot, *points[-1])[1])
        pause(100)

    def save(self, path: Path, widget: QWidget | None = None) -> None:
        """Save a picture of the window or of a widget."""
        self.window.notes.clear()
        self.window.refresh.now()
        pixmap: QPixmap = self.window.documents.picture() if widget is None else widget.grab()
        pixmap.save(str(path), quality=_QUALITY if path.suffix == ".jpg" else -1)

    def errors(self) -> tuple[float, float]:
        """RMSE [mm] against the ground truth, of the frame and of the block, over filled pixels."""
        document = self.window.workspace.current
        completion = document.completion()
        assert completion is not None
        whole = evaluate_completion(document.frame, completion)
        block = evaluate_blocks(document.frame, completion, document.labels)[BLOCK]
        assert whole is not None
        assert block is not None
        return 1000 * whole.rmse, 1000 * block.rmse


def main() -> int:
    """Make all pictures; 1 if the text does not have the figures."""
    app = QApplication(sys.argv[:1])
    theme.apply_theme(app, "light")
    PICTURES.mkdir(exist_ok=True)
    show_window(app)
    tour = Tour()
    run_tour(tour)
    tour.window.close()
    text = (HERE / "tour.md").read_text(encoding="utf-8")
    wrong = [f"{what}: {figure}" for what, figure in tour.figures.items() if figure not in text]
    for one in wrong:
        print(f"tour.md does not have this figure: {one}", file=sys.stderr)
    return 1 if wrong else 0


def show_window(app: QApplication) -> None:
    """Make the pictures of window.md."""
    theme.apply_theme(app, "dark")
    dark = Tour()
    dark.open()
    dark.save(IMAGES / "window-dark.png")
    dark.do("layout_correct", "tool_outline")
    dark.settle()
    dark.drag("colour", *SHADE, release=False)
    dark.save(IMAGES / "correct-dark.png")
    dark.do("cancel_stroke")
    dark.window.close()
    theme.apply_theme(app, "light")
    light = Tour()
    light.open()
    light.window.views.sheet.set_layout("grid-extraction")
    panel = light.window.feature(ExtractionPanel).widget
    for tabs in light.window.findChildren(QTabWidget):
        tabs.setCurrentIndex(max(tabs.indexOf(panel), 0))
    light.do("stage_contracted")
    light.settle()
    light.save(IMAGES / "extraction-light.png")
    light.window.centre.show_cloud()
    light.settle()
    light.save(IMAGES / "cloud-light.png")
    light.window.close()


def run_tour(tour: Tour) -> None:
    """Perform the steps of the tour."""
    window, workspace = tour.window, tour.window.workspace
    tour.open()
    document = workspace.current
    whole, block = tour.errors()
    tour.figures |= {"frame": f"{whole:.0f} mm", "block": f"{block:.0f} mm"}

    # which block
    window.panels.reveal("Accuracy")
    workspace.select([BLOCK])
    window.feature(BlocksFeature).table.sortByColumn(_column(window, "Error"), Qt.SortOrder.DescendingOrder)
    tour.settle()
    tour.save(PICTURES / "1-which.jpg")

    # why
    tour.do("layout_inspect")
    tour.settle()
    workspace.select([BLOCK])
    tour.do("zoom_block", "tool_profile")
    pause(300)
    tour.drag("colour", *PROFILE)
    tour.settle()
    tour.save(PICTURES / "2-why.jpg")

    # what helps
    workspace.select([BLOCK])
    window.panels.reveal("Parameters")
    sweep = window.feature(SweepFeature)
    sweep.open("edge_scale")
    sweep.criterion.blocks.setCurrentIndex(1)
    sweep.widget.resize(1000, 640)
    pause(200)
    sweep.start_button.click()
    tour.wait(lambda: not sweep.busy)
    tour.save(PICTURES / "3-sweep.jpg", sweep.widget)
    sweep.apply_button.click()
    sweep.widget.close()
    tour.settle()
    taken = document.parameters_of(BLOCK).edge_scale
    whole, block = tour.errors()
    tour.figures |= {"edge scale": f"{taken:g}", "block, better": f"{block:.0f} mm", "frame, better": f"{whole:.0f} mm"}

    # how it looks now
    tour.save(PICTURES / "4-better.jpg")

    # side by side with the run before
    workspace.current.compare_runs([document.state.runs[0]])
    tour.do("compare_two")
    tour.settle()
    workspace.select([BLOCK])
    tour.do("zoom_block")
    tour.settle()
    tour.save(PICTURES / "5-compare.jpg")

    # on hold-out, as for frames without ground truth
    tour.do("layout_tune")
    tour.settle()
    tour.do("fit")
    workspace.select([BLOCK])
    accuracy = window.feature(AccuracyPanel)
    tour.do("hold_out_test")
    dialog = window.findChild(HoldOutDialog)
    assert dialog is not None
    dialog.accept()
    tour.wait(lambda: document in accuracy.outcomes)
    tour.settle()
    tour.save(PICTURES / "6-hold-out.jpg")
    outcome = accuracy.outcomes[document]
    common = document.state.common.replace(edge_scale=taken)
    everywhere = Run(document.frame, replace(document.blocks, own={}), common)
    completion = evaluate_completion(document.frame, everywhere.complete())
    assert completion is not None
    tour.figures |= {
        "frame, all blocks": f"({1000 * completion.rmse:.0f} mm)",
        "hold-out, all blocks": f"({1000 * evaluate_hold_out(everywhere, outcome.test).whole.rmse:.0f} mm instead of",
        "hold-out, frame": f"{1000 * outcome.errors[0].evaluated[0].rmse:.0f} mm).",
    }


def _column(window: MainWindow, title: str) -> int:
    model = window.feature(BlocksFeature).table.model()
    titles = [
        str(model.headerData(column, Qt.Orientation.Horizontal, Qt.ItemDataRole.DisplayRole))
        for column in range(model.columnCount())
    ]
    return next(column for column, text in enumerate(titles) if text.startswith(title))


if __name__ == "__main__":
    sys.exit(main())
