"""The run control with scripted runs: what it starts, holds, drops and brings to the workspace, and what it says."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from pytestqt.qtbot import QtBot

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work import runs as runs_module
from gui.work.runs import RunController, RunState
from ilf import RGBDFrame, preset
from ilf.blocks import Block, find_blocks
from ilf.completion import BlockOutcome, BlockResult, Completion, Progress, Status, compose
from ilf.ebs.edit import merge
from ilf.filter.convergence import IterationRecord
from ilf.filter.stepper import edge_parameters
from ilf.parameters import BlockParameters
from ilf.run import Run

WAIT_MS = 4000


def _record(i: int) -> IterationRecord:
    return IterationRecord(i, 1, 0.01 / i, 1.0, 0.0, np.nan, 0.0)


class Script:
    """What the scripted runs have been asked for, and how far they may go.

    Every block takes `records` iterations, one after the other in rising order of labels; each step waits for `allow`.
    """

    def __init__(self) -> None:
        self.records = 2
        self.error: Exception | None = None
        self.runs: list[ScriptedSteps] = []
        self._steps = threading.Semaphore(0)

    def allow(self, steps: int = 100_000) -> None:
        self._steps.release(steps)

    def wait(self) -> None:
        assert self._steps.acquire(timeout=20)
        if self.error is not None:
            raise self.error


class ScriptedSteps(Iterator[Progress]):
    """Takes the place of `ilf.run.RunSteps`."""

    def __init__(self, script: Script, run: Run, threads: int | None) -> None:
        self.run = run
        self.threads = threads
        blocks = find_blocks(run.blocks)
        self.blocks = {label: block for label, block in blocks.items() if run.only is None or label in run.only}
        self.results: dict[int, BlockResult] = {}
        self.previews = 0
        self.closed = False
        self._script = script
        self._live: list[Block] = []
        self._all = self._steps()
        script.runs.append(self)

    def _steps(self) -> Iterator[Progress]:
        for label, block in self.blocks.items():
            self._live = [block]
            for i in range(1, self._script.records + 1):
                self._script.wait()
                yield Progress(label, record=_record(i))
            self._script.wait()
            self._live = []
            self.results[label] = self._result(label, block)
            yield Progress(label, result=self.results[label])

    def _result(self, label: int, block: Block) -> BlockResult:
        depth = np.full(np.count_nonzero(block.mask), 2.0, np.float32)
        count = self._script.records
        outcome = BlockOutcome(label, Status.COMPLETED, "", depth.size, 0, depth.size, count, 1, 0.001)
        history = tuple(_record(i) for i in range(1, count + 1))
        parameters = self.run.parameters_of(label)
        edges = edge_parameters(parameters, self.run.extraction)
        return BlockResult(block, depth, outcome, history, parameters, edges=edges)

    def preview(self) -> list[tuple[Block, NDArray[np.float32]]]:
        self.previews += 1
        return [(block, np.full(np.count_nonzero(block.mask), 1.5, np.float32)) for block in self._live]

    def completion(self) -> Completion:
        return compose(self.run.frame, self.results)

    def __next__(self) -> Progress:
        return next(self._all)

    def __enter__(self) -> ScriptedSteps:
        return self

    def __exit__(self, *_: object) -> None:
        self.closed = True


class Bench:
    """A workspace with one frame of two blocks, the run control, and all that it says."""

    def __init__(self, frame: RGBDFrame, labels: NDArray[np.int32], script: Script) -> None:
        self.frame, self.labels, self.script = frame, labels, script
        self.workspace = Workspace()
        self.session = self.open("first")
        self.runs = RunController(self.workspace)
        self.said: list[str] = []
        self.resolved: list[str] = []
        self.failed: list[Exception] = []
        self.finished: list[Session] = []
        self.records: list[tuple[int, list[int]]] = []
        self.states: list[RunState] = []
        runs = self.runs
        runs.ended.connect(self.said.append)
        runs.resolved.connect(self.resolved.append)
        runs.failed.connect(self.failed.append)
        runs.finished.connect(self.finished.append)
        runs.records.connect(lambda label, records: self.records.append((label, [record.i for record in records])))
        runs.state_changed.connect(lambda: self.states.append(runs.state))

    def open(self, name: str) -> Session:
        frame = replace(self.frame, name=name)
        session = Session.of(Run(frame, self.labels), None, name)
        self.workspace.add_session(session)
        return session

    @property
    def run(self) -> ScriptedSteps:
        """The latest run."""
        return self.script.runs[-1]


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Script:
    script = Script()
    monkeypatch.setattr(Run, "steps", lambda run, threads=None: ScriptedSteps(script, run, threads))
    return script


@pytest.fixture
def bench(qtbot: QtBot, small_frame: RGBDFrame, small_labels: NDArray[np.int32], script: Script) -> Iterator[Bench]:
    bench = Bench(small_frame, small_labels, script)
    yield bench
    script.allow()
    assert bench.runs.shutdown()


@pytest.fixture
def until(qtbot: QtBot) -> Callable[[Callable[[], bool]], None]:
    return lambda condition: qtbot.waitUntil(condition, timeout=WAIT_MS)


Until = Callable[[Callable[[], bool]], None]


# starting and ending


def test_a_run_goes_over_all_blocks_with_their_parameters_and_leaves_one_core(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs_module, "available_cores", lambda: 6)
    own = preset("paper", max_iterations=7)
    bench.workspace.set_parameters(preset("released-code"))
    bench.workspace.set_parameters(own, 2)
    assert bench.runs.free
    bench.runs.start()
    assert bench.runs.state is RunState.RUNNING
    assert not bench.runs.free
    assert bench.runs.session is bench.session
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert bench.run.threads == 5
    assert set(bench.run.blocks) == {1, 2}
    assert bench.run.run.parameters_of(1) == preset("released-code")
    assert bench.run.run.parameters_of(2) == own
    assert bench.run.closed
    assert not bench.run.run.dense
    assert set(bench.session.valid_results()) == {1, 2}
    assert bench.said[0].startswith("first: run finished, 2 blocks in ")
    assert "edited" not in bench.said[0]
    assert bench.finished == [bench.session]
    assert bench.runs.state is RunState.IDLE
    assert bench.states[0] is RunState.RUNNING
    assert bench.states[-1] is RunState.IDLE
    assert (bench.runs.session, bench.session.results.running, bench.runs.share_done) == (None, [], 0.0)


def test_with_one_core_a_run_has_that_one(bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs_module, "available_cores", lambda: 1)
    bench.script.allow()
    bench.runs.start()
    until(lambda: bool(bench.said))
    assert bench.run.threads == 1


def test_chosen_blocks_alone_are_run(bench: Bench, until: Until) -> None:
    bench.workspace.select([2, 9])
    bench.script.allow()
    bench.runs.start_chosen()
    until(lambda: bool(bench.said))
    assert bench.run.run.only == {2}
    assert set(bench.session.valid_results()) == {2}
    assert ", 1 block in " in bench.said[0]


def test_records_results_and_progress_come_as_they_are_made(bench: Bench, until: Until) -> None:
    results = bench.session.results
    bench.runs.start()
    assert bench.runs.queued == {1, 2}
    bench.script.allow(2)
    until(lambda: len(results.live.get(1, [])) == 2)
    assert (results.running, bench.runs.queued, bench.runs.share_done) == ([1], {2}, 0.0)
    bench.script.allow(1)
    until(lambda: 1 in bench.session.valid_results())
    assert (results.running, bench.runs.queued, bench.runs.share_done) == ([], {2}, 0.5)
    bench.script.allow(1)
    until(lambda: results.running == [2])
    assert bench.runs.queued == set()
    bench.script.allow()
    until(lambda: bool(bench.said))
    numbers = {label: [i for other, batch in bench.records if other == label for i in batch] for label in (1, 2)}
    assert numbers == {1: [1, 2], 2: [1, 2]}


def test_a_run_that_breaks_keeps_what_is_done_and_tells_why(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.script.allow(3)
    until(lambda: 1 in bench.session.valid_results())
    bench.script.error = MemoryError("no room")
    bench.script.allow()
    until(lambda: bool(bench.failed))
    assert str(bench.failed[0]) == "no room"
    assert bench.said[0].startswith("first: run failed, 1 block in ")
    assert set(bench.session.valid_results()) == {1}
    assert bench.finished == []
    assert bench.run.closed
    assert (bench.runs.state, bench.session.results.running) == (RunState.IDLE, [])


# holding


def test_stepping_holds_after_every_step_and_pausing_and_going_on_turn_it(bench: Bench, until: Until) -> None:
    bench.script.records = 50
    results = bench.session.results
    bench.script.allow()
    bench.workspace.select([2])
    bench.runs.step()
    until(lambda: bench.runs.state is RunState.PAUSED and len(results.live.get(2, [])) == 1)
    assert bench.run.run.only == {2}
    assert bench.run.threads == 1
    assert not bench.runs.free
    bench.runs.step()
    until(lambda: len(results.live[2]) == 2)
    until(lambda: bench.runs.state is RunState.PAUSED)
    assert len(bench.script.runs) == 1, "a step of the run under way is no new run"
    bench.runs.toggle_pause()
    until(lambda: bool(bench.said))
    assert len(bench.session.valid_results()[2].history) == 50


def test_without_a_choice_stepping_goes_over_all_blocks(bench: Bench, until: Until) -> None:
    bench.script.allow()
    bench.runs.step()
    until(lambda: bench.runs.state is RunState.PAUSED)
    assert bench.run.run.only is None
    bench.runs.cancel()
    until(lambda: bool(bench.said))


def test_a_pause_is_told_at_once_and_holds(bench: Bench, until: Until, qtbot: QtBot) -> None:
    bench.script.records = 1000
    bench.runs.start()
    bench.script.allow(3)
    until(lambda: len(bench.session.results.live.get(1, [])) == 3)
    bench.states.clear()
    bench.runs.toggle_pause()
    assert bench.states == [RunState.PAUSED]
    bench.script.allow(500)
    qtbot.wait(120)
    held = len(bench.session.results.live[1])
    assert held <= 4, "the step under way, and no more"
    qtbot.wait(80)
    assert len(bench.session.results.live[1]) == held
    bench.states.clear()
    bench.runs.toggle_pause()
    assert bench.states == [RunState.RUNNING]
    until(lambda: len(bench.session.results.live[1]) > 100)
    bench.runs.cancel()
    bench.script.allow()
    until(lambda: bool(bench.said))


def test_cancelling_keeps_the_blocks_that_are_done(bench: Bench, until: Until) -> None:
    bench.runs.cancel()
    assert bench.states == [], "there is nothing to cancel"
    bench.runs.start()
    bench.script.allow(4)
    until(lambda: bench.session.results.running == [2])
    bench.runs.cancel()
    assert bench.runs.state is RunState.STOPPING
    assert not bench.runs.free
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert bench.said[0].startswith("first: run cancelled, 1 block in ")
    assert set(bench.session.valid_results()) == {1}
    assert bench.session.results.running == []
    assert bench.finished == []
    assert bench.runs.state is RunState.IDLE, "and the next run does not stop"
    bench.runs.start()
    until(lambda: len(bench.said) == 2)
    assert "finished" in bench.said[1]


# previews


def test_previews_come_now_and_then_and_go_with_the_run(
    bench: Bench, until: Until, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [0.0]
    monkeypatch.setattr(runs_module.time, "perf_counter", lambda: clock[0])
    bench.script.records = 1000
    results = bench.session.results
    bench.runs.start()
    bench.script.allow(1)
    until(lambda: 1 in results.previews)
    assert (bench.session.present_depth()[:, :30] == 1.5).all()
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
    bench.runs.cancel()
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert results.previews == {}
    assert bench.session.present_depth() is None


def test_a_re_solve_shows_its_first_preview_after_a_tenth_of_a_second(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [50.0]
    monkeypatch.setattr(runs_module.time, "perf_counter", lambda: clock[0])
    bench.script.records = 1000
    live = bench.session.results.live
    bench.runs.resolve(1)
    clock[0] += 0.0999
    bench.script.allow(2)
    until(lambda: len(live.get(1, [])) == 2)
    assert bench.run.previews == 0
    clock[0] += 0.0002
    bench.script.allow(1)
    until(lambda: len(live[1]) == 3)
    assert bench.run.previews == 1


# edits and frames during a run


def test_results_of_blocks_that_were_edited_meanwhile_are_told_as_lost(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.script.allow(1)
    until(lambda: bench.session.results.running == [1])
    bench.workspace.edit_labels(merge(bench.session.labels, [1, 2], frozenset()), "Merge")
    assert (bench.run.run.blocks == bench.labels).all(), "the run has blocks of its own"
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert bench.said[0].endswith(" 2 had been edited meanwhile: run them again.")
    assert bench.session.valid_results() == {}
    bench.workspace.undo_group.undo()
    assert set(bench.session.valid_results()) == {1, 2}, "undo brings them back"


def test_results_go_to_the_frame_that_runs_wherever_the_user_has_turned(bench: Bench, until: Until) -> None:
    bench.runs.start()
    second = bench.open("second")
    seen: list[str] = []
    for name in ("results_changed", "results_added", "records_added", "previews_changed"):
        getattr(bench.workspace, name).connect(lambda *_, name=name: seen.append(name))
    listed: list[int] = []
    bench.workspace.sessions_changed.connect(lambda: listed.append(len(bench.session.valid_results())))
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert bench.said[0].startswith("first: ")
    assert set(bench.session.valid_results()) == {1, 2}
    assert second.valid_results() == {}
    assert seen == [], "nothing of the frame that is shown has changed"
    assert listed[-1] == 2


def test_results_of_a_frame_that_was_closed_meanwhile_trouble_nobody(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.script.allow(1)
    until(lambda: bench.session.results.running == [1])
    bench.workspace.close_session(bench.session)
    assert bench.runs.state is RunState.STOPPING
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert "run cancelled" in bench.said[0]
    assert bench.workspace.sessions == []
    assert bench.runs.state is RunState.IDLE


def test_a_run_goes_on_while_other_frames_are_opened_and_closed(bench: Bench, until: Until) -> None:
    bench.runs.start()
    other = bench.open("second")
    bench.workspace.close_session(other)
    assert bench.runs.state is RunState.RUNNING
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert "run finished" in bench.said[0]


# solving anew


def test_a_re_solve_runs_one_block_and_says_how_fast(bench: Bench, until: Until) -> None:
    bench.runs.resolve(2)
    assert bench.runs.state is RunState.RESOLVING
    assert bench.runs.free, "a run may take its place"
    assert bench.runs.resolving == 2
    assert bench.runs.queued == set()
    bench.script.allow()
    until(lambda: bool(bench.resolved))
    assert (bench.run.run.only, bench.run.threads) == ({2}, 1)
    assert bench.resolved[0].startswith("Block 2: 2 iterations in ")
    assert bench.said == []
    assert bench.finished == []
    assert set(bench.session.valid_results()) == {2}
    assert (bench.runs.resolving, bench.runs.state) == (0, RunState.IDLE)


def test_nothing_is_solved_anew_during_a_run(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.runs.resolve(1)
    assert bench.runs.state is RunState.RUNNING
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert len(bench.script.runs) == 1
    assert bench.resolved == []


def test_of_many_values_the_last_is_solved_after_the_one_under_way(bench: Bench, until: Until) -> None:
    for limit in (3, 4, 5, 6):
        bench.workspace.set_parameters(preset("paper", max_iterations=limit))
        bench.runs.resolve(1)
    assert len(bench.script.runs) == 1
    bench.script.allow()
    until(lambda: len(bench.resolved) == 2)
    assert [steps.run.parameters.max_iterations for steps in bench.script.runs] == [3, 6]


def test_a_re_solve_that_takes_too_long_gives_way_after_a_while(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [0.0]
    monkeypatch.setattr(runs_module.time, "perf_counter", lambda: clock[0])
    bench.script.records = 1000
    bench.runs.resolve(1)
    bench.script.allow(1)
    until(lambda: bench.session.results.running == [1])
    clock[0] = 0.05
    bench.runs.resolve(1)
    assert bench.runs._patience.isActive()
    assert bench.runs._patience.interval() == 100, "150 ms from the beginning of the one under way"
    bench.runs.resolve(1)
    assert bench.runs._patience.interval() == 100, "more values give it no more time"
    until(lambda: not bench.runs._patience.isActive())
    bench.script.allow(1)
    until(lambda: len(bench.script.runs) == 2)
    assert bench.resolved == []
    assert not bench.runs._patience.isActive()
    clock[0] = 10.0
    bench.runs.resolve(1)
    assert not bench.runs._patience.isActive(), "one that is old already ends at once"
    bench.script.allow(1)
    until(lambda: len(bench.script.runs) == 3)


def test_what_a_re_solve_shows_stays_until_the_next_one_of_the_frame_shows_something(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [0.0]
    monkeypatch.setattr(runs_module.time, "perf_counter", lambda: clock[0])
    bench.script.records = 1000
    results = bench.session.results
    bench.runs.resolve(1)
    clock[0] = 1.0
    bench.script.allow(1)
    until(lambda: 1 in results.previews)
    bench.runs.resolve(1)
    bench.script.allow(1)
    until(lambda: len(bench.script.runs) == 2)
    assert 1 in results.previews
    assert results.running == []
    bench.runs.cancel()
    bench.script.allow(1)
    until(lambda: bench.runs.state is RunState.IDLE)
    assert results.previews == {}


@pytest.mark.parametrize("stepwise", [False, True])
def test_a_run_takes_the_place_of_a_re_solve_and_keeps_it(bench: Bench, until: Until, stepwise: bool) -> None:
    bench.script.records = 1000
    bench.runs.resolve(1)
    bench.script.allow(1)
    until(lambda: bench.session.results.running == [1])
    bench.runs.start({2}, stepwise)
    assert not bench.runs._patience.isActive(), "at once"
    bench.runs.resolve(1)
    bench.script.records = 1
    bench.script.allow()
    if stepwise:
        until(lambda: bench.runs.state is RunState.PAUSED)
        bench.runs.resume()
    until(lambda: bool(bench.said))
    assert [steps.run.only for steps in bench.script.runs] == [{1}, {2}], "values that came later do not push it aside"
    assert bench.resolved == []


def test_what_is_to_follow_is_dropped_when_the_user_turns_to_another_frame(bench: Bench, until: Until) -> None:
    bench.runs.resolve(1)
    bench.runs.resolve(2)
    second = bench.open("second")
    bench.script.allow()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert len(bench.script.runs) == 1
    assert set(bench.session.valid_results()) == {1}
    assert second.valid_results() == {}


def test_cancelling_a_re_solve_drops_what_was_to_follow(bench: Bench, until: Until) -> None:
    bench.script.records = 1000
    bench.runs.resolve(1)
    bench.runs.resolve(1)
    bench.runs.cancel()
    bench.script.allow(1)
    until(lambda: bench.runs.state is RunState.IDLE)
    assert len(bench.script.runs) == 1
    assert (bench.resolved, bench.said) == ([], [])


def test_what_was_to_follow_a_re_solve_that_breaks_is_dropped(bench: Bench, until: Until) -> None:
    bench.script.error = MemoryError("no room")
    bench.runs.resolve(1)
    bench.runs.resolve(1)
    bench.script.allow()
    until(lambda: bool(bench.failed))
    assert len(bench.script.runs) == 1
    assert bench.said == []


def test_clearing_drops_the_result_that_a_re_solve_is_about_to_give(bench: Bench, until: Until) -> None:
    bench.script.allow()
    bench.runs.start()
    until(lambda: bool(bench.said))
    bench.runs.resolve(1)
    threads = [thread for thread in threading.enumerate() if thread.name == "ilf-worker"]
    for thread in threads:
        thread.join()  # the result is there, and waits for the window to take it
    bench.runs.clear_results()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert bench.session.valid_results() == {}
    bench.runs.resolve(1)
    until(lambda: bool(bench.resolved))
    assert set(bench.session.valid_results()) == {1}, "only that one was given up"


def test_clearing_one_frame_leaves_the_re_solve_of_another(bench: Bench, until: Until) -> None:
    bench.runs.resolve(1)
    bench.open("second")
    bench.runs.clear_results()
    bench.script.allow()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert set(bench.session.valid_results()) == {1}


def test_clearing_during_a_run_forgets_what_is_done_and_the_run_goes_on(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.script.allow(3)
    until(lambda: 1 in bench.session.valid_results())
    bench.runs.clear_results()
    assert bench.runs.state is RunState.RUNNING
    bench.script.allow()
    until(lambda: bool(bench.said))
    assert set(bench.session.valid_results()) == {2}


# the guess


def _run_with_a_gap(bench: Bench, until: Until) -> None:
    """Block 1 is run, so that the hole in block 2 stays missing."""
    bench.script.allow()
    bench.runs.start({1})
    until(lambda: bench.runs.state is RunState.IDLE)
    bench.said.clear()
    bench.finished.clear()


def test_the_rest_is_guessed_and_marked_and_goes_when_results_change(bench: Bench, until: Until) -> None:
    bench.runs.guess()
    assert bench.states == [], "nothing has been run"
    _run_with_a_gap(bench, until)
    missing = np.isnan(bench.session.completion().depth)
    bench.runs.guess()
    assert bench.runs.state is RunState.GUESSING
    assert bench.runs.session is bench.session
    until(lambda: bool(bench.said))
    completion = bench.session.completion()
    assert np.array_equal(completion.guessed, missing)
    assert np.isfinite(completion.depth).all()
    assert bench.session.guessed
    assert bench.session.run(bench.workspace.parameters, dense=True).dense
    assert bench.said[0].startswith(f"first: {np.count_nonzero(missing)} pixels guessed in ")
    assert bench.finished == [bench.session]
    assert bench.runs.state is RunState.IDLE
    bench.runs.guess()
    assert bench.runs.state is RunState.IDLE, "there is nothing left to guess"
    bench.runs.resolve(1)
    until(lambda: bool(bench.resolved))
    assert not bench.session.guessed
    assert not bench.session.completion().guessed.any()


def test_a_guess_sees_the_edges_of_the_extraction(bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []

    def nothing(frame: RGBDFrame, completion: Completion, extraction: object) -> Iterator[IterationRecord]:
        asked.append(extraction)
        yield _record(1)

    monkeypatch.setattr(runs_module, "guess_steps", nothing)
    bench.session.notes.extraction = BlockParameters(depth_jump=0.3)
    _run_with_a_gap(bench, until)
    bench.runs.guess()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert asked == [BlockParameters(depth_jump=0.3)]


def test_clearing_during_a_guess_leaves_nothing_to_be_saved(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate = threading.Event()

    def endless(*_: object) -> Iterator[IterationRecord]:
        while True:
            assert gate.wait(20)
            yield _record(1)

    monkeypatch.setattr(runs_module, "guess_steps", endless)
    _run_with_a_gap(bench, until)
    bench.runs.guess()
    bench.runs.clear_results()
    gate.set()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert bench.session.completion() is None
    assert not bench.session.unsaved
    assert bench.said == ["first: guess of the rest cancelled."]


def test_a_guess_comes_back_with_the_blocks_that_it_is_of(bench: Bench, until: Until) -> None:
    _run_with_a_gap(bench, until)
    bench.runs.guess()
    until(lambda: bench.session.guessed)
    assert bench.workspace.edit_labels(merge(bench.session.labels, [1, 2]), "Merge")
    assert not bench.session.guessed
    bench.session.undo_stack.undo()
    assert bench.session.guessed


def test_a_guess_can_be_cancelled(bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch) -> None:
    gate = threading.Event()

    def endless(*_: object) -> Iterator[IterationRecord]:
        while True:
            assert gate.wait(20)
            yield _record(1)

    monkeypatch.setattr(runs_module, "guess_steps", endless)
    _run_with_a_gap(bench, until)
    before = bench.session.completion()
    bench.runs.guess()
    bench.runs.cancel()
    assert bench.runs.state is RunState.STOPPING
    gate.set()
    until(lambda: bool(bench.said))
    assert bench.said == ["first: guess of the rest cancelled."]
    assert bench.session.completion() is before
    assert bench.finished == []
    assert 0 not in {label for label, _ in bench.records}, "a guess is no block"
    bench.runs.start({1})
    assert bench.runs.state is RunState.RUNNING, "only the guess was to stop"
    until(lambda: len(bench.said) == 2)


def test_a_guess_of_blocks_that_were_edited_meanwhile_is_not_shown(bench: Bench, until: Until) -> None:
    _run_with_a_gap(bench, until)
    bench.runs.guess()
    bench.workspace.edit_labels(merge(bench.session.labels, [1, 2], frozenset()), "Merge")
    until(lambda: bool(bench.said))
    assert "guess again" in bench.said[0]
    assert not bench.session.guessed
    assert bench.finished == []


def test_a_run_that_is_to_be_dense_guesses_the_rest_at_its_end(bench: Bench, until: Until) -> None:
    bench.session.dense = True
    bench.script.allow()
    bench.runs.start({1})
    until(lambda: len(bench.said) == 2)
    assert "run finished" in bench.said[0]
    assert "guessed" in bench.said[1]
    assert bench.finished == [bench.session], "once, when all is done"
    bench.runs.start({2})
    bench.runs.cancel()
    until(lambda: len(bench.said) == 3)
    assert bench.runs.state is RunState.IDLE, "a run that was cancelled does not end with a guess"


def test_a_guess_waits_for_the_re_solve_under_way(bench: Bench, until: Until) -> None:
    _run_with_a_gap(bench, until)
    bench.runs.resolve(1)
    bench.runs.guess()
    until(lambda: bool(bench.said))
    assert bench.session.guessed


def test_how_long_it_took_is_said(bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [100.0]
    monkeypatch.setattr(runs_module.time, "perf_counter", lambda: clock[0])
    for begin, word in (
        (lambda: bench.runs.start({1}), "1 block in 1.5 s."),
        (bench.runs.guess, "guessed in 1.5 s;"),
    ):
        begin()
        clock[0] += 1.5
        bench.script.allow()
        until(lambda: bool(bench.said))
        assert word in bench.said.pop()
    bench.runs.resolve(1)
    clock[0] += 0.25
    until(lambda: bool(bench.resolved))
    assert bench.resolved[0].endswith("in 250 ms")


# the end


def test_shutdown_ends_the_thread_and_says_nothing(bench: Bench, qtbot: QtBot) -> None:
    bench.script.records = 100_000
    bench.script.allow(200_000)
    bench.runs.start()
    assert bench.runs.shutdown()
    assert bench.runs.state is RunState.IDLE
    assert bench.run.closed
    qtbot.wait(60)
    assert bench.said == []


def test_shutdown_stops_the_patience(bench: Bench, until: Until) -> None:
    bench.script.records = 1000
    bench.runs.resolve(1)
    bench.script.allow(1)
    until(lambda: bench.session.results.running == [1])
    bench.runs.resolve(1)
    assert bench.runs._patience.isActive()
    bench.script.allow()
    assert bench.runs.shutdown()
    assert not bench.runs._patience.isActive()
