"""The window's run control, over a run that goes on step by step as a test lets it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work import runs as module
from gui.work.runs import RunController, RunState
from ilf.completion import BlockResult, Completion, Progress, complete
from ilf.frame import RGBDFrame
from ilf.parameters import BlockParameters, preset
from ilf.run import Run

QUICK = preset("paper", max_iterations=2)
WAIT_MS = 10_000


class Steps:
    """A run whose every `next()` waits until the test lets it go on."""

    def __init__(self, blocks: set[int], script: list[Progress | Exception]) -> None:
        self.blocks = dict.fromkeys(sorted(blocks))
        self.results: dict[int, BlockResult] = {}
        self.previews: list[Any] = []
        self.closed = False
        self._script = iter(script)
        self._gate = threading.Semaphore(0)

    def let_go(self, steps: int = 1) -> None:
        """So many steps may be taken."""
        self._gate.release(steps)

    def __iter__(self) -> Iterator[Progress]:
        return self

    def __next__(self) -> Progress:
        assert self._gate.acquire(timeout=20), "the test did not let the run go on"
        step = next(self._script)
        if isinstance(step, Exception):
            raise step
        if step.result is not None:
            self.results[step.label] = step.result
        return step

    def preview(self) -> list[Any]:
        return self.previews

    def __enter__(self) -> Steps:
        return self

    def __exit__(self, *_: object) -> None:
        self.closed = True


class Bench:
    """A workspace with a frame of two blocks, its run control, what it sends, and the runs that it has begun."""

    def __init__(self, session: Session, other: Session) -> None:
        self.session, self.other = session, other
        self.workspace = Workspace()
        self.workspace.add_session(other)
        self.workspace.add_session(session)
        self.runs = RunController(self.workspace)
        self.results = complete(session.frame, session.labels, QUICK).results
        self.begun: list[Steps] = []
        self.asked: list[tuple[set[int] | None, int]] = []
        self.said: list[tuple[str, Any]] = []
        self.changes = 0
        for name in ("ended", "resolved", "finished", "failed"):
            getattr(self.runs, name).connect(lambda what, name=name: self.said.append((name, what)))
        self.runs.records.connect(lambda label, records: self.said.append(("records", (label, len(records)))))
        self.runs.state_changed.connect(self._count)

    def _count(self) -> None:
        self.changes += 1

    def steps_of(self, label: int, records: int = 1) -> list[Progress | Exception]:
        """Some records of a block, and its result."""
        result = self.results[label]
        return [*(Progress(label, record=result.history[0]) for _ in range(records)), Progress(label, result=result)]

    def begin(self, common: object, only: Any = None) -> SimpleNamespace:
        """In the place of `Session.run`."""
        chosen = {1, 2} if only is None else set(only)

        def steps(threads: int | None = None) -> Steps:
            self.asked.append((None if only is None else set(only), threads or 0))
            script = self.script or [step for label in sorted(chosen) for step in self.steps_of(label)]
            self.begun.append(Steps(chosen, script))
            return self.begun[-1]

        return SimpleNamespace(steps=steps)

    script: list[Progress | Exception] | None = None

    def kinds(self) -> list[str]:
        """Names of what was said, without records."""
        return [name for name, _ in self.said if name != "records"]

    def text(self, name: str) -> str:
        """The last of that name that was said."""
        return str([what for kind, what in self.said if kind == name][-1])


def session_of(frame: RGBDFrame, labels: np.ndarray, key: str) -> Session:
    return Session.of(Run(frame, labels, extraction=BlockParameters()), key, key)


@pytest.fixture
def bench(
    small_frame: RGBDFrame, small_labels: np.ndarray, qapp: object, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Bench]:
    bench = Bench(session_of(small_frame, small_labels, "one"), session_of(small_frame, small_labels, "other"))
    monkeypatch.setattr(Session, "run", lambda session, common, only=None: bench.begin(common, only))
    monkeypatch.setattr(module, "available_cores", lambda: 5)
    yield bench
    for steps in bench.begun:
        steps.let_go(100)
    bench.runs.shutdown()


@pytest.fixture
def until(qtbot: QtBot) -> Callable[[Callable[[], bool]], None]:
    """Waits until something holds."""
    return lambda holds: qtbot.waitUntil(holds, timeout=WAIT_MS)


Until = Callable[[Callable[[], bool]], None]


def test_a_run_from_start_to_end(bench: Bench, until: Until) -> None:
    runs = bench.runs
    assert (runs.state, runs.free, runs.queued, runs.share_done) == (RunState.IDLE, True, set(), 0.0)
    runs.start()
    steps = bench.begun[0]
    assert (runs.state, runs.free, runs.queued, runs.share_done) == (RunState.RUNNING, False, {1, 2}, 0.0)
    assert runs.session is bench.session
    assert bench.asked == [(None, 4)], "one core stays the window's"
    assert bench.changes == 1

    steps.let_go()
    until(lambda: bench.said == [("records", (1, 1))])
    assert (runs.queued, runs.share_done) == ({2}, 0.0)
    assert bench.session.results.running == [1]
    steps.let_go()
    until(lambda: runs.share_done == 0.5)
    assert list(bench.session.valid_results()) == [1]
    steps.let_go(3)
    until(lambda: "finished" in bench.kinds())
    assert (runs.state, runs.session, runs.queued, runs.share_done) == (RunState.IDLE, None, set(), 0.0)
    assert list(bench.session.valid_results()) == [1, 2]
    assert bench.session.results.running == []
    assert bench.kinds() == ["ended", "finished"]
    assert bench.text("ended").startswith("two-planes: run finished, 2 blocks in 0.")
    assert bench.said[-1] == ("finished", bench.session)
    assert steps.closed


def test_the_only_core_runs_too(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "available_cores", lambda: 1)
    bench.runs.start({2})
    assert bench.asked == [({2}, 1)]
    assert bench.runs.queued == {2}


def test_the_chosen_blocks_are_run(bench: Bench) -> None:
    bench.workspace.select([2, 7])
    bench.runs.start_chosen()
    assert bench.asked == [({2}, 4)], "7 is not there"


def test_one_block_is_one_block(bench: Bench, until: Until) -> None:
    bench.runs.start({2})
    bench.begun[0].let_go(3)
    until(lambda: "ended" in bench.kinds())
    assert ", 1 block in " in bench.text("ended")
    assert "edited" not in bench.text("ended")


def test_blocks_that_were_edited_meanwhile_are_pointed_out(bench: Bench, until: Until) -> None:
    bench.runs.start()
    labels = bench.session.labels.copy()
    labels[0, 0] = 0
    bench.session.set_labels(labels)
    bench.begun[0].let_go(5)
    until(lambda: "ended" in bench.kinds())
    assert bench.text("ended").endswith("s. 1 had been edited meanwhile: run them again.")


def test_cancelling_keeps_what_is_done(bench: Bench, until: Until) -> None:
    bench.runs.cancel()
    assert bench.changes == 0, "there is nothing to cancel"
    bench.runs.start()
    bench.begun[0].let_go(2)
    until(lambda: bench.runs.share_done == 0.5)
    bench.runs.cancel()
    assert bench.runs.state is RunState.STOPPING
    bench.begun[0].let_go()
    until(lambda: "ended" in bench.kinds())
    assert bench.kinds() == ["ended"], "it has not gone to its end"
    assert bench.text("ended").startswith("two-planes: run cancelled, 1 block in")
    assert list(bench.session.valid_results()) == [1]
    assert bench.runs.state is RunState.IDLE
    bench.runs.start()
    assert bench.runs.state is RunState.RUNNING, "the next run does not stop"
    assert bench.runs.queued == {1, 2}


def test_a_run_that_breaks_says_so_and_keeps_what_is_done(bench: Bench, until: Until) -> None:
    broken = MemoryError("too large")
    bench.script = [*bench.steps_of(1), broken]
    bench.runs.start()
    bench.begun[0].let_go(3)
    until(lambda: "failed" in bench.kinds())
    assert bench.kinds() == ["ended", "failed"]
    assert bench.said[-1] == ("failed", broken)
    assert "run failed, 1 block in" in bench.text("ended")
    assert list(bench.session.valid_results()) == [1]
    assert bench.runs.state is RunState.IDLE


def test_pausing_stepping_and_going_on(bench: Bench, until: Until) -> None:
    runs = bench.runs
    bench.workspace.select([1])
    runs.step()
    assert bench.asked == [({1}, 1)], "steps are of one block at a time"
    steps = bench.begun[0]
    steps.let_go(9)
    until(lambda: runs.state is RunState.PAUSED and len(bench.said) == 1)
    assert not runs.free
    changes = bench.changes
    runs.toggle_pause()
    until(lambda: "finished" in bench.kinds())
    assert bench.changes > changes

    bench.workspace.select([])
    runs.step()
    assert bench.asked[-1] == (None, 1), "all blocks if none is chosen"
    bench.begun[1].let_go()
    until(lambda: runs.state is RunState.PAUSED and bench.session.results.running == [1])
    runs.step()
    bench.begun[1].let_go()
    until(lambda: runs.share_done == 0.5)
    assert runs.state is RunState.PAUSED
    runs.resume()
    assert runs.state is RunState.RUNNING
    runs.toggle_pause()
    assert runs.state is RunState.PAUSED
    runs.toggle_pause()
    bench.begun[1].let_go(3)
    until(lambda: runs.state is RunState.IDLE)


def test_previews_come_in_their_time_and_go_with_the_run(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PREVIEWS_S", 1e9)
    result = bench.results[1]
    bench.script = [*bench.steps_of(1, records=3), *bench.steps_of(2)]
    bench.runs.start()
    steps = bench.begun[0]
    steps.previews = [(result.block, result.depth + 1)]
    steps.let_go()
    until(lambda: bool(bench.session.results.previews))
    steps.previews = [(result.block, result.depth + 2)]
    steps.let_go()
    until(lambda: len(bench.said) == 2)
    _, depth = bench.session.results.previews[1]
    np.testing.assert_array_equal(depth, result.depth + 1, "it is not time for the next yet")
    steps.let_go(5)
    until(lambda: "finished" in bench.kinds())
    assert not bench.session.results.previews


# solving anew


def test_a_block_is_solved_anew(bench: Bench, until: Until) -> None:
    runs = bench.runs
    bench.session.change_info(2, name="Wall")
    runs.resolve(2)
    assert (runs.state, runs.free, runs.resolving, runs.queued) == (RunState.RESOLVING, True, 2, set())
    assert bench.asked == [({2}, 1)]
    bench.begun[0].let_go(3)
    until(lambda: "resolved" in bench.kinds())
    assert bench.kinds() == ["resolved"], "it is no run"
    assert bench.text("resolved").startswith(f"Wall: {bench.results[2].outcome.iterations} iterations in ")
    assert bench.text("resolved").endswith(" ms")
    assert (runs.state, runs.resolving) == (RunState.IDLE, 0)
    assert list(bench.session.valid_results()) == [2]


def test_nothing_is_solved_anew_during_a_run(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.runs.resolve(2)
    bench.begun[0].let_go(5)
    until(lambda: "finished" in bench.kinds())
    assert len(bench.begun) == 1
    assert bench.runs.state is RunState.IDLE


def test_of_the_values_that_come_meanwhile_the_latest_count(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PATIENCE_MS", 0)
    bench.runs.resolve(2)
    bench.runs.resolve(2)
    bench.runs.resolve(1)
    assert len(bench.begun) == 1
    bench.begun[0].let_go()
    until(lambda: len(bench.begun) == 2)
    assert bench.asked == [({2}, 1), ({1}, 1)]
    assert "resolved" not in bench.kinds(), "the first was cut short"
    bench.begun[1].let_go(3)
    until(lambda: "resolved" in bench.kinds())
    assert len(bench.begun) == 2


def test_a_solution_under_way_may_end_if_it_takes_no_longer_than_patience(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PATIENCE_MS", 1_000_000)
    bench.runs.resolve(2)
    bench.runs.resolve(2)
    bench.begun[0].let_go(3)
    until(lambda: len(bench.begun) == 2)
    assert bench.kinds() == ["resolved"]
    bench.begun[1].let_go(3)
    until(lambda: bench.kinds() == ["resolved", "resolved"])
    assert bench.runs.state is RunState.IDLE


def test_patience_has_an_end(bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_PATIENCE_MS", 30)
    bench.script = [Progress(2, record=bench.results[2].history[0])] * 1000
    bench.runs.resolve(2)
    bench.runs.resolve(2)
    bench.script = None
    bench.begun[0].let_go(3)
    until(lambda: not bench.runs._patience.isActive())
    bench.begun[0].let_go()
    until(lambda: len(bench.begun) == 2)
    assert bench.kinds() == []


def test_a_solution_gives_way_to_a_run_which_keeps_its_place(bench: Bench, until: Until) -> None:
    bench.runs.resolve(2)
    bench.runs.start({1})
    assert bench.runs.state is RunState.RESOLVING
    bench.runs.resolve(2)
    bench.begun[0].let_go()
    until(lambda: len(bench.begun) == 2)
    assert bench.runs.state is RunState.RUNNING
    assert bench.asked == [({2}, 1), ({1}, 4)]
    bench.begun[1].let_go(3)
    until(lambda: "finished" in bench.kinds())
    assert len(bench.begun) == 2


def test_what_was_to_follow_is_dropped_with_its_frame(
    bench: Bench, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PATIENCE_MS", 1_000_000)
    bench.runs.resolve(2)
    bench.runs.resolve(1)
    bench.workspace.show_session(bench.other)
    bench.begun[0].let_go(3)
    until(lambda: "resolved" in bench.kinds())
    assert len(bench.begun) == 1
    assert list(bench.session.valid_results()) == [2]
    assert bench.other.completion() is None
    assert bench.runs.state is RunState.IDLE


def test_cancelling_drops_what_was_to_follow(bench: Bench, until: Until) -> None:
    bench.runs.resolve(2)
    bench.runs.resolve(1)
    bench.runs.cancel()
    bench.begun[0].let_go()
    until(lambda: bench.runs.state is RunState.IDLE)
    assert len(bench.begun) == 1
    assert bench.kinds() == []


def test_results_that_were_cleared_do_not_come_back(bench: Bench, until: Until) -> None:
    bench.session.add_results(list(bench.results.values()))
    bench.runs.resolve(2)
    bench.runs.clear_results()
    bench.begun[0].let_go(3)
    until(lambda: bench.runs.state is RunState.IDLE)
    assert bench.session.valid_results() == {}
    bench.runs.resolve(2)
    bench.begun[1].let_go(3)
    until(lambda: bench.runs.state is RunState.IDLE)
    assert list(bench.session.valid_results()) == [2], "the next does"


def test_clearing_during_a_run_lets_it_go_on(bench: Bench, until: Until) -> None:
    bench.runs.start()
    bench.begun[0].let_go(2)
    until(lambda: bench.runs.share_done == 0.5)
    bench.runs.clear_results()
    bench.begun[0].let_go(3)
    until(lambda: "finished" in bench.kinds())
    assert list(bench.session.valid_results()) == [2]


def test_clearing_another_frame_leaves_the_solution_alone(bench: Bench, until: Until) -> None:
    bench.runs.resolve(2)
    bench.workspace.show_session(bench.other)
    bench.runs.clear_results()
    bench.begun[0].let_go(3)
    until(lambda: bench.runs.state is RunState.IDLE)
    assert list(bench.session.valid_results()) == [2]


# guessing the rest


@pytest.fixture
def partly_done(bench: Bench) -> Completion:
    """Block 1 is done, block 2's hole is open."""
    bench.session.add_results([bench.results[1]])
    completion = bench.session.completion()
    assert completion is not None
    return completion


