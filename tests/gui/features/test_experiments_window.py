"""The experiments' window: opened from its menu, runs in a process of its own, shows and saves what comes out."""

from __future__ import annotations

import multiprocessing
import threading
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QTabWidget, QTextBrowser

from gui.app.main_window import MainWindow
from gui.base import theme
from gui.features.experiments.menu import ExperimentsFeature, ExperimentsMenu
from gui.features.experiments.result_view import FigureView, RowTable
from gui.features.experiments.window import ExperimentsWindow
from ilf.lab.experiments.registry import EXPERIMENTS

WAIT_MS = 60_000


@pytest.fixture
def menu(qtbot, tmp_path):
    QSettings().setValue("experiments/folder", str(tmp_path / "results"))
    menu = ExperimentsMenu()
    qtbot.addWidget(menu)
    yield menu
    assert menu.shutdown()
    qtbot.waitUntil(lambda: not multiprocessing.active_children(), timeout=WAIT_MS)


@pytest.fixture
def window(menu) -> ExperimentsWindow:
    return opened(menu, "cylinder")


def opened(menu: ExperimentsMenu, name: str) -> ExperimentsWindow:
    menu.aboutToShow.emit()
    next(action for action in menu.actions() if action.objectName() == f"experiment_{name}").trigger()
    return menu.window_


def said(window: ExperimentsWindow) -> str:
    (box,) = window.findChildren(QMessageBox)
    text = box.text()
    box.close()
    return text


def pages(window: ExperimentsWindow, kind: type) -> list:
    tabs = window.view.tabs
    return [page for page in map(tabs.widget, range(tabs.count())) if isinstance(page, kind)]


def test_menu_has_every_experiment_and_opens_the_chosen_one(menu):
    window = opened(menu, "sphere")
    assert window.isVisible()
    assert window.chosen == "sphere"
    assert [action.objectName() for action in menu.actions()][: len(EXPERIMENTS)] == [
        f"experiment_{name}" for name in EXPERIMENTS
    ]
    assert opened(menu, "limits") is window
    assert window.chosen == "limits"


def test_what_the_menu_needs_is_loaded_beforehand_off_the_guis_thread(menu, qtbot, monkeypatch):
    loaded = []

    def import_module(name):
        loaded.append((name, threading.current_thread()))

    monkeypatch.setattr("gui.features.experiments.menu.import_module", import_module)
    menu._loading.setInterval(0)
    menu.load_soon()
    qtbot.waitUntil(lambda: bool(loaded), timeout=WAIT_MS)
    ((name, thread),) = loaded
    assert name == "ilf.lab.experiments"
    assert thread is not threading.main_thread()


def test_a_quick_run_shows_figures_and_rows_and_can_be_reported(window, qtbot, tmp_path):
    with qtbot.waitSignal(window.runner.ended, timeout=WAIT_MS) as ended:
        window.run_button.click()
        assert not window.run_button.isEnabled()
        assert window.cancel_button.isEnabled()
    assert ended.args == ["finished"]
    assert window.run_button.isEnabled()

    (figure,) = pages(window, FigureView)
    assert figure.readable
    (rows,) = pages(window, RowTable)
    assert rows.model().rowCount() == 42
    rows.sortByColumn(0, rows.horizontalHeader().sortIndicatorOrder().AscendingOrder)
    assert rows.model().index(0, 0).data() == "best"
    headings = [
        rows.model().headerData(column, Qt.Orientation.Horizontal) for column in range(rows.model().columnCount())
    ]
    assert rows.model().index(0, headings.index("defect_rate")).data().endswith(" %")
    (beside,) = pages(window, QTextBrowser)
    assert "preset paper" in beside.toPlainText()
    assert window.list.currentItem().text().startswith("Cylinder")
    assert "quick" in window.list.currentItem().text()

    # what is quick never takes the place of what is full
    assert figure.path.parent == tmp_path / "results" / "quick"
    window.options.set_quick(False)
    assert not pages(window, FigureView)
    window.options.set_quick(True)

    window.write_report(tmp_path / "page.html")
    assert "Cylinder with a growing" in (tmp_path / "page.html").read_text()
    (figure,) = pages(window, FigureView)
    window.save_figure(figure.path, tmp_path / "curves.svg")
    assert (tmp_path / "curves.svg").read_bytes() == figure.path.with_suffix(".svg").read_bytes()
    window.save_figure(figure.path, tmp_path / "missing" / "curves.png")
    assert "missing" in said(window)


def test_figures_fit_the_width_or_are_shown_whole(qtbot, tmp_path):
    Image.fromarray(np.zeros((200, 1000, 3), np.uint8)).save(tmp_path / "wide.png")
    view = FigureView(tmp_path / "wide.png", "Wide.")
    qtbot.addWidget(view)
    view.resize(500, 400)
    view.show()
    fitting = view.paper.width()
    assert 400 < fitting < 500
    view.resize(700, 400)
    assert view.paper.width() == fitting + 200
    view.set_whole(True)
    assert view.paper.width() > 1000


