"""A guide in the window: loaded by the dialog, followed, seen, undone and removed."""

import numpy as np
from PySide6.QtWidgets import QFileDialog, QPushButton

from gui.features.accuracy.ground_truth import GroundTruthDialog
from gui.features.additional_depth import BY_HAND, GUIDE, AdditionalDepthPanel

from .conftest import open_frame, settle


def test_guide_is_loaded_seen_followed_undone_and_removed(window, qtbot, frame_folder, tmp_path, run_all, monkeypatch):
    actions, workspace = window.actions_, window.workspace
    assert not actions["load_guide"].isEnabled()
    open_frame(window, qtbot, frame_folder)
    assert not actions["remove_guide"].isEnabled()
    run_all(window)
    document = workspace.current
    before = document.completion().depth

    rows, columns = np.mgrid[:48, :64]
    ground_truth = np.where(columns < 30, 1.5 + 0.004 * rows, 2.4 + 0.005 * columns)
    np.save(tmp_path / "other.npy", ground_truth[:, :40])
    np.save(tmp_path / "inverse.npy", 1 / ground_truth)
    panel = window.feature(AdditionalDepthPanel)
    reported: list[str] = []
    monkeypatch.setattr(window.notes, "report", lambda what, error: reported.append(str(error)))

    def load(path):
        monkeypatch.setattr("gui.features.additional_depth.choose_file", lambda *_: str(path))
        actions["load_guide"].trigger()
        qtbot.waitUntil(lambda: not panel.busy)

    load(tmp_path / "other.npy")
    section = panel._sections[GUIDE]
    assert "another aspect" in reported[0]
    assert document.frame.guide is None
    assert section.message.text() == "None in this frame."
    assert not section.show.isEnabled()
    actions["live"].trigger()
    load(tmp_path / "inverse.npy")
    assert panel.visible
    window.refresh.now()
    assert "is not used: " in section.effect.text()
    assert "inverse.npy; it covers 100% of the missing pixels." in section.message.text()
    section.show.click()
    assert window.views.contents()["depth-in"] == "guide"
    qtbot.waitUntil(lambda: window.views.data.guide is not None)
    assert np.median(np.abs(window.views.data.guide - ground_truth)) < 0.01
    # what it changes is worked out though it has not been run with yet
    assert document.changed_blocks()
    section.compare.click()
    qtbot.waitUntil(lambda: "without it, " in section.effect.text())
    run_all(window)
    guided = document.completion().depth
    assert np.nanmax(np.abs(guided - ground_truth)) < 0.002
    assert np.nanmax(np.abs(guided - before)) < 1e-4
    assert "With it, no pixel changed by 0.1 mm." in section.effect.text()

    # undo brings the former results back, without a run, and redo these
    workspace.undo_group.undo()
    assert document.frame.guide is None
    assert not document.changed_blocks()
    assert np.array_equal(document.completion().depth, before, equal_nan=True)
    workspace.undo_group.redo()
    assert np.array_equal(document.completion().depth, guided, equal_nan=True)

    # with live update on, both are followed without a run
    actions["live"].trigger()
    actions["remove_guide"].trigger()
    assert document.frame.guide is None
    qtbot.waitUntil(lambda: not document.changed_blocks())
    assert np.array_equal(document.completion().depth, before, equal_nan=True)
    load(tmp_path / "inverse.npy")
    qtbot.waitUntil(lambda: not document.changed_blocks())
    assert np.array_equal(document.completion().depth, guided, equal_nan=True)
    window.refresh.now()
    section.compare.click()
    actions["remove_guide"].trigger()  # overtakes the comparison
    assert not actions["remove_guide"].isEnabled()
    settle(window, qtbot)
    assert section.effect.text() == ""
    assert section.message.text() == "None in this frame."


def test_why_a_guide_changes_nothing_is_said_where_it_is_seen(opened, qtbot, tmp_path):
    frame = opened.workspace.current.frame
    noise = np.random.default_rng(0).random(frame.shape, dtype=np.float32)
    opened.workspace.current.set_guide(frame.with_guide(noise).guide, "Load guide")
    panel = opened.feature(AdditionalDepthPanel)
    panel.reveal()
    opened.resize(1000, 500)
    opened.refresh.now()
    for kind, why in ((GUIDE, "It is not used"), (BY_HAND, "without it")):
        panel.compare(kind)
        effect = panel._sections[kind].effect
        qtbot.waitUntil(lambda effect=effect, why=why: why in effect.text())
        qtbot.waitUntil(lambda effect=effect: not effect.visibleRegion().isEmpty())


def test_files_for_a_frame_are_first_looked_for_beside_it(window, qtbot, frame_folder, monkeypatch):
    open_frame(window, qtbot, frame_folder)
    starts: list[str] = []
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *asked: starts.append(asked[2]) or ("", ""))
    window.actions_["load_guide"].trigger()
    window.actions_["load_ground_truth"].trigger()
    buttons = window.findChild(GroundTruthDialog).findChildren(QPushButton)
    next(button for button in buttons if button.text() == "File…").click()
    assert starts == [str(frame_folder)] * 2
