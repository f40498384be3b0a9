"""Two depths compared in the real window, what its views are given to show, and the range of their colours."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

from gui.features.colour_range import ColourRange
from gui.features.status import StatusFeature
from gui.views.layouts import LAYOUTS
from ilf import preset

from .conftest import open_frame, readout, settle, write_frame


@pytest.fixture
def run_twice(opened, run_all):
    """A run of `best`, and one of the paper's preset after it."""
    opened.actions_["live"].setChecked(False)
    run_all(opened)
    document = opened.workspace.current
    kept = document.state.runs[0]
    document.change_run(kept, name="Best")
    opened.workspace.parameters.set(preset("paper", max_iterations=3))
    run_all(opened)
    return opened, kept


def test_runs_come_to_the_views_and_one_looks_at_the_other_while_a_key_is_held(run_twice, qtbot):
    window, kept = run_twice
    window.views.sheet.set_layout("grid-difference")
    settle(window, qtbot)
    cell = window.views.cells["difference"]
    assert cell.concrete == "difference:result:earlier"
    assert "Best" in cell.strip.title
    window.workspace.current.compare_runs([kept])
    window.refresh.now()
    assert cell.concrete == "difference:result:run-1"
    out = window.views.cells["depth-out"]
    row, column = np.argwhere(out.view.drawn[0] != kept.completion.depth)[0]
    now, difference = out.view.value_at(column, row), cell.view.value_at(column, row)
    out.view.setFocus()
    qtbot.keyPress(out.view, Qt.Key.Key_V)
    assert out.view.value_at(column, row) == kept.completion.depth[row, column] != now
    assert out.strip.title == "Best"
    assert cell.view.value_at(column, row) == difference != 0, "their difference stays to be seen"
    qtbot.keyRelease(out.view, Qt.Key.Key_V)
    assert (out.view.value_at(column, row), out.strip.title) == (now, "Depth out")
    window.actions_["swipe"].trigger()
    window.views.sides.move_to(window.workspace.current.frame.shape[1])
    assert out.view.value_at(column, row) == kept.completion.depth[row, column]
    assert "Best" in readout(window, (int(column), int(row)))
    document = window.workspace.current
    document.delete_runs(list(document.state.runs))
    window.refresh.now()
    assert cell.concrete == "difference:result:interpolated"
    assert out.strip.title == "A: depth in | B: result"
    window.actions_["compare_two"].trigger()
    assert not window.actions_["swipe"].isChecked(), "side by side, neither side is parted"
    window.actions_["swipe"].trigger()
    assert window.views.sheet.layout_name == "grid-difference"


def test_swiping_leaves_every_layout_as_it_was_and_another_one_of_the_window_ends_it(run_twice):
    window, _ = run_twice
    views, swipe = window.views, window.actions_["swipe"]
    views.sheet.set_layout("colour")
    swipe.trigger()
    assert views.contents()["colour"] == "result", "where else would the handle be"
    swipe.trigger()
    assert views.contents()["colour"] == "colour"

    window.actions_["layout_standard"].trigger()
    handles = views.sides._items

    def is_swiped():
        return any(cell.concrete == "result" and handles[cell.view].visible for cell in views.sheet.shown)

    contents = views.contents()
    for layout in LAYOUTS:
        views.sheet.set_layout(layout)
        state = views.sheet.layout_name, views.sheet.lasting, contents
        swipe.trigger()
        assert is_swiped(), layout
        swipe.trigger()
        assert (views.sheet.layout_name, views.sheet.lasting, views.contents()) == state
        assert not any(handle.visible for handle in handles.values())

        # other views while swiping are swiped, too, and the former contents come back
        swipe.trigger()
        views.sheet.set_layout("extraction")
        assert is_swiped(), layout
        views.sheet.set_layout("row")
        assert is_swiped(), layout
        swipe.trigger()
        assert (views.sheet.layout_name, views.contents()) == ("row", contents)

    views.sheet.set_layout("colour")
    contents = views.contents()
    swipe.trigger()
    assert views.contents() != contents
    window.actions_["layout_tune"].trigger()
    assert not swipe.isChecked()
    window.actions_["layout_standard"].trigger()
    assert (views.sheet.layout_name, views.contents()) == ("colour", contents)


def test_blocks_of_side_a_are_shown_with_it_an_edit_brings_the_present_back_and_no_run_faces_itself(run_twice):
    window, kept = run_twice
    window.workspace.current.compare_runs([kept])
    document = window.workspace.current
    window.workspace.select([1, 2])
    window.actions_["merge_blocks"].trigger()
    window.refresh.now()
    window.actions_["blink"].setChecked(True)
    np.testing.assert_array_equal(window.views.blocks.labels, kept.run.blocks.labels)
    window.actions_["undo"].trigger()
    window.refresh.now()
    assert not window.actions_["blink"].isChecked()
    np.testing.assert_array_equal(window.views.blocks.labels, document.labels)
    assert window.views.cells["depth-out"].strip.title == "Depth out"

    workspace, views = window.workspace, window.views
    workspace.current.compare_runs([window.workspace.current.state.runs[-1]])
    window.actions_["compare_two"].trigger()
    window.refresh.now()
    assert [views.data.names.get(side, side) for side in views.data.sides] == ["Best", "result"]
    workspace.accept_run(kept)
    window.refresh.now()
    assert views.data.sides == ("run-1", "result")
    assert views.data.result_number == kept.number