def test_a_caption_stands_below_its_figure(qtbot, tmp_path):
    Image.fromarray(np.zeros((1200, 1000, 3), np.uint8)).save(tmp_path / "tall.png")
    app = QApplication.instance()
    theme.apply_theme(app, "dark")
    pages = QTabWidget()
    qtbot.addWidget(pages)
    pages.resize(930, 760)
    pages.show()
    qtbot.waitExposed(pages)
    view = FigureView(tmp_path / "tall.png", "A caption of some length. " * 12)
    pages.addTab(view, "Figure")
    QTest.qWait(50)
    try:
        assert view._caption.y() > view.paper.geometry().bottom()
    finally:
        app.setStyleSheet("")


@pytest.mark.parametrize(
    ("typed", "kind", "written"),
    [("a", "SVG drawing (*.svg)", "a.svg"), ("b.png", "SVG drawing (*.svg)", "b.png"),
     ("c.pdf", "PNG image (*.png)", "c.pdf.png")],
)  # fmt: skip
def test_a_figure_is_saved_as_the_kind_that_was_chosen(window, tmp_path, monkeypatch, typed, kind, written):
    source = tmp_path / "cylinder-curves.png"
    source.write_bytes(b"png")
    source.with_suffix(".svg").write_bytes(b"svg")
    suggested = []

    def choose(parent, title, start, kinds):
        assert kind in kinds.split(";;")
        suggested.append(Path(start).name)
        return str(tmp_path / typed), kind

    monkeypatch.setattr(QFileDialog, "getSaveFileName", choose)
    window._ask_save_figure(source)
    assert suggested == ["cylinder-curves"]
    assert (tmp_path / written).read_bytes() == written[-3:].encode()
    (tmp_path / written).write_bytes(b"old")
    monkeypatch.setattr(QMessageBox, "question", lambda *_: QMessageBox.StandardButton.No)
    window._ask_save_figure(source)
    # what the dialog itself has asked about is not asked again
    assert ((tmp_path / written).read_bytes() == b"old") == (written != typed)


def test_cancelling_ends_the_process_and_keeps_what_was_done(window, qtbot):
    window.runner.start(["cylinder", "limits"], window.options.settings(), window.options.results_folder())
    qtbot.waitUntil(lambda: window.runner.present == "limits", timeout=WAIT_MS)
    with qtbot.waitSignal(window.runner.ended, timeout=WAIT_MS) as ended:
        window.cancel_button.click()
        assert not window.cancel_button.isEnabled()
    assert ended.args == ["cancelled"]
    qtbot.waitUntil(lambda: not multiprocessing.active_children(), timeout=WAIT_MS)
    assert {path.name.partition(".")[0] for path in window.options.results_folder().glob("*.json")} == {"cylinder"}
    assert window.list.currentItem().text().startswith("Cylinder")
    assert "quick" in window.list.currentItem().text()
    assert window.run_button.isEnabled()


def test_a_run_goes_on_while_its_window_is_closed_and_tells_its_end(menu, window, qtbot):
    said = []
    menu.message.connect(said.append)
    window.run_button.click()
    window.close()
    assert not window.isVisible()
    assert menu.busy
    assert "continue" in said[-1]
    with qtbot.waitSignal(window.runner.ended, timeout=WAIT_MS) as ended:
        pass
    assert ended.args == ["finished"]
    assert said[-1] == "Experiments: finished."
    assert opened(menu, "cylinder") is window
    assert pages(window, FigureView)


def test_closing_the_program_asks_and_ends_the_run(qtbot, tmp_path):
    QSettings().setValue("experiments/folder", str(tmp_path / "results"))
    main = MainWindow(persistent=False)
    qtbot.addWidget(main)
    main.show()
    window = opened(main.feature(ExperimentsFeature).menu, "cylinder")
    window.run_button.click()
    main.close()
    question = main.project.closing.dialog
    assert "experiment" in question.also.text()
    question.reject()
    assert main.isVisible()
    assert window.runner.busy
    main.close()
    main.project.closing.dialog.discard_button.click()
    assert not main.isVisible()
    assert not window.isVisible()
    assert not window.runner.busy
    qtbot.waitUntil(lambda: not multiprocessing.active_children(), timeout=WAIT_MS)


def test_data_and_folders_that_cannot_be_used_are_told(window, qtbot, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    window.choose("table")
    window.options.data.setText(str(empty))
    with qtbot.waitSignal(window.runner.failed, timeout=WAIT_MS):
        window.run_button.click()
    assert str(empty) in said(window)
    assert not window.options.results_folder().exists()

    (tmp_path / "taken").write_text("a file")
    window.choose("cylinder")
    window.options.folder.setText(str(tmp_path / "taken"))
    window.options.folder.editingFinished.emit()
    with qtbot.waitSignal(window.runner.failed, timeout=WAIT_MS):
        window.run_button.click()
    assert "Choose another" in said(window)


def test_a_result_that_cannot_be_read_says_so(window):
    folder: Path = window.options.results_folder()
    folder.mkdir(parents=True)
    (folder / "cylinder.json").write_text("{}")
    window.refresh()
    assert "cannot be read" in window.list.currentItem().text()
    assert window.view.empty.text().endswith("Run the experiment again.")
    assert not window.report_button.isEnabled()
