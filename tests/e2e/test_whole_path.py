"""Open, extract, edit, run, export, reopen: the whole path through the real window."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget
from pytestqt.qtbot import QtBot

import ilf
from gui.app.main_window import MainWindow
from gui.features.blocks.feature import BlocksFeature
from gui.features.curves import CurvesFeature
from gui.features.export.dialog import Export
from gui.features.export.feature import ExportFeature
from gui.features.filter import FilterPanel
from gui.work.frame_runs import RunState
from ilf.cli import main as command_line
from ilf.data.results import Status
from ilf.run.options import ExportOptions
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading_options import ReadingOptions

from .conftest import WAIT_MS, open_frame

Run = Callable[[MainWindow], None]


def _export(window: MainWindow, qtbot: QtBot, folder: Path, options: ExportOptions | None = None) -> None:
    with qtbot.waitSignal(window.feature(ExportFeature).ended, timeout=WAIT_MS):
        window.feature(ExportFeature).start(Export(folder, options or ExportOptions()))


def test_window_and_command_line_give_the_same_files_bit_for_bit(
    opened: MainWindow, qtbot: QtBot, run_all: Run, frame_folder: Path, tmp_path: Path
) -> None:
    run_all(opened)
    _export(opened, qtbot, tmp_path / "window")
    assert command_line(["complete", str(frame_folder), "--out", str(tmp_path / "cli"), "--quiet"]) == 0
    names = sorted(path.name for path in (tmp_path / "cli").iterdir())
    assert names == sorted((*ExportOptions().filenames(), "meta.json"))
    for name in names:
        assert (tmp_path / "window" / name).read_bytes() == (tmp_path / "cli" / name).read_bytes(), name


def test_window_shows_what_the_library_computes(opened: MainWindow, run_all: Run, frame_folder: Path) -> None:
    run_all(opened)
    frame = ilf.load_frame(frame_folder)
    expected = ilf.complete(frame, ilf.extract_blocks(frame))
    document = opened.workspace.current
    completion = document.completion()
    assert completion is not None
    assert np.array_equal(completion.depth, expected.depth, equal_nan=True)
    assert all(outcome.status in (Status.COMPLETED, Status.NOTHING_MISSING) for outcome in completion.outcomes.values())


def test_curves_of_the_chosen_block_are_its_records(opened: MainWindow, run_all: Run) -> None:
    opened.panels.reveal("Convergence")
    run_all(opened)
    document = opened.workspace.current
    for label, result in document.valid_results().items():
        opened.workspace.select([label])
        assert [record.i for record in opened.feature(CurvesFeature).widget.records] == [
            record.i for record in result.history
        ]


def test_edited_blocks_survive_export_replay_and_reopening(
    opened: MainWindow, qtbot: QtBot, run_all: Run, tmp_path: Path
) -> None:
    workspace = opened.workspace
    opened.actions_["select_all"].trigger()
    opened.actions_["merge_blocks"].trigger()
    assert len(workspace.current.counts()) == 1
    workspace.parameters.set(ilf.preset("paper", centred=True))
    run_all(opened)
    _export(opened, qtbot, tmp_path / "first")
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
    with qtbot.waitSignal(opened.loader.idle, timeout=WAIT_MS):
        opened.documents.open_paths([tmp_path / "first" / "run.json"])
    assert np.array_equal(workspace.current.labels, merged)
    assert workspace.parameters.current.centred
    run_all(opened)
    _export(opened, qtbot, tmp_path / "third")
    assert (tmp_path / "third" / "depth.npy").read_bytes() == (tmp_path / "first" / "depth.npy").read_bytes()


def test_step_pause_resume_cancel(opened: MainWindow, qtbot: QtBot) -> None:
    runs, actions = opened.runs, opened.actions_
    seen: list[int] = []
    runs.records.connect(lambda _, records: seen.extend(record.i for record in records))
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000, linear_start=3.0))
    actions["step"].trigger()
    qtbot.waitUntil(lambda: seen == [1], timeout=WAIT_MS)
    qtbot.waitUntil(lambda: runs.state is RunState.PAUSED, timeout=WAIT_MS)
    actions["step"].trigger()
    qtbot.waitUntil(lambda: seen == [1, 2], timeout=WAIT_MS)
    assert actions["pause"].isChecked()
    actions["pause"].trigger()
    qtbot.waitUntil(lambda: len(seen) > 20, timeout=WAIT_MS)
    actions["pause"].trigger()
    qtbot.waitUntil(lambda: runs.state is RunState.PAUSED, timeout=WAIT_MS)
    qtbot.wait(100)
    held = len(seen)
    qtbot.wait(100)
    assert len(seen) == held
    with qtbot.waitSignal(runs.ended, timeout=WAIT_MS) as ended:
        actions["cancel"].trigger()
    assert "cancelled" in ended.args[0]
    assert seen == list(range(1, len(seen) + 1))
    assert opened.workspace.current.completion() is None
    assert not actions["cancel"].isEnabled()
    assert actions["run"].isEnabled()


def test_running_chosen_blocks_leaves_the_others(opened: MainWindow, qtbot: QtBot) -> None:
    document = opened.workspace.current
    chosen = next(iter(document.counts()))
    opened.workspace.select([chosen])
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["run_selected"].trigger()
    assert set(document.valid_results()) == {chosen}


def test_a_block_of_its_own_parameters(opened: MainWindow, run_all: Run) -> None:
    workspace = opened.workspace
    first, second = list(workspace.current.counts())[:2]
    workspace.select([first])
    workspace.parameters.set(ilf.preset(max_iterations=3), first)
    run_all(opened)
    results = workspace.current.valid_results()
    assert results[first].outcome.iterations == 3
    assert results[second].outcome.iterations > 3


def test_editing_a_block_takes_back_its_result_and_undo_brings_it_back(opened: MainWindow, run_all: Run) -> None:
    run_all(opened)
    workspace, document = opened.workspace, opened.workspace.current
    before = document.completion()
    labels = document.labels.copy()
    label = next(iter(document.counts()))
    workspace.select([label])
    opened.actions_["delete_blocks"].trigger()
    assert label not in document.valid_results()
    workspace.undo_group.undo()
    assert np.array_equal(document.labels, labels)
    after = document.completion()
    assert before is not None
    assert after is not None
    assert np.array_equal(before.depth, after.depth, equal_nan=True)


def test_closing_the_window_in_the_middle_of_a_run_ends_its_thread(opened: MainWindow, qtbot: QtBot) -> None:
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    opened.actions_["run"].trigger()
    qtbot.waitUntil(lambda: bool(opened.workspace.current.results.live), timeout=WAIT_MS)
    opened.close()
    assert opened.runs.state is RunState.IDLE


def test_several_frames_keep_their_own_state(opened: MainWindow, qtbot: QtBot, run_all: Run, tmp_path: Path) -> None:
    from .conftest import write_frame

    run_all(opened)
    first = opened.workspace.current
    depth = first.frame.depth + np.float32(0.5)
    second_folder = write_frame(tmp_path / "farther", ilf.RGBDFrame(first.frame.rgb, depth))
    open_frame(opened, qtbot, FrameRef(str(second_folder)))
    second = opened.workspace.current
    assert second is not first
    assert second.completion() is None
    opened.actions_["previous_frame"].trigger()
    assert opened.workspace.current is first
    assert first.completion() is not None
    opened.refresh.now()
    assert opened.windowTitle().startswith("two-planes")
    opened.centre.show_cloud()
    opened.actions_["next_frame"].trigger()
    opened.actions_["close_frame"].trigger()
    assert opened.workspace.open == [first]


def test_keyboard_shortcuts_are_unique_and_no_bare_key_deletes(window: MainWindow) -> None:
    keys = [command.keys for command in window.actions_.commands.values() if command.keys]
    assert len(keys) == len(set(keys))
    assert window.actions_["delete_blocks"].shortcut().toString() == "Ctrl+Del"


def test_brush_size_by_keyboard(opened: MainWindow, qtbot: QtBot) -> None:
    opened.editor.set_tool("paint")
    qtbot.keyClick(opened, Qt.Key.Key_BracketRight)
    assert opened.editor.options.brush_radius == 12.0
    qtbot.keyClick(opened, Qt.Key.Key_BracketLeft)
    assert opened.editor.options.brush_radius == 8.0


def test_preset_box_tells_what_was_changed_and_brings_it_back(opened: MainWindow) -> None:
    presets = opened.feature(FilterPanel).presets.names
    opened.workspace.parameters.set(ilf.preset("released-code"))
    opened.refresh.now()
    assert presets.currentText() == "released-code"
    opened.workspace.parameters.set(ilf.preset("released-code", mode="fill+denoise"))
    opened.refresh.now()
    assert presets.currentText() == "released-code (changed)"
    presets.activated.emit(presets.currentIndex())
    assert opened.workspace.parameters.current == ilf.preset("released-code")


def test_curves_follow_the_running_block_until_the_chosen_one_has_its_own(
    opened: MainWindow, qtbot: QtBot, run_all: Run
) -> None:
    workspace = opened.workspace
    opened.panels.reveal("Convergence")
    first, second = list(workspace.current.counts())[:2]
    workspace.select([second])
    shown: list[tuple[int, int]] = []

    def note(label: int) -> None:
        opened.refresh.draw_all()
        shown.append((label, len(opened.feature(CurvesFeature).widget.records)))

    opened.runs.records.connect(lambda label, _: note(label))
    run_all(opened)
    assert all(count > 0 for _, count in shown)
    assert (
        len(opened.feature(CurvesFeature).widget.records)
        == workspace.current.valid_results()[second].outcome.iterations
    )
    assert first in {label for label, _ in shown}


def test_cancelling_keeps_the_blocks_that_are_done(opened: MainWindow, qtbot: QtBot) -> None:
    document = opened.workspace.current
    first, second = list(document.counts())[:2]
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000), second)
    done: list[str] = []
    opened.runs.ended.connect(done.append)
    opened.actions_["run"].trigger()
    qtbot.waitUntil(lambda: second in opened.workspace.current.results.live, timeout=WAIT_MS)
    opened.actions_["cancel"].trigger()
    qtbot.waitUntil(lambda: bool(done), timeout=WAIT_MS)
    assert set(document.valid_results()) == {first}
    assert "cancelled, 1 block" in done[0]


def test_a_frame_that_runs_is_not_closed_silently(opened: MainWindow, qtbot: QtBot) -> None:
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    opened.actions_["run"].trigger()
    opened.documents.discard_silently = False
    opened.actions_["close_frame"].trigger()
    assert opened.workspace.has_current
    question = opened.project.closing.dialog
    assert question is not None
    question.reject()
    opened.documents.discard_silently = True
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["cancel"].trigger()


def test_opening_a_run_twice_keeps_the_work_in_it(
    opened: MainWindow, qtbot: QtBot, run_all: Run, tmp_path: Path
) -> None:
    run_all(opened)
    _export(opened, qtbot, tmp_path / "out")
    with qtbot.waitSignal(opened.loader.idle, timeout=WAIT_MS):
        opened.loader.open_run(tmp_path / "out" / "run.json")
    document = opened.workspace.current
    opened.workspace.select([1, 2])
    opened.actions_["merge_blocks"].trigger()
    # by the same path, and by another to the same place
    for again in (tmp_path / "out" / "run.json", Path(os.path.relpath(tmp_path / "out" / "run.json"))):
        opened.loader.open_run(again)
        assert not opened.loader.busy
        assert opened.workspace.current is document
        assert document.unsaved


def test_opening_with_other_units_reads_the_frame_again(opened: MainWindow, qtbot: QtBot, frame_folder: Path) -> None:
    first = opened.workspace.current
    with qtbot.waitSignal(opened.loader.idle, timeout=WAIT_MS):
        opened.documents.open_source(FrameRef(str(frame_folder), options=ReadingOptions(depth_units=2000.0)))
    second = opened.workspace.current
    assert opened.workspace.open == [second]
    assert np.nanmedian(second.frame.depth) == pytest.approx(np.nanmedian(first.frame.depth) / 2, rel=1e-3)


def test_a_partial_run_comes_back_as_it_was(opened: MainWindow, qtbot: QtBot, tmp_path: Path) -> None:
    opened.workspace.select([2])
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["run_selected"].trigger()
    _export(opened, qtbot, tmp_path / "out")
    opened.actions_["close_frame"].trigger()
    with qtbot.waitSignal(opened.loader.idle, timeout=WAIT_MS):
        opened.loader.open_run(tmp_path / "out" / "run.json")
    assert opened.workspace.current.selected == [2]


def test_nothing_runs_while_blocks_are_extracted(opened: MainWindow, qtbot: QtBot) -> None:
    opened.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=1.0))
    with qtbot.waitSignal(opened.loader.idle, timeout=WAIT_MS):
        opened.actions_["extract"].trigger()
        assert not opened.actions_["run"].isEnabled()
        assert not opened.actions_["extract"].isEnabled()
    assert opened.actions_["run"].isEnabled()


def test_the_other_way_round_nothing_is_extracted_during_a_run(opened: MainWindow, qtbot: QtBot) -> None:
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    opened.actions_["run"].trigger()
    assert not opened.actions_["extract"].isEnabled()
    assert not opened.actions_["load_blocks"].isEnabled()
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["cancel"].trigger()
    assert opened.actions_["extract"].isEnabled()


def test_docks_keep_their_sizes_when_the_window_is_hidden_and_shown(window: MainWindow, qtbot: QtBot) -> None:
    before = window.feature(BlocksFeature).table.width()
    blocks = window.findChild(QDockWidget, "Blocks")
    window.resizeDocks([blocks], [before + 60], Qt.Orientation.Horizontal)
    qtbot.waitUntil(lambda: window.feature(BlocksFeature).table.width() > before + 30)
    wide = window.feature(BlocksFeature).table.width()
    window.hide()
    window.show()
    assert window.feature(BlocksFeature).table.width() == wide


def test_preset_box_keeps_the_two_scopes_apart(opened: MainWindow) -> None:
    workspace, panel = opened.workspace, opened.feature(FilterPanel)
    workspace.parameters.set(ilf.preset("paper"))
    opened.refresh.now()
    workspace.parameters.set(ilf.preset("paper", centred=True))
    workspace.select([1])
    workspace.parameters.set(ilf.preset("released-code"), 1)
    panel.scope.setCurrentIndex(1)
    panel.redraw()
    opened.refresh.now()
    assert panel.presets.names.currentText() == "released-code"
    panel.scope.setCurrentIndex(0)
    panel.redraw()
    opened.refresh.now()
    assert panel.presets.names.currentText() == "paper (changed)"
