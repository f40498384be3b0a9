"""Gaps at jumps: at rims, depth is that of the side that colour says, among scattered samples that of most of those
around; all else is the filter's."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf.completion.edge_aware.iteration import joined, scattered_gaps
from ilf.completion.rims import depth_at_rims
from ilf.data.blocks import Block
from ilf.segmentation.editing.patches import border_pixels

SHAPE = 48, 64
COLUMNS = np.indices(SHAPE)[1]
ONE = ilf.Blocks(np.ones(SHAPE, np.int32))
STEP = np.where(COLUMNS < 32, 1.0, 2.0)
THIN = slice(30, 34)


def frame_of(depth, missing, contour=32):
    """Depth with missing columns or pixels; colour changes at a column."""
    depth = depth.copy()
    depth[missing if isinstance(missing, np.ndarray) else np.s_[:, missing]] = np.nan
    colour = np.where(contour > COLUMNS, 60, 190)[..., np.newaxis].repeat(3, axis=2)
    return ilf.RGBDFrame(colour.astype(np.uint8), depth)


def both(frame, blocks=ONE, **changes):
    """Completed depth [m], and that of the filter alone."""
    completed, filtered = ilf.complete(frame, blocks, correction=False, **changes).depth, np.full(SHAPE, np.nan)
    for label in np.unique(blocks.labels):
        stepper = ilf.iterate(frame, blocks, int(label), correction=False, **changes)
        for _ in stepper:
            pass
        filtered[blocks.labels == label] = stepper.surface
    return completed, np.where(frame.known & (changes.get("mode") != "fill+denoise"), frame.depth, filtered)


@pytest.mark.parametrize("missing", [THIN, slice(26, 38)], ids=["thin", "wide"])
@pytest.mark.parametrize("contour", [30, 32, 34])
def test_depth_is_that_of_the_side_of_its_colour(missing, contour):
    completed, filtered = both(frame_of(STEP, missing, contour))
    side = np.where(contour > COLUMNS, 1.0, 2.0)
    gap = range(missing.start, missing.stop)
    rim = [*gap[:2], *gap[-2:]]
    np.testing.assert_allclose(completed[:, rim], side[:, rim], rtol=0.12)
    assert np.abs(completed - filtered)[:, rim].max() > 0.05 or missing is not THIN
    assert np.array_equal(completed[:, : gap[0]], STEP[:, : gap[0]])  # what is measured is kept


def test_further_inside_a_gap_depth_is_the_filters():
    completed, filtered = both(frame_of(STEP, slice(24, 40)))
    np.testing.assert_allclose(completed[:, 28:36], filtered[:, 28:36], rtol=1e-6)


def test_one_wrong_sample_at_the_rim_hardly_matters():
    depth = STEP.copy()
    depth[20:22, 29] = 1.4
    completed, filtered = both(frame_of(depth, THIN))
    gap = np.s_[19:23, 31]
    assert np.abs(completed[gap] - 1).max() < 0.7 * np.abs(filtered[gap] - 1).max()


def test_a_large_frame_in_strips_has_the_same_depth():
    shape = 700, 40
    columns = np.indices(shape)[1]
    colour = np.where(columns < 20, 60, 190)[..., np.newaxis].repeat(3, axis=2).astype(np.uint8)
    depth = np.where(columns < 20, 1.0, 2.0)
    depth[:, 18:22] = np.nan
    whole = Block(1, np.s_[0:700, 0:40], np.ones(shape, bool))
    found = depth_at_rims(ilf.RGBDFrame(colour, depth), whole).reshape(shape)
    assert np.isfinite(found[:, 18:22]).all()
    np.testing.assert_allclose(found[3:-3], np.broadcast_to(found[350], found[3:-3].shape), rtol=1e-5)


@pytest.mark.parametrize(
    ("depth", "missing", "changes"),
    [
        (STEP, np.random.default_rng(0).random(SHAPE) > 0.43, {}),
        (1 + 0.012 * COLUMNS, THIN, {}),
        (1.02**COLUMNS, slice(24, 40), {}),
        (STEP, THIN, {"mode": "fill+denoise"}),
        (STEP, THIN, {"jump_share": 0.0}),
    ],
    ids=["scattered samples", "slope", "steep slope", "denoising", "jumps off"],
)
def test_elsewhere_it_is_the_filters(depth, missing, changes):
    completed, filtered = both(frame_of(depth, missing), **changes)
    np.testing.assert_allclose(completed, filtered, rtol=1e-6)


SAMPLES = np.random.default_rng(1).random(SHAPE) < 0.43
ROWS = np.indices(SHAPE)[0]
INSIDE = np.pad(np.ones((SHAPE[0] - 2, SHAPE[1] - 2), bool), 1)


@pytest.mark.parametrize(
    "near", [COLUMNS + ROWS // 2 < 40, np.hypot(COLUMNS - 32, ROWS - 24) < 15], ids=["line", "disk"]
)
def test_among_scattered_samples_pixels_on_a_ramp_join_one_side_of_a_jump(near):
    exact = np.where(near, 1.0, 2.0).astype(np.float32)
    ramp = np.where(SAMPLES, exact, cv2.blur(exact, (5, 5)))
    gaps = scattered_gaps(frame_of(exact, ~SAMPLES))
    assert not (gaps & SAMPLES).any()
    before, after = (np.square(found - exact).mean() for found in (ramp, joined(ramp, gaps & INSIDE)))
    assert after < 0.8 * before


def test_among_scattered_samples_planes_stay():
    plane = (1 + 0.02 * COLUMNS + 0.01 * ROWS).astype(np.float32)
    np.testing.assert_allclose(joined(plane, INSIDE), plane, atol=1e-5)


@pytest.mark.parametrize("samples", [SAMPLES, ROWS < 20], ids=["no jump", "beside a surface"])
def test_other_gaps_are_none_among_scattered_samples(samples):
    depth = 1 + 0.005 * SAMPLES if samples is SAMPLES else STEP
    assert not scattered_gaps(frame_of(depth, ~samples))[:22].any()


def test_a_completed_jump_among_scattered_samples_is_joined():
    frame = frame_of(np.where(COLUMNS + ROWS // 2 < 40, 1.0, 2.0), ~SAMPLES)
    gaps = scattered_gaps(frame) & INSIDE
    completed = ilf.complete(frame, ONE, correction=False).depth
    np.testing.assert_allclose(joined(completed, gaps), completed, atol=0.1)


def test_among_scattered_samples_no_depth_crosses_a_border_drawn_by_hand():
    labels = np.where(COLUMNS < 32 + 4 * (ROWS % 2), 1, 2).astype(np.int32)
    blocks = ilf.Blocks(labels, drawn=border_pixels(labels))
    completed = ilf.complete(frame_of(1.0 * labels, ~SAMPLES), blocks, correction=False).depth
    np.testing.assert_allclose(completed, labels, atol=1e-3)


def test_depth_does_not_cross_borders_drawn_by_hand():
    labels = np.where(COLUMNS < 33, 1, 2).astype(np.int32)
    blocks = ilf.Blocks(labels, drawn=border_pixels(labels))
    completed, filtered = both(frame_of(STEP, THIN), blocks)
    np.testing.assert_allclose(completed, filtered, rtol=1e-6)


def test_depth_by_hand_stays():
    frame, by_hand = frame_of(STEP, THIN), np.full(SHAPE, np.nan)
    by_hand[24, 32] = 1.5
    blocks = ilf.Blocks(ONE.labels, by_hand=by_hand)
    completed, filtered = both(frame, blocks)
    assert completed[24, 32] == pytest.approx(filtered[24, 32], rel=1e-6)
    assert completed[23, 32] != pytest.approx(filtered[23, 32], rel=1e-3)


def test_pixels_outside_the_depth_cameras_view_stay_missing():
    frame, outside = frame_of(STEP, THIN), np.zeros(SHAPE, bool)
    outside[:10, THIN] = True
    completed = ilf.complete(replace(frame, outside_view=outside), ONE).depth
    assert np.array_equal(np.isnan(completed), outside)
