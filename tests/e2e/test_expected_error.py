"""The expected error in the window: it follows the results, and is worked out only for those who look."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.main_window import MainWindow
from gui.work.expected_errors import ExpectedErrors
from ilf.completion import compose
from ilf.confidence import expected_error
from ilf.frame import RGBDFrame

from .conftest import WAIT_MS

Run = Callable[[MainWindow], None]


def _picture(window: MainWindow) -> np.ndarray | None:
    return window.views.cells["expected-error"].view.image.image


def test_it_comes_after_a_run_and_goes_with_the_results(opened: MainWindow, qtbot: QtBot, run_all: Run) -> None:
    assert _picture(opened) is None
    run_all(opened)
    qtbot.waitUntil(lambda: not opened.errors.busy and _picture(opened) is not None, timeout=WAIT_MS)
    session = opened.workspace.session
    completion = session.completion()
    assert completion is not None
    expected = expected_error(session.frame, completion)
    np.testing.assert_array_equal(_picture(opened) > 0, completion.filled)

    row, column = (int(places[0]) for places in np.nonzero(completion.filled))
    opened.presenter.show_readout((column, row))
    text = opened.readout.text()
    assert "\u00b1" in text
    shown, unit = text.rpartition("\u00b1 ")[2].split()
    metres = float(shown) * {"mm": 0.001, "m": 1.0}[unit]
    assert metres == pytest.approx(float(expected[row, column]), rel=0.06)
    known_row, known_column = (int(places[0]) for places in np.nonzero(session.frame.known))
    opened.presenter.show_readout((known_column, known_row))
    assert "\u00b1" not in opened.readout.text()

    opened.actions_["clear_results"].trigger()
    assert _picture(opened) is None
    opened.presenter.show_readout((column, row))
    assert "\u00b1" not in opened.readout.text()


def test_a_view_that_is_not_shown_costs_nothing_until_it_is(opened: MainWindow, qtbot: QtBot, run_all: Run) -> None:
    opened.views.set_layout("grid-difference")
    run_all(opened)
    assert not opened.errors.busy
    assert _picture(opened) is None
    opened.centre.setCurrentWidget(opened.cloud)
    opened.views.set_layout("expected-error")
    assert not opened.errors.busy
    opened.centre.setCurrentWidget(opened.views)
    qtbot.waitUntil(lambda: _picture(opened) is not None, timeout=WAIT_MS)


def test_what_cannot_be_found_is_said_once(
    qtbot: QtBot, small_frame: RGBDFrame, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise MemoryError("no room")

    monkeypatch.setattr("gui.work.expected_errors.expected_error", fail)
    errors, completion = ExpectedErrors(), compose(small_frame, {})
    with qtbot.waitSignal(errors.failed, timeout=WAIT_MS):
        errors.ask(small_frame, completion)
    errors.ask(small_frame, completion)
    assert not errors.busy
    with qtbot.waitSignal(errors.failed, timeout=WAIT_MS):
        errors.ask(small_frame, compose(small_frame, {}))
