"""What is remembered of a frame, and from where it may be asked."""

import gc
import weakref
from threading import Barrier, Thread

import numpy as np
import pytest

import ilf
from ilf.data.frame_cache import FrameCache, once_per_frame


class Owner:
    """Something that can be remembered of, as a frame is."""


def test_arrays_in_it_are_read_only():
    kept = FrameCache[Owner, np.ndarray]().keep(Owner(), 0, np.zeros(3))
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 1


class Awaited:
    """A key that another thread would displace between two looks at it."""

    def __init__(self, memory: FrameCache[Owner, int], owner: Owner) -> None:
        self.looks = 0
        self.other = Thread(target=lambda: [memory.keep(owner, key, key) for key in range(3)])

    def __hash__(self) -> int:
        self.looks += 1
        if self.looks == 3:  # the first was that of `keep`
            self.other.start()
            self.other.join(0.1)
        return 0


def test_a_thread_that_displaces_what_another_one_looks_at_waits():
    memory, owner = FrameCache[Owner, int](), Owner()
    key = Awaited(memory, owner)
    memory.keep(owner, key, 7)
    key.looks = 1
    assert memory.find(owner, key) == 7
    key.other.join()
    assert memory.find(owner, key) is None


def frame_of(depth: float) -> ilf.RGBDFrame:
    return ilf.RGBDFrame(np.zeros((4, 5, 3), np.uint8), np.full((4, 5), depth))


def test_frames_do_not_wait_for_each_other_and_nothing_is_worked_out_twice():
    both, worked_out = Barrier(2, timeout=10), []

    @once_per_frame
    def nearest(frame: ilf.RGBDFrame, more: float = 0) -> float:
        worked_out.append(frame)
        if not more:
            both.wait()  # broken, if one waited for the other
        return float(frame.depth.min()) + more

    frames, found = (frame_of(1), frame_of(2)), {}
    threads = [Thread(target=lambda k=k: found.update({k: nearest(frames[k % 2])})) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {0: 1, 1: 2, 2: 1, 3: 2}
    assert len(worked_out) == 2
    assert [nearest(frames[0], more=more) for more in (1, 2, 1)] == [2, 3, 2]


@pytest.mark.parametrize("preset", ["best", "paper"])
def test_a_frame_that_was_completed_is_freed(preset):
    rng = np.random.default_rng(5)
    depth = rng.uniform(1, 1.01, (24, 32))
    depth[8:14, 10:20] = np.nan
    frame = ilf.RGBDFrame(rng.integers(0, 255, (24, 32, 3), np.uint8), depth)
    ilf.expected_error(ilf.complete(frame, preset=preset))
    known = weakref.ref(frame), weakref.ref(frame.rgb)
    del frame
    gc.collect()
    assert [one() for one in known] == [None, None]