def test_the_rest_is_guessed(bench: Bench, until: Until, partly_done: Completion) -> None:
    bench.runs.guess()
    assert bench.runs.state is RunState.GUESSING
    until(lambda: "finished" in bench.kinds())
    assert bench.kinds() == ["ended", "finished"]
    missing = int(np.isnan(partly_done.depth).sum())
    assert bench.text("ended").startswith(f"two-planes: {missing} pixels guessed in ")
    assert bench.session.guessed
    assert bench.runs.state is RunState.IDLE
    bench.runs.guess()
    assert bench.runs.state is RunState.IDLE, "once is enough"


def test_there_is_nothing_to_guess_around_before_a_run(bench: Bench) -> None:
    bench.runs.guess()
    assert bench.runs.state is RunState.IDLE


@pytest.mark.usefixtures("partly_done")
def test_a_guess_of_blocks_that_were_edited_meanwhile_does_not_count(bench: Bench, until: Until) -> None:
    bench.runs.guess()
    bench.session.set_labels(np.where(bench.session.labels == 1, 0, bench.session.labels))
    until(lambda: "ended" in bench.kinds())
    assert "edited meanwhile: guess again" in bench.text("ended")
    assert bench.kinds() == ["ended"]
    assert not bench.session.guessed


def test_a_run_that_is_to_be_dense_goes_on_with_the_guess(bench: Bench, until: Until) -> None:
    bench.session.dense = True
    bench.runs.start({1})
    bench.begun[0].let_go(3)
    until(lambda: "finished" in bench.kinds())
    assert bench.kinds() == ["ended", "ended", "finished"]
    assert bench.session.guessed
