"""The time that is left is estimated from the time that the work was going, and said in round numbers."""

import pytest

from gui.work.jobs import Pace


def _after(*notes: tuple[float, float]) -> Pace:
    now = 100.0
    pace = Pace(lambda: now)
    for seconds, share in notes:
        now = 100.0 + seconds
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
