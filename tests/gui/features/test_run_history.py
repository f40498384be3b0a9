"""Runs that are kept: what is kept of them and when, what they share, how they are come back to."""

import csv
import math

import numpy as np
import pytest

import ilf
from gui.features.run_history.panel import measure, write_runs
from gui.features.run_history.table import RunColumn, RunView, best_of, values_of
from gui.state.document import MAX_COMPARED, RUN_COLOURS, Document
from gui.state.parameters import DRAG_S
from gui.work.frame_runs import RunState
from gui.work.run_recorder import RunRecorder, memory_of, with_shared_arrays
from ilf.errors import ExportError
from ilf.project.run_history import StoredRun

from ..states import QUICK, edit, painted


@pytest.fixture
def keeper(bench, monkeypatch):
    """Keeps what the bench runs; values rest as soon as nothing runs."""
    monkeypatch.setattr("gui.work.run_recorder.REST_MS", 0)
    bench.script.allow()
    return RunRecorder(bench.workspace, bench.runs)


def stored_run(document: Document, number: int = 1, parameters: object = None, **more: object) -> StoredRun:
    """A run of all blocks of the frame as it is, with its results."""
    chosen = document.state.common if parameters is None else parameters
    run = with_shared_arrays(ilf.Run(document.frame, document.blocks, chosen), document.state.runs)
    results = ilf.complete(document.frame, document.labels, chosen).results
    return StoredRun(number, f"Run {number}", run, results, 0.5, RUN_COLOURS[0], done=frozenset(results), **more)


def names(document: Document) -> list[str]:
    return [kept.name for kept in document.state.runs]


def test_every_run_is_kept_with_what_it_was_made_of_and_shares_what_is_equal(bench, keeper, until):
    bench.runs.current.start()
    until(lambda: len(bench.document.state.runs) == 1)
    bench.workspace.parameters.set(ilf.preset(smoothness=0.6), 2)
    bench.runs.current.start_changed()
    until(lambda: len(bench.document.state.runs) == 2)
    first, second = bench.document.state.runs
    assert names(bench.document) == ["Run 1: best", "Run 2: best; Block 2: smoothness 0.6 x"]
    assert (first.done, second.done) == ({1, 2}, {2})
    assert set(second.results) == {1, 2}, "of all blocks, so that runs can be compared"
    assert second.run.blocks.labels is first.run.blocks.labels
    assert second.results[1] is first.results[1]
    assert second.is_of(bench.document.valid_results())
    assert first.colour != second.colour
    assert first.iterations == 2 * bench.script.records
    np.testing.assert_array_equal(second.completion.depth, bench.document.completion().depth)


@pytest.mark.parametrize("done", [0, 1])
def test_a_cancelled_run_is_kept_if_any_block_was_done(bench, until, done):
    RunRecorder(bench.workspace, bench.runs, bench.runs)
    bench.runs.current.start()
    bench.script.allow(bench.script.records + 1 if done else 1)
    until(lambda: len(bench.document.valid_results()) == done)
    bench.runs.current.cancel()
    bench.rest(1)
    values = [values_of(bench.document, kept) for kept in bench.document.state.runs]
    assert values == ["best · cancelled, 1 of 2 blocks without result"] * done


def test_a_drag_is_one_run_and_undo_makes_none(bench, keeper, until, monkeypatch):
    now = 100.0
    monkeypatch.setattr("gui.state.parameters.time.monotonic", lambda: now)
    workspace, document = bench.workspace, bench.document
    workspace.select([1])

    def solve(smoothness: float, expected: list[str]) -> None:
        workspace.parameters.set(ilf.preset(smoothness=smoothness))
        bench.runs.current.resolve([1])
        until(lambda: names(document) == expected and not keeper.waits)

    solve(2.0, ["Live 1: best, smoothness 2 x"])
    live = document.state.runs[0]
    solve(3.0, ["Live 1: best, smoothness 3 x"])
    assert document.state.runs == (live,), "the drag goes on"
    assert live.results[1].parameters.smoothness == 3.0
    now += 2 * DRAG_S
    solve(4.0, ["Live 1: best, smoothness 3 x", "Live 2: best, smoothness 4 x"])
    document.undo_stack.undo()
    bench.runs.current.resolve([1])
    until(lambda: bench.runs.state is RunState.IDLE and not keeper.waits)
    assert len(document.state.runs) == 2
    assert [kept.is_of(document.valid_results()) for kept in document.state.runs] == [True, False]
    document.change_run(document.state.runs[1], name="mine")
    document.undo_stack.redo()
    edit(workspace, 1, rows=np.s_[0:4], columns=np.s_[30:40])
    bench.runs.current.resolve([1], edited=True)
    until(lambda: len(document.state.runs) == 3)
    assert names(document)[1:] == ["mine", "Live 3: Edit; best, smoothness 4 x"]
    assert document.state.runs[2].run.blocks.labels is not live.run.blocks.labels


