"""The run control with scripted runs: what it starts, holds, drops and brings to the workspace, and what it says."""

from dataclasses import replace

import numpy as np

from gui.features.blocks.feature import block_rows
from gui.features.blocks.table import BlockColumn
from gui.work.frame_runs import RunState
from ilf.data.blocks import find_blocks
from ilf.segmentation.editing.cleaning import merge

# starting and ending


def test_a_run_that_breaks_keeps_what_is_done_and_tells_why(bench, until):
    bench.runs.current.cancel()
    assert bench.states == [], "there is nothing to cancel"
    bench.run_first_block()
    assert bench.states == [RunState.RUNNING]
    bench.script.error = MemoryError("no room")
    bench.script.allow()
    until(lambda: bool(bench.failed))
    assert str(bench.failed[0]) == "no room"
    assert bench.said[0].startswith("first: run failed, 1 block in ")
    assert set(bench.document.valid_results()) == {1}
    assert bench.finished == []
    assert bench.run.closed
    assert (bench.runs.state, bench.document.results.running) == (RunState.IDLE, [])


# holding


def test_stepping_holds_after_every_step_and_pausing_and_going_on_turn_it(bench, until):
    bench.script.records = 50
    results = bench.document.results
    bench.script.allow()
    bench.workspace.select([2])
    bench.runs.current.step()
    until(lambda: bench.runs.state is RunState.PAUSED and len(results.live.get(2, [])) == 1)
    assert bench.run.run.only == {2}
    assert bench.run.threads == 1
    assert not bench.runs.state.free
    bench.runs.current.step()
    until(lambda: len(results.live[2]) == 2)
    until(lambda: bench.runs.state is RunState.PAUSED)
    assert len(bench.script.runs) == 1, "a step of the run under way is no new run"
    bench.runs.current.toggle_pause()
    until(lambda: bool(bench.said))
    assert len(bench.document.valid_results()[2].history) == 50


# previews


def test_previews_come_now_and_then_and_go_with_the_run(bench, until, qtbot, clock):
    bench.script.records = 1000
    results = bench.document.results
    bench.runs.current.start()
    bench.script.allow(1)
    until(lambda: 1 in results.previews)
    assert (bench.document.current_depth()[:, :30] == 1.5).all()
    bench.script.allow(5)
    until(lambda: len(results.live[1]) == 6)
    assert bench.run.previews == 1, "no time has passed"
    clock[0] += 0.1499
    bench.script.allow(1)
    until(lambda: len(results.live[1]) == 7)
    assert bench.run.previews == 1
    clock[0] += 0.0002
    bench.script.allow(1)
    until(lambda: len(results.live[1]) == 8)
    assert bench.run.previews == 2
    bench.cancel()
    assert results.previews == {}
    assert bench.document.current_depth() is None


# edits and frames during a run


def test_results_of_blocks_that_were_edited_meanwhile_are_told_as_lost(bench):
    bench.runs.current.start()
    bench.get_going()
    bench.workspace.current.edit(merge(bench.document.labels, [1, 2], frozenset()), "Merge")
    assert (bench.run.run.blocks.labels == bench.labels).all(), "the run has blocks of its own"
    bench.finish()
    assert bench.said[0].endswith(" 2 blocks edited meanwhile.")
    assert bench.document.valid_results() == {}
    bench.workspace.undo_group.undo()
    assert set(bench.document.valid_results()) == {1, 2}, "undo brings them back"


def test_results_of_a_frame_that_was_closed_meanwhile_trouble_nobody(bench):
    bench.runs.current.start()
    bench.get_going()
    bench.workspace.remove_entries([bench.workspace.entries.of(bench.document.id)])
    bench.workspace.tell()
    assert (bench.runs.state, bench.runs.running) == (RunState.IDLE, [])
    bench.finish()
    assert "run cancelled" in bench.said[0]
    assert bench.workspace.open == []
    assert bench.runs.state is RunState.IDLE


def test_frames_run_side_by_side(bench, until):
    bench.runs.current.start()
    bench.get_going()
    other = bench.open("second")
    assert bench.runs.state.free
    bench.runs.current.start({2})
    assert bench.runs.running == [bench.document, other]
    bench.runs.current.toggle_pause()
    bench.workspace.show(bench.document)
    assert bench.runs.state is RunState.RUNNING, "the other one alone is held"
    bench.workspace.show(other)
    bench.runs.of(other).toggle_pause()
    bench.script.allow()
    until(lambda: len(bench.said) == 2)
    assert (set(bench.document.valid_results()), set(other.valid_results())) == ({1, 2}, {2})
    assert bench.runs.running == []


# the end


def test_blocks_that_wait_for_the_correction_stay_when_a_run_is_cancelled(bench):
    """As they are without it, so that they count as changed."""
    bench.run_first_block()
    first = bench.document.valid_results()[1]
    waits = replace(first, parameters=first.parameters.replace(correction=False))
    bench.run.uncorrected[2] = replace(waits, block=find_blocks(bench.document.labels)[2], depth=second_depth(bench))
    assert bench.runs.of(bench.document).share_done == 1.0
    bench.cancel()
    assert set(bench.document.valid_results()) == {1, 2}
    assert bench.document.changed_blocks() == [2]
    assert "2 blocks" in bench.said[0]
    assert bench.said[0].endswith(" 1 block without the learned correction: run again (F5).")
    row = block_rows(bench.document, bench.runs.current)[2]
    assert "The result, completed, waits for the learned correction." in row[BlockColumn.STATE].hint


def second_depth(bench) -> np.ndarray:
    return np.full(np.count_nonzero(bench.document.labels == 2), 2, np.float32)
