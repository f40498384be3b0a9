"""A block's own known depth rules around wide gaps, and what lies beyond the sensor's reach is not pulled near."""

import numpy as np
import pytest

import ilf
from ilf.completion.edge_aware.fitted_guide import FittedGuide
from ilf.completion.edge_aware.view import around_wide_gaps, beyond_sensor_range, edge_fade_distance, sensor_range_of
from ilf.data.blocks import find_blocks

SHAPE = (120, 160)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
DOOR = (ROWS >= 20) & (COLUMNS >= 50) & (COLUMNS < 120)
LABELS = np.where(DOOR, 2, 1).astype(np.int32)


def _frame(beyond: np.ndarray, hole: np.ndarray) -> ilf.RGBDFrame:
    """A wall 2 m away with a door to what lies beyond, which another colour shows 2 px inside the block's border."""
    rgb = np.full((*SHAPE, 3), 120, np.uint8)
    rgb[(ROWS >= 22) & (COLUMNS >= 52) & (COLUMNS < 118)] = (230, 190, 90)
    return ilf.RGBDFrame(rgb, np.where(hole, np.nan, np.where(DOOR, beyond, 2.0)))


ROOM = np.full(SHAPE, 4.0)
STRIP = DOOR & (COLUMNS < 90)
RISING = 3.0 + 0.03 * (119.0 - ROWS)
"""A floor that rises to 5 m in the door."""
FAR = DOOR & (ROWS < 70)


def _off(frame: ilf.RGBDFrame, ground_truth: np.ndarray, where: np.ndarray, **changes: object) -> float:
    depth = ilf.complete(frame, LABELS, ilf.preset("best", **changes)).depth
    return float(np.abs(depth - ground_truth)[where].mean())


def test_a_door_takes_the_depth_of_the_room_behind_and_not_of_the_wall():
    frame = _frame(ROOM, STRIP)
    inside = STRIP & (COLUMNS >= 54) & (ROWS >= 24)
    assert _off(frame, ROOM, inside) < 0.15
    assert _off(frame, ROOM, inside) < _off(frame, ROOM, inside, block_local_edges=False) / 2


def test_it_makes_no_difference_among_dense_samples():
    missing = np.random.default_rng(0).random(SHAPE) < 0.5
    frame = _frame(ROOM, missing)
    on, off = (
        ilf.complete(frame, LABELS, ilf.preset("best", block_local_edges=own, out_of_range=own)).depth
        for own in (True, False)
    )
    np.testing.assert_array_equal(on, off)


def test_distance_is_to_own_depth_around_wide_gaps_alone():
    """Depth is known on the left, at column 70, and on the right; the block begins at column 65."""
    distance = np.abs(COLUMNS - np.array([59, 70, 120])[:, None, None]).min(axis=0).astype(np.float32)
    distance[(COLUMNS < 60) | (COLUMNS >= 120)] = 0
    wide = np.flatnonzero(around_wide_gaps(distance)[0])
    assert (wide[0], wide[-1]) == (70, 120), "the gap of ten columns is narrow, that of 49 is wide with its rims"
    np.testing.assert_array_equal(edge_fade_distance(distance, COLUMNS >= 65), distance)
    without = edge_fade_distance(distance, COLUMNS >= 72)
    assert without[50, 72] == pytest.approx(48, rel=0.02)
    assert without[50, 71] == distance[50, 71] == 1
    assert without[50, 118] == distance[50, 118] == 2


def test_what_rises_to_the_reach_goes_on_beyond_it():
    frame = _frame(RISING, FAR)
    limit = float(np.median(RISING[70:74]))
    inside = FAR & (COLUMNS >= 54) & (COLUMNS < 116) & (ROWS >= 24)
    result = ilf.complete(frame, LABELS)
    near = ilf.complete(frame, LABELS, ilf.preset("best", out_of_range=False, block_local_edges=False))
    assert result.depth[inside].min() > 0.95 * limit
    assert np.median(near.depth[inside]) < np.median(result.depth[inside])
    assert any(f"sensor range, from {limit:.1f} m" in note for note in result.notes)
    assert near.notes == ()


def test_nothing_measured_vouches_beyond_the_reach():
    frame = _frame(RISING, FAR)
    result = ilf.complete(frame, LABELS)
    assert ilf.unsupported(result)[FAR].all()
    error = ilf.expected_error(result)
    assert (error[FAR] >= 0.199 * result.depth[FAR]).all()
    unmarked = ilf.complete(frame, LABELS, ilf.preset("best", out_of_range=False))
    assert not ilf.unsupported(unmarked)[FAR].all()


def test_a_guide_that_is_borne_out_tells_what_is_beyond_the_reach(monkeypatch):
    guided = _frame(RISING, FAR).with_guide(1 / RISING)
    block = find_blocks(LABELS)[2]
    assert beyond_sensor_range(guided, block) is not None, "in planes, the guide of these is not missed"
    monkeypatch.setattr(FittedGuide, "suffices_for", lambda self, block: True)
    assert beyond_sensor_range(guided, block) is None


def test_holes_beyond_the_reach_are_told_by_their_rims():
    frame = _frame(RISING, FAR)
    found = beyond_sensor_range(frame, find_blocks(LABELS)[2])
    np.testing.assert_array_equal(found.pixels, FAR)
    assert found.limit == pytest.approx(np.median(RISING[70:74]), abs=1e-5)
    assert found.in_front.any()
    assert not (found.in_front & DOOR).any()
    assert sensor_range_of(frame) == pytest.approx(np.quantile(frame.depth[frame.known], 0.99))


@pytest.mark.parametrize("beyond", [ROOM, 6.0 - RISING / 2], ids=["flat", "falling"])
def test_holes_whose_rims_do_not_rise_to_the_reach_are_no_such_holes(beyond):
    assert beyond_sensor_range(_frame(beyond, FAR), find_blocks(LABELS)[2]) is None