def test_what_runs_give_of_the_rest_is_kept_by_pixels(document, workspace):
    labels = painted(document, 0, np.s_[:], np.s_[40:64])
    document.set_labels(labels)
    kept = stored_run(document, parameters=QUICK)
    extrapolated = ilf.extrapolate(kept.completion)
    kept.take_extrapolation(extrapolated)
    depth, mask = extrapolated.depth.copy(), extrapolated.extrapolated.copy()
    assert mask.any()
    del extrapolated  # nobody has it any more, so it is made anew
    np.testing.assert_array_equal(kept.completion.depth, depth)
    np.testing.assert_array_equal(kept.completion.extrapolated, mask)
    workspace.parameters.set(ilf.preset())
    document.keep_run(kept)
    assert workspace.accept_run(kept) == [1, 2]
    assert document.extrapolated
    np.testing.assert_array_equal(document.completion().depth, depth)


def test_accepting_takes_results_and_parameters_where_blocks_are_as_they_were(document, workspace):
    kept = stored_run(document, parameters=QUICK)
    document.keep_run(kept)
    workspace.parameters.set(ilf.preset(smoothness=2.0), 2)
    document.store_results(list(ilf.complete(document.frame, document.labels, ilf.preset()).results.values()))
    before, depth = dict(document.valid_results()), document.current_depth().copy()
    steps = document.undo_stack.count()
    assert workspace.accept_run(kept) == [1, 2]
    assert kept.is_of(document.valid_results())
    assert (document.state.common, document.blocks.own, document.changed_blocks()) == (QUICK, {}, [])
    np.testing.assert_array_equal(document.current_depth(), kept.completion.depth)
    document.undo_stack.undo()
    assert dict(document.valid_results()) == before
    assert document.blocks.own == {2: {"smoothness": 2.0}}
    np.testing.assert_array_equal(document.current_depth(), depth)
    document.undo_stack.redo()
    assert (kept.is_of(document.valid_results()), document.undo_stack.count()) == (True, steps + 1)
    newer = ilf.complete(document.frame, document.labels, ilf.preset("paper", max_iterations=3)).results[1]
    document.store_results([newer])
    document.undo_stack.undo()
    assert newer in [one.result for one in document.results.kept[1]], "what has come since stays"


def test_of_an_accepted_run_what_no_longer_fits_is_left(document, workspace):
    kept = stored_run(document, parameters=QUICK)
    document.keep_run(kept)
    edit(workspace, 3, rows=np.s_[0:6], columns=np.s_[40:50])
    assert workspace.accept_run(kept) == [1]
    assert set(document.valid_results()) == {1}
    edit(workspace, 3, rows=np.s_[0:6], columns=np.s_[0:50])
    steps = document.undo_stack.count()
    assert workspace.accept_run(kept) == []
    assert document.undo_stack.count() == steps


def test_accepting_a_run_of_mixed_values_leaves_every_block_up_to_date(document, workspace):
    kept = stored_run(document, parameters=QUICK)
    kept.results = {**kept.results, 2: ilf.complete(document.frame, document.labels, ilf.preset("paper")).results[2]}
    assert kept.outdated == (2,)
    document.keep_run(kept)
    workspace.accept_run(kept)
    assert document.changed_blocks() == []
    assert document.parameters_of(2) == ilf.preset("paper")


def test_restoring_takes_common_and_own_values_as_one_step(document, workspace):
    workspace.parameters.set(ilf.preset(noise=0.01))
    workspace.parameters.set_own({"smoothness": 2.0}, [2])
    kept = StoredRun(1, "Run 1", document.run(document.state.common), {}, 0.0, RUN_COLOURS[0])
    workspace.parameters.set(QUICK)
    workspace.parameters.set_own({"centred": False}, [1])
    edit(workspace, 3)
    workspace.parameters.set_own({"padding": 3.0}, [3])
    former = dict(document.blocks.own)
    assert workspace.parameters.restore(kept)
    assert document.state.common == ilf.preset(noise=0.01)
    assert document.blocks.own == {2: {"smoothness": 2.0}, 3: {"padding": 3.0}}
    assert not workspace.parameters.restore(kept), "they are the present ones"
    document.undo_stack.undo()
    assert (document.state.common, document.blocks.own) == (QUICK, former)


def test_compared_runs_are_few_and_differ_in_colour(document, workspace):
    runs = [stored_run(document, number, QUICK) for number in range(1, MAX_COMPARED + 2)]
    for kept in runs:
        document.keep_run(kept)
    workspace.current.compare_runs(runs)
    assert document.compared == runs[1:]
    assert len({kept.colour for kept in document.compared}) == MAX_COMPARED


