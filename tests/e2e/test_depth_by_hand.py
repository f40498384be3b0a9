"""Depth by hand in the real window: picked, painted, seen, solved live, taken from a plane, undone, exported."""

from dataclasses import replace

import numpy as np
from PySide6.QtCore import Qt

from gui.features.cloud import CloudPanel
from gui.features.tools import ToolsFeature
from gui.work.frame_runs import RunState
from ilf.run.replaying import replay
from ilf.run.writing import write

from .conftest import readout
from .hand import CTRL, SHIFT, click, drag, key

_Key = Qt.Key


def test_depth_by_hand(opened, qtbot, run_all, tmp_path):
    window, workspace = opened, opened.workspace
    document = workspace.current
    workspace.select([])
    run_all(window)
    left, right = int(document.labels[16, 12]), int(document.labels[35, 48])
    before = document.valid_results()[right]
    window.actions_["tool_depth_by_hand"].trigger()
    window.views.cells["colour"].view.setFocus()
    window.refresh.now()

    # a picked depth is in the tool bar, a typed one is painted, and the block is solved again
    drag(window, [(10, 16), (16, 16)])
    assert "No depth is set yet" in window.notes.message
    click(window, (5, 30), CTRL)
    box = window.feature(ToolsFeature).options.hand_depth
    window.refresh.now()
    assert box.value() == round(float(document.frame.depth[30, 5]), 3)
    box.setValue(1.25)
    window.editor.options.brush_radius = 4.0
    with qtbot.waitSignal(window.runs.run_ended):
        drag(window, [(4, 16), (16, 16)])
    assert not document.blocks.by_hand.pixels[document.frame.known].any(), "only where depth is missing"
    assert document.undo_stack.undoText() == "Paint depth"
    qtbot.waitUntil(lambda: window.runs.state is RunState.IDLE)
    result = document.valid_results()[left]
    assert document.is_up_to_date(left)
    assert document.valid_results()[right] is before, "another block is not solved again"
    assert result.outcome.by_hand > 20
    depth = document.current_depth()
    assert abs(float(depth[16, 14]) - 1.25) < 0.1
    window.refresh.now()
    assert "by hand" in window.views.cells["depth-out"].view.striped
    assert "by hand 1.250 m" in readout(window, (14, 16))

    drag(window, [(11, 16), (13, 16)], SHIFT)
    assert not document.blocks.by_hand.pixels[16, 11:14].any()
    # undone, the earlier result is valid again without a run
    for _ in range(2):
        key(window, _Key.Key_Z, CTRL)
    assert document.blocks.by_hand is None
    assert document.is_up_to_date(left)
    window.refresh.now()
    assert "by hand" not in window.views.cells["depth-out"].view.striped

    # a plane is seen in the images and in 3D before it is taken
    workspace.select([left])
    window.actions_["cloud_beside"].trigger()
    window.actions_["continue_plane"].trigger()
    qtbot.waitUntil(lambda: document.proposal is not None)
    qtbot.waitUntil(lambda: "proposed surface" in window.feature(CloudPanel).view.strip.title)
    shown = window.views.data.result
    assert abs(float(shown.depth[16, 14]) - (1.5 + 0.004 * 16)) < 0.01
    assert "proposed 1.56" in readout(window, (14, 16))
    assert document.blocks.by_hand is None
    key(window, _Key.Key_Escape)
    assert document.proposal is None
    window.actions_["continue_plane"].trigger()
    qtbot.waitUntil(lambda: document.proposal is not None)
    with qtbot.waitSignal(window.runs.run_ended):
        key(window, _Key.Key_Return)
    qtbot.waitUntil(lambda: window.runs.state is RunState.IDLE)
    assert np.array_equal(document.blocks.by_hand.pixels, document.frame.missing & (document.labels == left))

    # and a run exported from here is replayed bit for bit
    run, completion = document.run(workspace.parameters.current), document.completion()
    write(tmp_path / "out", replace(completion, run=run))
    again = replay(tmp_path / "out" / "run.json")
    assert again.verdict(again.run.complete()) == ()
