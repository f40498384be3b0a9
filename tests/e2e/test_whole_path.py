"""Open, extract, edit, run, export, reopen: the whole path through the real window."""

import json
import os
from pathlib import Path

import numpy as np

import ilf
from gui.features.filter import FilterPanel
from ilf.cli import main as command_line
from ilf.run.options import ExportOptions

from .conftest import export, loaded, reading


def test_window_and_command_line_give_the_same_files_bit_for_bit(opened, qtbot, run_all, frame_folder, tmp_path):
    run_all(opened)
    export(opened, qtbot, tmp_path / "window")
    assert command_line(["complete", str(frame_folder), "--out", str(tmp_path / "cli"), "--quiet"]) == 0
    names = sorted(path.name for path in (tmp_path / "cli").iterdir())
    assert names == sorted((*ExportOptions().filenames(), "meta.json"))
    for name in names:
        assert (tmp_path / "window" / name).read_bytes() == (tmp_path / "cli" / name).read_bytes(), name


def test_edited_blocks_survive_export_replay_and_reopening(opened, qtbot, run_all, tmp_path):
    workspace = opened.workspace
    opened.actions_["select_all"].trigger()
    opened.actions_["merge_blocks"].trigger()
    assert len(workspace.current.counts()) == 1
    workspace.parameters.set(ilf.preset("paper", centred=True))
    run_all(opened)
    export(opened, qtbot, tmp_path / "first")
    assert json.loads((tmp_path / "first" / "run.json").read_text())["blocks"]["edited"] is True
    assert workspace.current.unsaved, "names, locks and the other runs are not in an export"

    assert (
        command_line(
            ["complete", "--replay", str(tmp_path / "first" / "run.json"), "--out", str(tmp_path / "again"), "--quiet"]
        )
        == 0
    )
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name

    merged = workspace.current.labels.copy()
    opened.actions_["close_frame"].trigger()
    assert not workspace.has_current
    loaded(opened, qtbot, opened.documents.open_paths, [tmp_path / "first" / "run.json"])
    assert np.array_equal(workspace.current.labels, merged)
    assert workspace.parameters.current.centred
    run_all(opened)
    export(opened, qtbot, tmp_path / "third")
    assert (tmp_path / "third" / "depth.npy").read_bytes() == (tmp_path / "first" / "depth.npy").read_bytes()


def test_opening_a_run_twice_keeps_the_work_in_it(opened, qtbot, run_all, tmp_path):
    run_all(opened)
    export(opened, qtbot, tmp_path / "out")
    loaded(opened, qtbot, opened.loader.open_run, tmp_path / "out" / "run.json")
    document = opened.workspace.current
    opened.workspace.select([1, 2])
    opened.actions_["merge_blocks"].trigger()
    # by the same path, and by another to the same place
    for again in (tmp_path / "out" / "run.json", Path(os.path.relpath(tmp_path / "out" / "run.json"))):
        opened.loader.open_run(again)
        assert not opened.loader.busy
        assert opened.workspace.current is document
        assert document.unsaved


def test_a_partial_run_comes_back_as_it_was(opened, qtbot, tmp_path):
    opened.workspace.select([2])
    with qtbot.waitSignal(opened.runs.ended):
        opened.actions_["run_selected"].trigger()
    export(opened, qtbot, tmp_path / "out")
    opened.actions_["close_frame"].trigger()
    loaded(opened, qtbot, opened.loader.open_run, tmp_path / "out" / "run.json")
    assert opened.workspace.current.selected == [2]


def test_blocks_are_extracted_and_run_one_after_the_other(opened, qtbot):
    actions = opened.actions_
    opened.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=1.0))
    with reading(opened, qtbot):
        actions["extract"].trigger()
        assert not actions["extract"].isEnabled()
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    actions["run"].trigger()
    assert not actions["extract"].isEnabled()
    assert not actions["load_blocks"].isEnabled()
    with qtbot.waitSignal(opened.runs.ended) as ended:
        actions["cancel"].trigger()
    assert "cancelled" in ended.args[0]
    assert opened.workspace.current.completion() is None
    assert [actions[name].isEnabled() for name in ("extract", "cancel", "run")] == [True, False, True]


def test_the_preset_box_tells_what_was_changed_and_keeps_the_two_scopes_apart(opened):
    workspace, panel = opened.workspace, opened.feature(FilterPanel)
    presets = panel.presets.names
    for name in ("released-code", "paper"):
        for changed in ({}, {"mode": "fill+denoise"}):
            workspace.parameters.set(ilf.preset(name, **changed))
            opened.refresh.now()
            assert presets.currentText() == name + (" (changed)" if changed else "")
        if name == "released-code":
            presets.activated.emit(presets.currentIndex())
            assert workspace.parameters.current == ilf.preset(name)
    workspace.select([1])
    workspace.parameters.set(ilf.preset("released-code"), 1)
    for scope, shown in ((1, "released-code"), (0, "paper (changed)")):
        panel.scope.setCurrentIndex(scope)
        panel.redraw()
        opened.refresh.now()
        assert presets.currentText() == shown
