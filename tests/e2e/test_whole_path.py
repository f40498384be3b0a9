"""Open, extract, edit, run, export, reopen: the whole path through the real window."""

import json
import os
from pathlib import Path

import numpy as np

import ilf
from ilf.cli import main as command_line
from ilf.run.options import ExportOptions
from ilf.run.writing import filenames

from .conftest import export, loaded


def test_window_and_command_line_give_the_same_files_bit_for_bit(opened, qtbot, run_all, frame_folder, tmp_path):
    run_all(opened)
    export(opened, qtbot, tmp_path / "window")
    assert command_line(["complete", str(frame_folder), "--out", str(tmp_path / "cli"), "--quiet"]) == 0
    names = sorted(path.name for path in (tmp_path / "cli").iterdir())
    assert names == sorted((*filenames(None, ExportOptions()), "meta.json"))
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

    replay = ["complete", "--replay", str(tmp_path / "first" / "run.json"), "--out", str(tmp_path / "again")]
    assert command_line([*replay, "--quiet"]) == 0
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name

    merged = workspace.current.labels.copy()
    opened.actions_["close_frame"].trigger()
    assert workspace.shown is None
    loaded(opened, qtbot, opened.documents.open_paths, [tmp_path / "first" / "run.json"])
    assert np.array_equal(workspace.current.labels, merged)
    assert workspace.parameters.current.centred
    run_all(opened)
    export(opened, qtbot, tmp_path / "third")
    assert (tmp_path / "third" / "depth.npy").read_bytes() == (tmp_path / "first" / "depth.npy").read_bytes()


def test_opening_a_run_twice_keeps_the_work_in_it(opened, qtbot, run_all, tmp_path):
    run_all(opened)
    export(opened, qtbot, tmp_path / "out")
    loaded(opened, qtbot, opened.documents.open_run, tmp_path / "out" / "run.json")
    document = opened.workspace.current
    opened.workspace.select([1, 2])
    opened.actions_["merge_blocks"].trigger()
    # by the same path, and by another to the same place
    for again in (tmp_path / "out" / "run.json", Path(os.path.relpath(tmp_path / "out" / "run.json"))):
        opened.documents.open_run(again)
        assert not opened.loader.busy
        assert opened.workspace.current is document
        assert document.unsaved


def test_a_partial_run_comes_back_as_it_was(opened, qtbot, tmp_path):
    opened.workspace.select([2])
    with qtbot.waitSignal(opened.runs.ended):
        opened.actions_["run_selected"].trigger()
    export(opened, qtbot, tmp_path / "out")
    opened.actions_["close_frame"].trigger()
    loaded(opened, qtbot, opened.documents.open_run, tmp_path / "out" / "run.json")
    assert opened.workspace.current.selected == [2]
