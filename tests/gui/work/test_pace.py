"""The time that is left is estimated from the time that the work was going, and said in round numbers."""

import pytest

from gui.work.jobs import Pace


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def _after(*notes: tuple[float, float]) -> Pace:
    clock = Clock()
    pace = Pace(clock)
    for seconds, share in notes:
        clock.now = 100.0 + seconds
        pace.note(share)
    return pace


@pytest.mark.parametrize(
    ("seconds", "share", "said"),
    [
        (0.9, 0.5, ""),
        (5, 0.01, ""),
        (5, 1.0, ""),
        (2, 0.5, "2 s left"),
        (2, 0.99, "1 s left"),
        (20, 0.5, "20 s left"),
        (21, 0.5, "25 s left"),
        (57, 0.5, "60 s left"),
        (61, 0.5, "2 min left"),
    ],
)
def test_it_is_said_when_there_is_something_to_say(seconds, share, said):
    assert _after((0, 0.0), (seconds, share)).text() == said


def test_what_it_was_held_for_does_not_count_and_other_work_begins_anew():
    clock = Clock()
    pace = Pace(clock)
    pace.note(0.0)
    clock.now += 3
    pace.note(0.5, going=False)
    clock.now += 600
    pace.note(0.5)
    assert pace.left == pytest.approx(3)
    pace.note(0.1)
    assert pace.left is None
