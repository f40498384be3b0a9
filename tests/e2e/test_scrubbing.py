"""Going back through the iterations of a run in the real window."""

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

import ilf
from gui.features.curves import CurvesFeature


def _shown(window):
    window.refresh.now()
    return window.views.cells["depth-out"].view.drawn[0]


def test_the_views_look_back_and_return(opened, qtbot, run_all):
    run_all(opened)
    opened.panels._show([*opened.panels.open, "Convergence"])
    document, bar = opened.workspace.current, opened.feature(CurvesFeature).widget.scrub_bar
    opened.refresh.mark("Convergence")
    opened.refresh.now()
    present = document.current_depth().copy()
    lengths = {label: len(result.history) for label, result in document.valid_results().items()}
    assert bar.last == max(lengths.values()) > 3

    bar._slider.setValue(3)
    qtbot.waitUntil(lambda: opened.workspace.viewed_iteration is not None)
    expected = document.frame.depth.copy()
    for label in lengths:
        stepper = ilf.iterate(document.frame, document.labels, label, extraction=document.blocks.extraction)
        for _ in range(3):
            next(stepper, None)
        missing = (document.labels == label) & ~document.frame.known
        surface = np.full(document.labels.shape, np.nan)
        surface[document.labels == label] = stepper.surface
        expected[missing] = surface[missing].astype(np.float32)
    np.testing.assert_array_equal(_shown(opened), expected)
    assert opened.views.cells["depth-out"].strip._text == "as of iteration 3"
    assert "i 3 " in opened.feature(CurvesFeature).widget.readout.text

    bar._slider.setFocus()
    QTest.keyClick(bar._slider, Qt.Key.Key_End)
    np.testing.assert_array_equal(_shown(opened), present)
    assert opened.views.cells["depth-out"].strip._text == ""
    said = opened.feature(CurvesFeature).widget.readout.text
    assert any(f"i {length} " in said for length in lengths.values())


def test_key_frames_are_those_of_the_last_frames_that_were_run(opened):
    workspace, first = opened.workspace, opened.workspace.current
    run = ilf.Run(first.frame, first.labels, ilf.preset(max_iterations=2))
    with run.steps(1, workspace.watch(first, run)) as steps:
        for _ in steps:
            pass
    assert first.key_frames.nbytes > 0
    others = [type(first)(first.state, None, f"other {at}") for at in range(4)]
    for document in others[:3]:
        workspace.watch(document, run)
    assert first.key_frames.nbytes > 0
    workspace.watch(others[3], run)
    assert first.key_frames.nbytes == 0
