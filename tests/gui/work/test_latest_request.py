"""The latest question is answered, one at a time; what nobody wants any more is not told."""

import threading

import pytest

from gui.work.jobs import stop_workers
from gui.work.latest_request import LatestRequest


class _Oracle:
    """Answers 10 times the question, when it is let; 13 is bad luck."""

    def __init__(self):
        self.gate = threading.Event()
        self.asked: list[int] = []
        self.told: list[tuple[int, object]] = []
        self.questions = LatestRequest()

    def ask(self, question: int, take=None):
        """Ask a number; the answer is told, and taken."""

        def told(answer: object):
            self.told.append((question, answer))
            if take is not None:
                take()

        self.questions.ask(lambda: self._answer(question), told, lambda error: told(str(error)), key=question)

    def _answer(self, question: int) -> int:
        self.asked.append(question)
        assert self.gate.wait(20)
        if question == 13:
            raise ValueError("bad luck")
        return 10 * question


@pytest.fixture
def oracle(qtbot):
    oracle = _Oracle()
    yield oracle
    oracle.gate.set()
    assert stop_workers(oracle.questions)


def _settle(oracle: _Oracle, qtbot):
    oracle.gate.set()
    qtbot.waitUntil(lambda: not oracle.questions.busy)


def test_the_one_under_way_and_the_latest_are_answered_and_none_between(oracle, qtbot):
    for question in (1, 2, 3, 4):
        oracle.ask(question)
        assert oracle.questions.busy
    _settle(oracle, qtbot)
    assert oracle.asked == [1, 4]
    assert oracle.told == [(1, 10), (4, 40)]


def test_asking_the_same_again_while_it_is_answered_asks_once(oracle, qtbot):
    oracle.ask(1)
    oracle.ask(2)
    oracle.ask(1)
    _settle(oracle, qtbot)
    assert oracle.told == [(1, 10)], "what was asked last is what is wanted"
    oracle.ask(1)
    _settle(oracle, qtbot)
    assert oracle.asked == [1, 1], "an answer is not kept"


def test_a_failure_is_told_with_its_question_and_the_next_is_answered(oracle, qtbot):
    oracle.ask(13)
    oracle.ask(2)
    _settle(oracle, qtbot)
    assert oracle.told == [(13, "bad luck"), (2, 20)]


@pytest.mark.parametrize("question", [1, 13])
def test_after_forget_nothing_is_heard_of_older_questions(oracle, qtbot, question):
    oracle.ask(question)
    oracle.ask(2)
    oracle.questions.forget()
    assert oracle.questions.busy, "the thread goes on until it is done"
    _settle(oracle, qtbot)
    assert oracle.told == []
    oracle.ask(3)
    _settle(oracle, qtbot)
    assert oracle.told == [(3, 30)]