def test_what_is_not_looked_at_is_not_worked_out(run_twice, qtbot):
    window, _ = run_twice
    settle(window, qtbot)
    material = window.views.data
    assert material.interpolated is None
    assert material.edges is None
    window.views.set_content("colour", "strength")
    window.views.set_content("depth-in", "difference:result:interpolated")
    window.views.set_content("expected-error", "spectrum")
    window.workspace.select([1])
    settle(window, qtbot)
    shape = window.workspace.current.frame.shape
    assert material.edges.strength.shape == material.interpolated.shape == shape
    np.testing.assert_array_equal(np.isfinite(material.interpolated), True)
    radii = window.workspace.current.records_of(1)[-1].radii  # type: ignore[attr-defined]
    assert material.spectrum.radii == radii
    window.workspace.select([])
    settle(window, qtbot)
    assert material.spectrum == "Select a block"


def test_a_truth_is_shown_and_the_readout_says_how_far_off_the_result_is(opened, run_all):
    run_all(opened)
    ground_truth = np.full(opened.workspace.current.frame.shape, 2.0, np.float32)
    opened.workspace.current.set_ground_truth(ground_truth)
    opened.actions_["compare_two"].trigger()
    opened.refresh.now()
    cell = opened.views.cells["evaluation"]
    depth = opened.workspace.current.current_depth()
    assert cell.view.value_at(4, 5) == pytest.approx(1000 * (depth[5, 4] - 2), abs=0.01)
    assert "truth 2.000 m" in readout(opened, (4, 5))
    assert "error" in opened.feature(StatusFeature).bar.readout.text()
    opened.actions_["compare_two"].trigger()
    assert opened.views.sheet.layout_name == "grid"


def test_the_range_is_dragged_typed_and_locked_over_frames(opened, run_all, qtbot, tmp_path, small_frame):
    run_all(opened)
    panel = opened.feature(ColourRange)
    opened.actions_["show_range"].trigger()
    views = opened.views
    opened.refresh.now()
    assert panel.visible
    assert "Depth in [m]" in panel.heading.text(), "the first view that has a range"
    robust = views.ranges.depth
    assert panel.histogram.levels == pytest.approx(robust)
    panel.histogram._region.setRegion((1.2, 1.9))
    qtbot.waitUntil(lambda: views.ranges.depth == pytest.approx((1.2, 1.9)))
    opened.refresh.now()
    assert panel.mode.currentData() == "fixed"
    panel.high.setValue(2.5)
    assert views.ranges.depth == pytest.approx((1.2, 2.5))
    opened.actions_["lock_range"].trigger()
    open_frame(opened, qtbot, write_frame(tmp_path / "another", small_frame))
    assert views.ranges.depth == pytest.approx((1.2, 2.5))
    opened.refresh.now()
    assert not panel.high.isEnabled()
    opened.actions_["lock_range"].trigger()
    opened.refresh.now()
    panel.mode.setCurrentIndex(panel.mode.findData("robust"))
    panel.mode.activated.emit(0)
    assert views.ranges.depth == pytest.approx(robust, abs=0.01)
    panel.low.setValue(9.0)
    opened.refresh.now()
    assert views.ranges.depth == pytest.approx(robust, abs=0.01), "the lower end must be below the upper one"
    assert panel.low.value() == pytest.approx(robust[0], abs=0.01)
    views.sheet.set_layout("colour")
    opened.refresh.now()
    assert not any(field.isEnabled() for field in (panel.mode, panel.low, panel.high)), "colour has no range"


def test_the_divider_starts_where_it_is_seen_and_a_side_that_is_to_be_worked_out_is(run_twice, qtbot):
    window, _ = run_twice
    settle(window, qtbot)
    window.views.transform.show(slice(0, 12), slice(0, 12))
    window.actions_["swipe"].trigger()
    sides = window.views.sides
    seen = window.views.cells["depth-out"].view.visible_box()[1]
    assert seen.stop < window.workspace.current.frame.shape[1] / 2, "the middle of the frame is out of sight"
    assert seen.start < sides.x < seen.stop

    material = window.views.data
    settle(window, qtbot)
    assert material.interpolated is None
    window.views.sides.choose("interpolated")
    qtbot.waitUntil(lambda: material.interpolated is not None)
    window.actions_["swipe"].setChecked(False)