def test_the_oldest_without_a_note_goes_when_there_are_too_many(bench, keeper, until, monkeypatch):
    monkeypatch.setattr("gui.work.run_recorder.MAX_STORED", 3)
    said: list[str] = []
    keeper.message.connect(said.append)
    for count in range(1, 6):
        bench.runs.current.start()
        until(lambda count=count: bench.document.state.runs != () and bench.document.state.runs[-1].number == count)
        if count == 1:
            bench.document.change_run(bench.document.state.runs[0], note="good")
    assert [kept.number for kept in bench.document.state.runs] == [1, 4, 5]
    assert len(said) == 1


def test_runs_go_when_they_take_too_much_memory(bench, keeper, until, monkeypatch):
    labels = bench.document.labels
    of_one = labels.nbytes + labels.size * (4 + 1)
    monkeypatch.setattr("gui.work.run_recorder.MAX_MEMORY", labels.nbytes + int(2.5 * (of_one - labels.nbytes)))
    for count in range(1, 5):
        bench.runs.current.start()
        until(lambda count=count: bench.document.state.runs != () and bench.document.state.runs[-1].number == count)
    assert [kept.number for kept in bench.document.state.runs] == [3, 4]
    assert memory_of(bench.document.state.runs) < labels.nbytes + 2.5 * (of_one - labels.nbytes)


def test_how_good_a_run_is(document, small_frame):
    kept = stored_run(document, parameters=QUICK)
    filled = kept.completion.filled
    ground_truth = kept.completion.depth + np.float32(0.02)
    ground_truth[10, 8] = np.nan
    error = ilf.expected_error(kept.completion)[filled]
    rms = math.sqrt(np.mean(error.astype(float) ** 2))
    assert measure(kept.run, kept.results, ground_truth) == pytest.approx((0.02, rms), rel=1e-4)
    assert measure(kept.run, kept.results, None) == pytest.approx((math.nan, rms), nan_ok=True)
    assert measure(kept.run, {}, ground_truth) == pytest.approx((math.nan, math.nan), nan_ok=True)


def test_the_best_run_has_filled_about_as_much_as_any(document):
    runs = [
        stored_run(document, number, QUICK, ground_truth_error=error)
        for number, error in ((1, 0.03), (2, 0.02), (3, 0.01))
    ]
    runs[2].results = {2: runs[2].results[2]}
    assert runs[2].recovered < 0.9 * runs[0].recovered
    assert best_of(runs, "ground_truth_error") == [runs[1]]
    cancelled = stored_run(document, 4, QUICK, ground_truth_error=0.01, how="cancelled")
    assert best_of([*runs, cancelled], "ground_truth_error") == [runs[1]]
    runs[0].ground_truth_error = 0.020004
    assert best_of(runs, "ground_truth_error") == [], "shown as the same number"
    runs[0].ground_truth_error = math.nan
    assert best_of(runs, "ground_truth_error") == [], "there are no two to choose from"


def test_errors_of_different_tests_are_not_compared(document):
    tests = (("areas", 0.01), ("random", 0.03), ("random", 0.02))
    runs = [
        stored_run(document, number, QUICK, hold_out_error=error, hold_out_test=ilf.HoldOutTest(test))
        for number, (test, error) in enumerate(tests, 1)
    ]
    assert best_of(runs, "hold_out_error") == [runs[2]]
    assert best_of(runs[:2], "hold_out_error") == []


def test_the_list_as_a_table(document, workspace, tmp_path):
    for number, parameters in ((1, ilf.preset()), (2, ilf.preset("paper", max_iterations=3))):
        note = 'a, "b"' if number == 1 else "=1+1"
        document.keep_run(stored_run(document, number, parameters, note=note, ground_truth_error=0.0123))
    path = tmp_path / "runs.csv"
    write_runs(path, document, document.state.runs)
    with path.open(newline="") as file:
        second, first = csv.DictReader(file)
    assert (first["name"], first["note"], first["rmse_truth [mm]"], first["rmse_hold_out [mm]"]) == (
        "Run 1",
        'a, "b"',
        "12.300",
        "",
    )
    assert second["note"] == "'=1+1", "no formula"
    assert (second["preset"], second["values"], second["max_iterations"]) == (
        "paper",
        "paper, max. iterations 3",
        "3",
    )
    assert (first["smoothness [x]"], second["smoothness [x]"]) == ("1.0", "")
    with pytest.raises(ExportError, match="cannot be created"):
        write_runs(tmp_path / "runs.csv" / "runs.csv", document, document.state.runs)


def test_an_empty_table_has_the_heading_of_the_names(qtbot):
    table = RunView()
    qtbot.addWidget(table)
    table.resize(360, 200)
    table.show_runs(None)
    assert table.columnWidth(RunColumn.NAME) >= table.fontMetrics().horizontalAdvance("Run")
