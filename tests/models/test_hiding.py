"""Which known depth is hidden while a network learns."""

import numpy as np
import pytest
from recipes import hiding

SHAPE = (128, 160)


def picture() -> tuple[np.ndarray, np.ndarray]:
    """Six upright surfaces, each farther than the one to its left, with a missing strip at the top."""
    part = np.broadcast_to(np.arange(SHAPE[1], dtype=np.int32) // 27, SHAPE).copy()
    measured = (1 + part).astype(np.float32)
    measured[:16] = np.nan
    return measured, part


def test_only_known_depth_is_hidden_and_some_always_stays():
    measured, part = picture()
    hidden = [hiding.hide(measured, part, np.random.default_rng(seed)) for seed in range(60)]
    shares = np.array([one.sum() / np.isfinite(measured).sum() for one in hidden])
    assert not any(one[:16].any() for one in hidden)
    assert all((np.isfinite(measured) & ~one).mean() >= hiding.MIN_KNOWN for one in hidden)
    assert 0 < np.mean(shares == 0) < 0.3
    assert shares.max() > 0.8
    assert np.array_equal(hidden[5], hiding.hide(measured, part, np.random.default_rng(5)))


@pytest.mark.parametrize("pattern", hiding.PATTERNS)
def test_every_pattern_hides_something_and_leaves_something(pattern):
    measured, part = picture()
    shares = [pattern(measured, part, np.random.default_rng(seed)).mean() for seed in range(12)]
    assert 0 < min(shares) <= max(shares) < 1


def test_surfaces_vanish_whole_or_but_for_a_remnant():
    measured, part = picture()
    left = []
    for seed in range(20):
        gone = hiding.surfaces(measured, part, np.random.default_rng(seed))
        left += [share for share in (1 - gone[part == k].mean() for k in range(6)) if share < 0.5]
    assert min(left) == 0
    assert any(0.02 < share < 0.4 for share in left)


def test_what_is_beyond_range_goes_first():
    measured, part = picture()
    for seed in range(12):
        gone = hiding.far_or_near(measured, part, np.random.default_rng(seed))[16:]
        shares = [gone[:, part[0] == k].mean() for k in range(6)]
        assert max(shares[0], shares[-1]) == max(shares)
