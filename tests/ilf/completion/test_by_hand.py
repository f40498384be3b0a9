"""Depth by hand: a constraint within its weight, never called measured, and without it all is as before."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ilf
from ilf.completion.continuation import continue_plane, nearer_or_farther
from ilf.data.by_hand import DepthByHand
from ilf.data.results import Status
from ilf.errors import InputError

SHAPE = (60, 80)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
PLANE = (1 / (0.5 + 0.0012 * COLUMNS - 0.0008 * ROWS)).astype(np.float32)
HOLE = (ROWS >= 15) & (ROWS < 45) & (COLUMNS >= 20) & (COLUMNS < 60)
PATCH = (ROWS >= 26) & (ROWS < 34) & (COLUMNS >= 36) & (COLUMNS < 44)
ONE = np.ones(SHAPE, np.int32)
QUICK = ilf.preset(edges="canny", correction=False)


def _frame(depth: np.ndarray = PLANE, hole: np.ndarray = HOLE) -> ilf.RGBDFrame:
    return ilf.RGBDFrame(np.full((*SHAPE, 3), 128, np.uint8), np.where(hole, np.nan, depth))


def _at(pixels: np.ndarray, depth: float | np.ndarray) -> np.ndarray:
    return np.where(pixels, np.float32(depth), np.float32(np.nan))


@pytest.mark.parametrize("mode", ["fill", "fill+denoise"])
def test_the_edge_aware_filter_follows_it_within_its_weight(mode):
    parameters = QUICK.replace(mode=mode)
    plain = ilf.complete(_frame(), ONE, parameters)
    off = []
    for weight in (0.02, 0.3, 1.0):
        result = ilf.complete(_frame(), ONE, parameters, by_hand=DepthByHand(_at(PATCH, 1.5), weight))
        off.append(float(np.abs(result.depth[PATCH] - 1.5).max()))
        assert np.array_equal(result.by_hand, PATCH)
    assert np.abs(plain.depth[PATCH] - 1.5).min() > 0.2
    assert off[0] > off[1] > off[2]
    assert off[1] < 0.1
    if mode == "fill":
        assert np.array_equal(result.depth[~HOLE], plain.depth[~HOLE])


def test_the_pass_band_takes_it_as_known_depth():
    parameters = ilf.preset("paper", max_iterations=300)
    result = ilf.complete(_frame(), ONE, parameters, by_hand=_at(PATCH, 1.5))
    as_known = ilf.complete(_frame(np.where(PATCH, 1.5, PLANE), HOLE & ~PATCH), ONE, parameters)
    assert np.array_equal(result.depth[HOLE & ~PATCH], as_known.depth[HOLE & ~PATCH])
    assert np.abs(result.depth[PATCH] - 1.5).mean() < 0.1


def test_a_block_without_known_depth_is_completed_from_it():
    labels = np.where(HOLE, 2, 1).astype(np.int32)
    assert ilf.complete(_frame(), labels, QUICK).outcomes[2].status is Status.NOT_RECOVERABLE
    for parameters in (QUICK, ilf.preset("paper", max_iterations=300)):
        result = ilf.complete(_frame(), labels, parameters, by_hand=_at(PATCH, 1.5))
        assert np.isfinite(result.depth).all()
        outcome = result.outcomes[2]
        assert (outcome.known, outcome.by_hand, outcome.recovered) == (0, PATCH.sum(), HOLE.sum())
        assert f"{PATCH.sum()} pixels by hand." in outcome.message
        assert ilf.unsupported(result)[HOLE].all(), "nothing is measured in this block"
    assert f"({PATCH.sum()} by hand)" in result.summary()


def test_a_continued_plane_gives_the_plane():
    frame = _frame()
    surface, share = continue_plane(frame.depth, ~HOLE, HOLE)
    np.testing.assert_allclose(surface[HOLE], PLANE[HOLE], rtol=1e-5)
    assert np.isnan(surface[~HOLE]).all()
    assert share == 1
    labels = np.where(HOLE, 2, 1).astype(np.int32)
    for where in (ONE, labels):
        result = ilf.complete(frame, where, QUICK, by_hand=surface)
        np.testing.assert_allclose(result.depth[HOLE], PLANE[HOLE], rtol=2e-3)


def test_a_plane_is_fitted_through_most_of_the_depth():
    rng = np.random.default_rng(3)
    noisy = PLANE * (1 + 0.002 * rng.standard_normal(SHAPE)).astype(np.float32)
    noisy[rng.random(SHAPE) < 0.4] = 3.5
    found, share = continue_plane(np.where(HOLE, np.float32(np.nan), noisy), np.ones(SHAPE, bool), HOLE)
    np.testing.assert_allclose(found[HOLE], PLANE[HOLE], rtol=2e-3)
    assert 0.5 < share < 0.7
    with pytest.raises(InputError, match="at least 12 pixels"):
        continue_plane(PLANE, (ROWS == 3) & (COLUMNS < 5), HOLE)
    with pytest.raises(InputError, match="on a line"):
        continue_plane(PLANE, ROWS == 3, HOLE)
    steep = (1 / np.maximum(0.6 - 0.03 * COLUMNS, 0.05)).astype(np.float32)
    with pytest.raises(InputError, match="behind the camera"):
        continue_plane(steep, COLUMNS < 15, COLUMNS > 40)


@pytest.mark.parametrize("nearer", [True, False])
def test_a_hole_goes_to_the_nearer_or_the_farther_surface(nearer):
    near, far = 1.2 + 0.001 * ROWS, 2.0 + 0.004 * COLUMNS
    depth = np.where(HOLE, np.nan, np.where(COLUMNS < 40, near, far)).astype(np.float32)
    depth[14, 30] = 1.7  # a flying pixel between the two
    surface = nearer_or_farther(depth, ONE, HOLE, nearer)
    np.testing.assert_allclose(surface[HOLE], (near if nearer else far)[HOLE], rtol=0.02)
    assert np.isnan(surface[~HOLE]).all()
    # by blocks, where their depths overlap, so that no jump tells the surfaces apart
    labels = np.where(COLUMNS < 40, 1, 2).astype(np.int32)
    near, far = 1.5 + 0.010 * ROWS, 1.65 + 0.012 * ROWS
    slanted = np.where(HOLE, np.nan, np.where(labels == 1, near, far)).astype(np.float32)
    found = nearer_or_farther(slanted, labels, HOLE, nearer)
    np.testing.assert_allclose(found[HOLE], (near if nearer else far)[HOLE], rtol=0.03)
    with pytest.raises(InputError, match="does not lie between two surfaces"):
        nearer_or_farther(np.where(HOLE, np.nan, PLANE).astype(np.float32), ONE, HOLE, nearer)


def test_it_is_not_called_measured():
    frame = _frame()
    result, plain = ilf.complete(frame, ONE, QUICK, by_hand=_at(PATCH, 1.9)), ilf.complete(frame, ONE, QUICK)
    assert result.filled[PATCH].all()
    assert ilf.unsupported(result)[PATCH].all()
    assert np.isfinite(ilf.expected_error(result)[PATCH]).all(), "as for other filled pixels"
    assert not ilf.unsupported(plain)[PATCH].any()
    outcome = result.outcomes[1]
    assert (outcome.known, outcome.by_hand, outcome.recovered) == ((~HOLE).sum(), PATCH.sum(), HOLE.sum())


def test_it_counts_only_where_depth_is_missing():
    frame, everywhere = _frame(), _at(np.ones(SHAPE, bool), 1.5)
    result = ilf.complete(frame, ONE, QUICK, by_hand=everywhere)
    assert np.array_equal(result.by_hand, HOLE)
    assert np.array_equal(result.depth[~HOLE], frame.depth[~HOLE])
    invalid = frame.with_invalid_mask(COLUMNS < 5)
    assert np.array_equal(ilf.complete(invalid, ONE, QUICK, by_hand=everywhere).by_hand, HOLE | (COLUMNS < 5))
    unseen = dataclasses.replace(frame, outside_view=PATCH)
    seen = ilf.complete(unseen, ONE, QUICK, by_hand=everywhere)
    assert np.array_equal(seen.by_hand, HOLE & ~PATCH)
    assert np.isnan(seen.depth[PATCH]).all()


@settings(max_examples=8)
@given(given=st.sampled_from(["none", "no weight", "other block"]), mode=st.sampled_from(["fill", "fill+denoise"]))
def test_without_it_all_is_as_before(given, mode):
    frame, parameters = _frame(), QUICK.replace(mode=mode)
    labels = np.where(COLUMNS < 70, 1, 2).astype(np.int32)
    beyond = _at((COLUMNS > 72) & (ROWS > 50), 1.5)
    frame = dataclasses.replace(frame, depth=np.where(np.isfinite(beyond), np.nan, frame.depth))
    by_hand = {"none": None, "no weight": DepthByHand(_at(HOLE, 1.5), 0.0), "other block": DepthByHand(beyond)}[given]
    one, other = ilf.complete(frame, labels, parameters), ilf.complete(frame, labels, parameters, by_hand=by_hand)
    assert np.array_equal(one.depth[labels == 1], other.depth[labels == 1], equal_nan=True)
    assert one.outcomes[1] == other.outcomes[1]
    assert other.by_hand.any() is np.bool_(given == "other block")


def test_the_correction_leaves_it_alone():
    """Its changes fade near depth by hand as near known depth; far from it they stay."""
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 255, (*SHAPE, 3), dtype=np.uint8)
    frame = ilf.RGBDFrame(colour, np.where(HOLE, np.nan, PLANE))
    by_hand = DepthByHand(_at(PATCH, PLANE), 1.0)
    result = ilf.complete(frame, ONE, by_hand=by_hand)
    assert result.results[1].correction
    np.testing.assert_allclose(result.depth[PATCH], PLANE[PATCH], rtol=2e-3)


@pytest.mark.parametrize(
    ("by_hand", "message"),
    [
        (_at(PATCH, -1.0), "0 to 300 m, not -1 m"),
        (_at(PATCH, 301.0), "0 to 300 m, not 301 m"),
        (_at(PATCH, np.inf), "not inf m"),
        (np.ones((3, 4), np.float32), "must have the same pixels"),
        (np.full(SHAPE, "a"), "one real number per pixel"),
        (_at(~HOLE, 1.5), "only where depth is missing"),
        (_at((ROWS == 15) & HOLE, 1.5), "in blocks"),
    ],
)
def test_what_cannot_count_is_refused(by_hand, message):
    with pytest.raises(InputError, match=message):
        ilf.complete(_frame(), np.where(ROWS == 15, 0, 1), QUICK, by_hand=by_hand)


def test_one_block_step_by_step():
    labels = np.where(HOLE, 2, 1).astype(np.int32)
    with pytest.raises(InputError, match="no known depth"):
        ilf.iterate(_frame(), labels, 2, QUICK)
    by_hand = _at(PATCH, 1.5)
    stepper = ilf.iterate(_frame(), ilf.Blocks(labels, by_hand=DepthByHand(by_hand)), 2, QUICK)
    records = list(stepper)
    result = ilf.complete(_frame(), labels, QUICK, by_hand=by_hand)
    assert [dataclasses.replace(record, seconds=0.0) for record in records] == [
        dataclasses.replace(record, seconds=0.0) for record in result.history[2]
    ]
    assert records[-1].residual < 0.05
