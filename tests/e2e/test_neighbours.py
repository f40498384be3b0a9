"""Depth of neighbours in the window: found, used, compared, seen, undone, kept in a project and removed."""

import numpy as np

from gui.base.commands import why_not
from gui.features.additional_depth import NEIGHBOURS, AdditionalDepthPanel
from gui.work.frame_runs import RunState
from ilf.project.file import open_project
from ilf.sources.frame_ref import FrameRef

from ..ilf.small_sequences import CAMERA, exact_view, pose_of, write_sequence
from .conftest import loaded, open_frame, settle


def open_sequence(window, qtbot, folder, number=2, intrinsics=CAMERA):
    """The list with all frames of a sequence, and one of them open."""
    source = FrameRef(str(folder)).with_options(
        intrinsics=None if intrinsics is None else (intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy)
    )
    with qtbot.waitSignal(window.loader.listed):
        window.loader.open_folder(source, show=False)
    entries = window.workspace.entries
    loaded(window, qtbot, window.loader.open_entry, entries[number])
    window.refresh.now()
    return window.workspace.current


def use(window, qtbot, count=2):
    """The section of the panel, after a search."""
    panel = window.feature(AdditionalDepthPanel)
    panel.reveal()
    panel._count.setValue(count)
    window.actions_["use_neighbours"].trigger()
    settle(window, qtbot)
    return panel._sections[NEIGHBOURS]


def test_depth_of_neighbours_is_found_used_seen_undone_and_kept(window, qtbot, tmp_path, run_all):
    actions, workspace = window.actions_, window.workspace
    assert why_not(actions["use_neighbours"]) == "Open a frame first."
    document = open_sequence(window, qtbot, write_sequence(tmp_path / "in"))
    workspace.current.replace_blocks(np.ones(document.frame.shape, np.int32), "One block")
    run_all(window)
    before = document.completion().depth
    hole = document.frame.missing.copy()
    _, exact = exact_view(pose_of(2))

    use(window, qtbot)
    assert "Depth of 4 neighbours is used at" in window.notes.message
    workspace.undo_group.undo()
    section = use(window, qtbot, count=1)
    assert "Depth of 2 neighbours is used at" in window.notes.message
    assert section.message.text().startswith("From frame-000001.color, frame-000003.color, at ")
    added = document.frame.from_neighbours
    assert added[hole].mean() > 0.7
    assert not added[~hole].any()
    np.testing.assert_array_equal(document.frame.missing, hole)  # they never count as measured

    window.views.set_content("depth-in", "from_neighbours")
    qtbot.waitUntil(lambda: not document.changed_blocks() and window.runs.state is RunState.IDLE)
    window.refresh.now()
    np.testing.assert_array_equal(window.views.data.frame.from_neighbours, added)
    row, column = np.argwhere(added)[0]
    window.views.navigation.point_at((int(column), int(row)))
    assert "from neighbours " in window.statusBar().readout.text()
    section.compare.click()
    qtbot.waitUntil(lambda: "without it, " in section.effect.text())
    together = document.completion().depth
    changed = np.count_nonzero(np.abs(together - before) > 1e-4)
    assert f"With it, {changed:,} px changed: median " in section.effect.text()
    assert np.abs(together - exact)[hole].mean() < 0.5 * np.abs(before - exact)[hole].mean()

    # undo brings the former results back, without a run, and redo these
    workspace.undo_group.undo()
    assert document.frame.from_neighbours is None
    assert not document.changed_blocks()
    np.testing.assert_array_equal(document.completion().depth, before)
    workspace.undo_group.redo()
    np.testing.assert_array_equal(document.completion().depth, together)

    with qtbot.waitSignal(window.project.saving.saved):
        window.project.saving.save(tmp_path / "work.ilf")
    with open_project(tmp_path / "work.ilf") as project:
        decoded = project.state(document.id)
        assert not decoded.problems
        kept = decoded.state.frame
        np.testing.assert_array_equal(kept.depth, document.frame.depth)
        np.testing.assert_array_equal(kept.from_neighbours, added)
        assert kept.neighbours.neighbours[0].sha256 == document.frame.neighbours.neighbours[0].sha256
        assert decoded.state.results[1].depth.shape == (hole.size,)
    window.views.set_content("depth-in", "from_neighbours")
    actions["remove_neighbours"].trigger()
    assert document.frame.from_neighbours is None
    assert not actions["remove_neighbours"].isEnabled()
    window.refresh.now()
    assert window.views.contents()["depth-in"] == "depth-in", "no view stays empty"


def test_search_can_be_cancelled_and_what_fails_is_told(window, qtbot, tmp_path, frame_folder):
    actions = window.actions_
    open_frame(window, qtbot, frame_folder)
    assert "no other frame of this sequence" in why_not(actions["use_neighbours"])
    folder = write_sequence(tmp_path / "in", count=3)
    document = open_sequence(window, qtbot, folder, number=-1)
    assert actions["use_neighbours"].isEnabled()
    for number in range(2):
        (folder / f"frame-{number:06}.depth.png").unlink()

    panel = window.feature(AdditionalDepthPanel)
    actions["use_neighbours"].trigger()
    # in sight, though the panel is higher than its place
    qtbot.waitUntil(lambda: not panel.work.cancel_button.visibleRegion().isEmpty())
    panel.work.cancel_button.click()
    qtbot.waitUntil(lambda: not panel.busy)
    assert not panel.work.isVisible()
    assert document.frame.neighbours is None
    use(window, qtbot)
    assert "Left out" in window.notes.message
    assert "frame-000001.color, frame-000000.color" in window.notes.message
    assert document.frame.neighbours is None
