"""The expected error in the window: it follows the results, and is worked out only for those who look."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

from gui.features.expected_error import ErrorFeature
from gui.features.filter import FilterPanel
from gui.state.results import ErrorEstimate
from ilf.completion.confidence.expected_error import expected_error
from ilf.segmentation.editing.painting import brush_stroke, erase

from .conftest import readout, settle


def _picture(window):
    return window.views.cells["expected-error"].view.shown


def test_it_comes_after_a_run_and_goes_with_the_results(opened, qtbot, run_all):
    assert _picture(opened) is None
    run_all(opened)
    settle(opened, qtbot)
    document = opened.workspace.current
    completion = document.completion()
    expected = expected_error(completion)
    np.testing.assert_array_equal(_picture(opened) > 0, completion.filled)

    row, column = (int(places[0]) for places in np.nonzero(completion.filled))
    text = readout(opened, (column, row))
    assert "\u00b1" in text
    shown, unit = text.rpartition("\u00b1 ")[2].split()
    metres = float(shown) * {"mm": 0.001, "m": 1.0}[unit]
    assert metres == pytest.approx(float(expected[row, column]), rel=0.06)
    assert "unsupported" not in text
    everything = np.ones(document.frame.shape, bool)
    document.store_error_estimate(completion, ErrorEstimate(expected, everything))
    assert "unsupported" in readout(opened, (column, row))
    known_row, known_column = (int(places[0]) for places in np.nonzero(document.frame.known))
    assert "\u00b1" not in readout(opened, (known_column, known_row))

    opened.actions_["clear_results"].trigger()
    opened.refresh.now()
    assert _picture(opened) is None
    assert "\u00b1" not in readout(opened, (column, row))


def test_after_an_edit_the_former_stays_until_there_is_a_newer(opened, qtbot, run_all):
    run_all(opened)
    settle(opened, qtbot)
    strip = opened.views.cells["expected-error"].strip
    opened.actions_["live"].setChecked(False)
    document = opened.workspace.current
    stroke = brush_stroke(document.labels.shape, [(10, 40)], 3)
    assert opened.workspace.current.edit(erase(document.labels, stroke, document.label_at(10, 40)), "Erase")
    opened.refresh.now()
    assert _picture(opened) is not None
    assert strip._text == "of the previous result"
    opened.actions_["undo"].trigger()
    qtbot.waitUntil(lambda: strip._text == "")


def test_what_cannot_be_found_is_said_once(opened, qtbot, run_all, reported, monkeypatch):
    def fail(*_):
        raise MemoryError("no room")

    monkeypatch.setattr("gui.features.expected_error.expected_error", fail)
    run_all(opened)
    settle(opened, qtbot)
    assert reported == ["Memory has run out (no room). Close other programs, or use a smaller frame."]
    opened.views.sheet.set_layout("grid-difference")
    opened.views.sheet.set_layout("expected-error")
    opened.refresh.now()
    assert not opened.feature(ErrorFeature).busy
    run_all(opened)
    settle(opened, qtbot)
    assert len(reported) == 2, "other results, another try"


def test_without_live_another_preset_makes_depth_stale_until_one_button_runs_the_blocks(opened, qtbot, run_all):
    run_all(opened)
    opened.actions_["live"].trigger()
    settle(opened, qtbot)
    opened.workspace.select([])
    document, names = opened.workspace.current, opened.feature(FilterPanel).presets.names
    button = next(button for button in opened.findChildren(QToolButton) if "stale" in button.text())
    assert not button.isVisible()

    def choose(preset):
        names.setCurrentText(preset)
        names.activated.emit(names.currentIndex())
        qtbot.waitUntil(lambda: button.isVisible() == (preset == "paper"))
        opened.refresh.now()

    def grey(content):
        colours = opened.views.cells[content].view.image.pixels[document.completion().filled]
        channels = np.stack([colours >> shift & 255 for shift in (0, 8, 16)])
        return bool(np.ptp(channels.astype(int), axis=0).max() < 40)

    before = document.completion()
    choose("paper")
    assert button.text().startswith("2 blocks are stale")
    qtbot.waitUntil(lambda: grey("depth-out") and grey("expected-error"))
    choose("best")
    assert document.completion() is before
    qtbot.waitUntil(lambda: not grey("depth-out") and not grey("expected-error"))
    choose("paper")
    with qtbot.waitSignal(opened.runs.ended):
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: not button.isVisible())
    opened.refresh.now()
    qtbot.waitUntil(lambda: not grey("depth-out"))
    assert document.changed_blocks() == []
    opened.actions_["run"].trigger()
    assert "all blocks are up to date" in opened.notes.message
