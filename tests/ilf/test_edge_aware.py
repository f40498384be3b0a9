"""The candidate for the default preset: what its surface must do whatever its parameters are."""

from __future__ import annotations

import numpy as np
import pytest

from ilf.bench.edge_aware import edge_aware_depth

SHAPE = (60, 81)
NO_EDGES = np.zeros(SHAPE, np.float32)


def test_constant_depth_stays() -> None:
    depth = np.full(SHAPE, 2.5, np.float32)
    depth[10:40, 20:60] = np.nan
    assert np.abs(edge_aware_depth(depth, NO_EDGES) - 2.5).max() < 1e-5


def test_a_hole_in_a_plane_comes_back() -> None:
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    plane = (1.5 + 0.01 * rows + 0.004 * columns).astype(np.float32)
    depth = plane.copy()
    depth[20:40, 30:50] = np.nan
    assert np.abs(edge_aware_depth(depth, NO_EDGES) - plane).max() < 0.01


def test_a_hole_across_an_edge_is_filled_from_both_sides() -> None:
    depth = np.full(SHAPE, 1.0, np.float32)
    depth[:, 40:] = 2.0
    truth = depth.copy()
    depth[15:45, 25:55] = np.nan
    strength = NO_EDGES.copy()
    strength[:, 39:41] = 1.0
    hole = np.isnan(depth)
    hole[:, 37:43] = False
    soft = np.abs(edge_aware_depth(depth, strength) - truth)[hole]
    blind = np.abs(edge_aware_depth(depth, NO_EDGES) - truth)[hole]
    assert soft.mean() < 0.02
    assert soft.mean() < blind.mean() / 5


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (2, 3), (5, 4)])
def test_tiny_frames_with_one_known_pixel(shape: tuple[int, int]) -> None:
    depth = np.full(shape, np.nan, np.float32)
    depth[0, 0] = 3.0
    assert edge_aware_depth(depth, np.zeros(shape, np.float32)) == pytest.approx(np.full(shape, 3.0), abs=1e-4)


def test_no_depth_or_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="some depth known"):
        edge_aware_depth(np.full(SHAPE, np.nan, np.float32), NO_EDGES)
    with pytest.raises(ValueError, match="must match"):
        edge_aware_depth(np.ones((3, 3), np.float32), NO_EDGES)
