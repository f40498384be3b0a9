"""Edge strength of a frame: found once, kept as long as the frame and no longer."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from ilf.ebs.strength import edge_strength
from ilf.frame import RGBDFrame


def _frame() -> RGBDFrame:
    """A colour edge between columns 29 and 30, and a depth jump between rows 39 and 40."""
    rgb = np.full((60, 80, 3), 60, np.uint8)
    rgb[:, 30:] = (220, 90, 30)
    depth = np.full((60, 80), 1.5)
    depth[40:] = 2.5
    return RGBDFrame(rgb, depth)


def test_strength_is_1_at_colour_edges_and_depth_jumps_and_0_far_from_them() -> None:
    strength = edge_strength(_frame())
    assert strength.dtype == np.float32
    assert strength.shape == (60, 80)
    assert strength.min() >= 0
    assert strength.max() == 1
    assert (strength[5:35, 28:32].max(axis=1) == 1).all()
    assert (strength[38:42, 45:].max(axis=0) == 1).all()
    assert (strength[5:30, 50:] == 0).all()


def test_noise_has_strengths_in_between() -> None:
    rgb = np.random.default_rng(0).integers(0, 255, (40, 50, 3), dtype=np.uint8)
    strength = edge_strength(RGBDFrame(rgb, np.full((40, 50), 2.0)))
    assert 0 <= strength.min() < strength.max() <= 1
    assert ((strength > 0) & (strength < 1)).any()


def test_a_frame_has_one_strength_that_cannot_be_changed() -> None:
    frame, other = _frame(), _frame()
    strength = edge_strength(frame)
    assert edge_strength(frame) is strength
    assert edge_strength(other) is not strength
    assert np.array_equal(edge_strength(other), strength)
    with pytest.raises(ValueError, match="read-only"):
        strength[0, 0] = 1


def test_strength_goes_with_the_frame() -> None:
    frame = _frame()
    left = weakref.ref(frame), weakref.ref(edge_strength(frame))
    gc.collect()
    assert left[1]() is not None, "kept while the frame is"
    del frame
    gc.collect()
    assert [kept() for kept in left] == [None, None]
