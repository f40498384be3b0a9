"""The run control solving a block anew: of many values the last, and a run comes first."""

import threading

import pytest

from gui.work import frame_runs as runs_module
from gui.work.frame_runs import RunState
from ilf import preset


def test_of_many_values_the_last_is_solved_after_the_one_under_way(bench, until, monkeypatch):
    monkeypatch.setattr(runs_module, "_PATIENCE_MS", 60_000)  # however busy the machine is
    for limit in (3, 4, 5, 6):
        bench.workspace.parameters.set(preset("paper", max_iterations=limit))
        bench.runs.current.resolve([1])
    bench.script.allow()
    until(lambda: len(bench.resolved) == 2)
    assert [steps.run.parameters.max_iterations for steps in bench.script.runs] == [3, 6]


def test_a_re_solve_that_takes_too_long_gives_way_after_a_while(bench, until, clock):
    bench.script.records = 1000
    bench.runs.current.resolve([1])
    bench.get_going()
    clock[0] += 0.05
    bench.runs.current.resolve([1])
    assert bench.patience.isActive()
    assert bench.patience.interval() == 100, "150 ms from the beginning of the one under way"
    bench.runs.current.resolve([1])
    assert bench.patience.interval() == 100, "more values give it no more time"
    until(lambda: not bench.patience.isActive())
    bench.script.allow(1)
    until(lambda: len(bench.script.runs) == 2)
    assert bench.resolved == []
    assert not bench.patience.isActive()
    clock[0] += 10.0
    bench.runs.current.resolve([1])
    assert not bench.patience.isActive(), "one that is old already ends at once"
    bench.script.allow(1)
    until(lambda: len(bench.script.runs) == 3)


def test_what_a_re_solve_shows_stays_until_the_next_one_of_the_frame_shows_something(bench, until, clock):
    bench.script.records = 1000
    results = bench.document.results
    bench.runs.current.resolve([1])
    clock[0] += 1.0
    bench.script.allow(1)
    until(lambda: 1 in results.previews)
    bench.runs.current.resolve([1])
    bench.script.allow(1)
    until(lambda: len(bench.script.runs) == 2)
    assert 1 in results.previews
    assert results.running == []
    bench.runs.current.cancel()
    bench.rest(1)
    assert results.previews == {}


@pytest.mark.parametrize("stepwise", [False, True])
def test_a_run_takes_the_place_of_a_re_solve_and_keeps_it(bench, until, stepwise):
    bench.script.records = 1000
    bench.runs.current.resolve([1])
    bench.get_going()
    bench.runs.current.start({2}, stepwise)
    assert not bench.patience.isActive(), "at once"
    bench.runs.current.resolve([1])
    bench.script.records = 1
    bench.script.allow()
    if stepwise:
        until(lambda: bench.runs.state is RunState.PAUSED)
        bench.runs.of(bench.document).toggle_pause()
    until(lambda: bool(bench.said))
    until(lambda: bool(bench.resolved))
    asked = [list(steps.run.only) for steps in bench.script.runs]
    assert asked == [[1], [2], [1]], "values that came later wait for it"


def test_what_is_to_follow_follows_also_when_the_user_turns_to_another_frame(bench, until):
    bench.runs.current.resolve([1])
    bench.runs.current.resolve([2])
    second = bench.open("second")
    assert bench.runs.state is RunState.IDLE, "of the second"
    bench.script.allow()
    until(lambda: set(bench.document.valid_results()) == {1, 2})
    assert second.valid_results() == {}


def test_cancelling_a_re_solve_drops_what_was_to_follow(bench):
    bench.script.records = 1000
    bench.runs.current.resolve([1])
    bench.runs.current.resolve([1])
    bench.runs.current.cancel()
    bench.rest(1)
    assert len(bench.script.runs) == 1
    assert (bench.resolved, bench.said) == ([], [])


def test_what_was_to_follow_a_re_solve_that_breaks_is_dropped(bench, until):
    bench.script.error = MemoryError("no room")
    bench.runs.current.resolve([1])
    bench.runs.current.resolve([1])
    bench.patience.stop()  # however slowly the first one begins
    bench.script.allow()
    until(lambda: bool(bench.failed))
    assert len(bench.script.runs) == 1
    assert bench.said == []


def test_clearing_drops_the_result_that_a_re_solve_is_about_to_give(bench, until):
    bench.run_all()
    bench.runs.current.resolve([1])
    threads = [thread for thread in threading.enumerate() if thread.name == "ilf-worker"]
    for thread in threads:
        thread.join()  # the result is there, and waits for the window to take it
    bench.runs.current.clear_results()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert bench.document.valid_results() == {}
    bench.runs.current.resolve([1])
    until(lambda: bool(bench.resolved))
    assert set(bench.document.valid_results()) == {1}, "only that one was given up"


def test_clearing_during_a_run_forgets_what_is_done_and_the_run_goes_on(bench):
    bench.run_first_block()
    bench.runs.current.clear_results()
    assert bench.runs.state is RunState.RUNNING
    bench.finish()
    assert set(bench.document.valid_results()) == {2}


def test_edited_blocks_are_solved_in_order_and_what_was_left_comes_after_them(bench):
    bench.script.records = 1000
    bench.runs.current.resolve([2, 1])
    bench.get_going(2)
    bench.runs.current.resolve([1], edited=True)
    assert not bench.patience.isActive(), "at once"
    bench.script.records = 1
    bench.rest()
    assert [list(steps.run.only) for steps in bench.script.runs] == [[2, 1], [1, 2]]
    assert set(bench.document.valid_results()) == {1, 2}
