"""The experiments' window: opened from its menu, runs in a process of its own, shows and saves what comes out."""

from __future__ import annotations

import multiprocessing
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QMessageBox

from gui.experiments.figure_view import FigureView
from gui.experiments.menu import ExperimentsMenu
from gui.experiments.rows import RowTable
from gui.experiments.window import ExperimentsWindow
from gui.main_window import MainWindow
from ilf.experiments import EXPERIMENTS

WAIT_MS = 60_000


@pytest.fixture
def menu(qtbot, tmp_path):
    QSettings().setValue("experiments/folder", str(tmp_path / "results"))
    menu = ExperimentsMenu()
    qtbot.addWidget(menu)
    yield menu
    assert menu.shutdown()
    assert not multiprocessing.active_children()


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


def test_cancelling_ends_the_process_and_keeps_what_was_done(window, qtbot):
    window.choose("limits")
    window.run_button.click()
    qtbot.waitUntil(lambda: window.runner.present == "limits", timeout=WAIT_MS)
    with qtbot.waitSignal(window.runner.ended, timeout=WAIT_MS) as ended:
        window.cancel_button.click()
        assert not window.cancel_button.isEnabled()
    assert ended.args == ["cancelled"]
    assert not multiprocessing.active_children()
    assert not list(window.options.results_folder().iterdir())
    assert window.run_button.isEnabled()


def test_closing_the_window_ends_the_run_and_it_can_be_opened_again(menu, window):
    window.run_button.click()
    window.close()
    assert not window.runner.busy
    assert not multiprocessing.active_children()
    assert opened(menu, "cylinder") is window
    assert window.run_button.isEnabled()
    assert not window.state.isVisible()


def test_closing_the_program_ends_the_run(qtbot, tmp_path):
    QSettings().setValue("experiments/folder", str(tmp_path / "results"))
    main = MainWindow(remembers=False)
    qtbot.addWidget(main)
    main.show()
    window = opened(main.experiments, "cylinder")
    window.run_button.click()
    main.close()
    assert not window.isVisible()
    assert not window.runner.busy
    assert not multiprocessing.active_children()


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
