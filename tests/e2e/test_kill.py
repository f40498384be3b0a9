"""The window is killed with -9 while it is worked in; `python -m tests.bench.kill` does so a hundred times."""

import random

from tests.bench.kill.rounds import one_round

from .conftest import write_frame


def test_what_comes_back_is_a_whole_state_that_there_was(tmp_path, small_frame):
    frames = [write_frame(tmp_path / f"frame{place}", small_frame) for place in range(2)]
    found = one_round(random.randrange(10**6), frames, tmp_path / "round", longest=1.5)
    assert found.states > 0
    assert found.problem == "", found
