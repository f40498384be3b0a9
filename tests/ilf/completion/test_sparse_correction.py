"""The correction of sparse depth: its features and arithmetic against direct formulas, and what it may touch."""

import numpy as np
import pytest

import ilf
from ilf._runtime.networks.models import CORRECTION, SPARSE_CORRECTION
from ilf.completion.correction import CorrectionNetwork, fading
from ilf.completion.plain_surfaces import colourisation, thin_plate
from ilf.completion.sparse_correction import (
    CHANNELS,
    SparseCorrectionNetwork,
    cell_side,
    middles_of_cells,
    mirrored,
    sparse_features,
    spread_to_pixels,
)
from ilf.run.record import installed_sha256

RNG = np.random.default_rng(67)
SHAPE = (96, 128)


@pytest.fixture(scope="module")
def sparse():
    """Two walls that meet, the right one darker; 1.5 % of the pixels are known."""
    rows, columns = np.indices(SHAPE)
    exact = (2 + np.abs(columns - 60) / 80 + rows / 400).astype(np.float32)
    rgb = np.repeat(np.where(columns < 60, 180, 90)[..., None], 3, axis=2).astype(np.uint8)
    kept = np.random.default_rng(1).random(SHAPE) < 0.015
    return ilf.RGBDFrame(rgb, np.where(kept, exact, np.float32(np.nan)), ground_truth=exact)


@pytest.fixture(scope="module")
def completed(sparse):
    return ilf.complete(sparse, ilf.extract_blocks(sparse))


def inputs_of(frame: ilf.RGBDFrame) -> tuple[np.ndarray, ...]:
    corrected = np.full(frame.shape, 2.2, np.float32)
    change = RNG.normal(0, 0.1, frame.shape).astype(np.float32)
    return frame.rgb, frame.depth, corrected, change, RNG.random(frame.shape).astype(np.float32)


def test_a_thin_plate_continues_a_plane_and_colourisation_keeps_a_level():
    rows, columns = np.indices((20, 30))
    plane = 2 + 0.03 * rows - 0.02 * columns
    known = np.where(RNG.random(plane.shape) < 0.05, plane, np.nan)
    np.testing.assert_allclose(thin_plate(known), plane, atol=1e-5)
    level = np.where(np.isfinite(known), 3.0, np.nan)
    np.testing.assert_allclose(colourisation(RNG.random(plane.shape), level), 3, atol=1e-6)


