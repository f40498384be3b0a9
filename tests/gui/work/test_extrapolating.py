"""The run control guessing the rest: when it may, what comes of it, and how it is given up."""

import threading

import pytest

from gui.work import frame_runs as runs_module
from gui.work.frame_runs import RunState
from ilf.segmentation.editing.cleaning import merge

from ..scripted_runs import record


@pytest.fixture
def endless_extrapolation(monkeypatch):
    """Guesses go on for ever; not before this is set."""
    gate = threading.Event()

    def endless(*_):
        while True:
            assert gate.wait(20)
            yield record(1)

    monkeypatch.setattr(runs_module, "extrapolation_steps", endless)
    return gate


def _run_with_a_gap(bench):
    """Block 1 is run, so that the hole in block 2 stays missing."""
    bench.run_all({1})
    bench.said.clear()
    bench.finished.clear()


def test_clearing_during_a_guess_leaves_nothing(bench, until, endless_extrapolation):
    _run_with_a_gap(bench)
    bench.runs.current.extrapolate()
    bench.runs.current.clear_results()
    endless_extrapolation.set()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert bench.document.completion() is None
    assert bench.said == ["first: extrapolation cancelled."]


def test_a_guess_comes_back_with_the_blocks_that_it_is_of(bench, until):
    _run_with_a_gap(bench)
    bench.runs.current.extrapolate()
    until(lambda: bench.document.extrapolated)
    assert bench.workspace.current.edit(merge(bench.document.labels, [1, 2]), "Merge")
    assert not bench.document.extrapolated
    bench.document.undo_stack.undo()
    assert bench.document.extrapolated


def test_a_guess_can_be_cancelled(bench, until, endless_extrapolation):
    _run_with_a_gap(bench)
    before = bench.document.completion()
    bench.runs.current.extrapolate()
    bench.runs.current.cancel()
    assert bench.runs.state is RunState.STOPPING
    endless_extrapolation.set()
    until(lambda: bool(bench.said))
    assert bench.said == ["first: extrapolation cancelled."]
    assert bench.document.completion() is before
    assert bench.finished == []
    assert 0 not in {label for label, _ in bench.records}, "a guess is no block"
    bench.runs.current.start({1})
    assert bench.runs.state is RunState.RUNNING, "only the guess was to stop"
    until(lambda: len(bench.said) == 2)


def test_a_guess_of_blocks_that_were_edited_meanwhile_is_not_shown(bench, until):
    _run_with_a_gap(bench)
    bench.runs.current.extrapolate()
    bench.workspace.current.edit(merge(bench.document.labels, [1, 2], frozenset()), "Merge")
    until(lambda: bool(bench.said))
    assert "extrapolate again" in bench.said[0]
    assert not bench.document.extrapolated
    assert bench.finished == []


def test_a_run_that_is_to_be_dense_guesses_the_rest_at_its_end(bench, until):
    bench.document.change(extrapolate=True)
    bench.script.allow()
    bench.runs.current.start({1})
    until(lambda: len(bench.said) == 2)
    assert "run finished" in bench.said[0]
    assert "extrapolated" in bench.said[1]
    assert bench.finished == [bench.document], "once, when all is done"
    bench.runs.current.start({2})
    bench.runs.current.cancel()
    until(lambda: len(bench.said) == 3)
    assert bench.runs.state is RunState.IDLE, "a run that was cancelled does not end with a guess"


def test_a_guess_waits_for_the_re_solve_under_way(bench, until):
    _run_with_a_gap(bench)
    bench.runs.current.resolve([1])
    bench.runs.current.extrapolate()
    until(lambda: bool(bench.said))
    assert bench.document.extrapolated