def test_features_know_no_scale(sparse):
    rgb, depth, corrected, change, contours = inputs_of(sparse)
    one, other = (
        sparse_features(rgb, depth * k, corrected * k, change, contours) for k in (np.float32(1), np.float32(4))
    )
    side = cell_side(SHAPE)
    assert one[0].shape == (len(CHANNELS), *(-(-length // side) for length in SHAPE))
    np.testing.assert_allclose(one[0], other[0], atol=1e-3)
    np.testing.assert_allclose(one[1], other[1], atol=1e-5)


def test_features_are_what_their_names_say(sparse):
    rgb, depth, corrected, change, contours = inputs_of(sparse)
    features, log_depth = sparse_features(rgb, depth, corrected, change, contours)
    named = dict(zip(CHANNELS, features, strict=True))
    side = cell_side(SHAPE)
    assert side == 1
    median = np.median(np.log(depth[sparse.known]))
    np.testing.assert_allclose(log_depth, np.log(2.2) - median, atol=1e-6)
    at = np.argwhere(sparse.known)[7]
    offset = np.log(depth[tuple(at)]) - np.log(2.2)
    assert named["nearest"][tuple(at)] == pytest.approx(4 * offset, abs=1e-4)
    assert named["thin plate"][tuple(at)] == pytest.approx(4 * offset, abs=1e-4)
    assert named["distance"][tuple(at)] == 0
    assert np.all(named["farthest in 17"] >= named["closest in 17"])
    assert np.all(named["farthest in 41"] >= named["farthest in 17"])
    np.testing.assert_allclose(named["first change"], 4 * change, rtol=1e-5)
    np.testing.assert_array_equal(named["contours"], contours)
    inner = (slice(30, 50), slice(40, 80))
    window = sparse.known[40 - 7 : 40 + 8, 60 - 7 : 60 + 8]
    assert named["known in 15"][40, 60] == pytest.approx(15 * window.mean(), rel=1e-4)
    assert np.abs(named["slope"][inner]).max() == 0, "the corrected depth is level"


def test_a_frame_and_its_mirror_image_are_changed_alike(sparse):
    rgb, depth, corrected, change, contours = inputs_of(sparse)
    corrected = corrected + np.linspace(0, 0.4, SHAPE[1], dtype=np.float32)
    turned = [np.ascontiguousarray(one[:, ::-1]) for one in (rgb, depth, corrected, change, contours)]
    features, of_turned = (sparse_features(*given)[0] for given in ((rgb, depth, corrected, change, contours), turned))
    # pixels between two known ones may take the depth of either
    assert np.mean(np.abs(mirrored(features) - of_turned) < 1e-3) > 0.97
    network = SparseCorrectionNetwork.bundled()
    one = network.change(rgb, depth, corrected, change, contours)
    assert np.median(np.abs(one - network.change(*turned)[:, ::-1])) < 1e-3


def test_what_has_not_been_completed_counts_as_the_nearest_known_depth(sparse):
    rgb, depth, corrected, change, contours = inputs_of(sparse)
    corrected[:, 64:] = np.nan
    features, _ = sparse_features(rgb, depth, corrected, change, contours)
    assert np.isfinite(features).all()
    assert np.all(features[CHANNELS.index("nearest")][:, 64:] == 0)


def test_a_pixel_takes_a_mean_of_the_cells_around_it():
    pixels = RNG.normal(0, 0.3, (700, 320)).astype(np.float32)
    pixels[3, 5] = np.nan
    side = cell_side(pixels.shape)
    assert side == 4
    cells = RNG.normal(size=(175, 80)).astype(np.float32)
    log_depth = middles_of_cells(np.nan_to_num(pixels))
    found = spread_to_pixels(cells, log_depth, pixels)
    for row, column in ((3, 5), (0, 0), (350, 161), (699, 319)):
        at = (row - 2) / 4, (column - 2) / 4
        middle = tuple(int(np.clip(np.rint(one), 0, size - 1)) for one, size in zip(at, cells.shape, strict=True))
        total = weights = 0.0
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                cell = tuple(np.clip((middle[0] + i, middle[1] + j), 0, (174, 79)))
                near = np.exp(-((at[0] - middle[0] - i) ** 2) - (at[1] - middle[1] - j) ** 2)
                off = pixels[row, column] - log_depth[cell]
                weight = near * ((1 if np.isnan(off) else np.exp(-(off**2) / 0.03)) + 1e-6)
                total, weights = total + weight * cells[cell], weights + weight
        assert found[row, column] == pytest.approx(total / weights, rel=1e-3, abs=1e-5)


def test_changes_do_not_cross_a_jump():
    pixels = np.zeros((640, 480), np.float32)
    pixels[:, 242:] = 1
    log_depth = middles_of_cells(pixels)
    cells = np.where(log_depth > 0.5, np.float32(0.3), np.float32(0))
    found = spread_to_pixels(cells, log_depth, pixels)
    assert np.abs(found - 0.3 * pixels).max() < 1e-4


def test_sparse_depth_is_corrected_by_both_networks(sparse, completed):
    np.testing.assert_array_equal(completed.depth[sparse.known], sparse.depth[sparse.known])
    assert not np.isnan(completed.depth).any()
    used = {result.correction for result in completed.results.values() if result.correction}
    assert used == {(installed_sha256(CORRECTION), installed_sha256(SPARSE_CORRECTION))}
    near = fading(sparse.known) == 0
    plain = ilf.complete(sparse, ilf.extract_blocks(sparse), ilf.preset("best", correction=False))
    np.testing.assert_array_equal(completed.depth[near], plain.depth[near])


def test_of_denser_frames_it_is_not_asked(sparse, monkeypatch):
    monkeypatch.setattr(SparseCorrectionNetwork, "bundled", lambda: pytest.fail("the network is asked"))
    depth = sparse.ground_truth.copy()
    depth[30:70, 40:90] = np.nan
    frame = ilf.RGBDFrame(sparse.rgb, depth)
    used = {result.correction for result in ilf.complete(frame, ilf.extract_blocks(frame)).results.values()}
    assert used <= {(), (installed_sha256(CORRECTION),)}


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (33, 7), (30, 1000)])
def test_frames_of_any_size_are_looked_at_by_both_networks(shape):
    rgb = RNG.integers(0, 255, (*shape, 3)).astype(np.uint8)
    depth = np.full(shape, np.nan, np.float32)
    depth.ravel()[:: max(1, depth.size // 9)] = 2
    known = rgb, depth, np.full(shape, 2, np.float32), np.zeros(shape, np.float32)
    first = CorrectionNetwork.bundled().change(*known)
    second = SparseCorrectionNetwork.bundled().change(*known, np.zeros(shape, np.float32))
    for found in (first, second):
        assert found.shape == shape
        assert np.isfinite(found).all()
