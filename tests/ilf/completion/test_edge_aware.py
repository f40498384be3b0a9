"""ILF with the edge-aware low-pass filter, the preset "best": what its surfaces and records promise."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ilf
from ilf.completion.edge_aware.view import flying_pixels
from ilf.data.results import Status

SHAPE = (120, 160)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
HOLE = (ROWS >= 30) & (ROWS < 90) & (COLUMNS >= 40) & (COLUMNS < 120)


def _best(**changes: object) -> ilf.Parameters:
    return ilf.preset("best", **({"correction": False} | changes))


def _grey(depth: np.ndarray) -> ilf.RGBDFrame:
    """A frame whose colour says nothing."""
    return ilf.RGBDFrame(np.full((*depth.shape, 3), 128, np.uint8), depth)


def _whole(frame: ilf.RGBDFrame) -> np.ndarray:
    return np.ones(frame.shape, np.int32)


def _completed(depth: np.ndarray, **changes: object) -> np.ndarray:
    frame = _grey(depth)
    return ilf.complete(frame, _whole(frame), _best(**changes)).depth


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("metres", [0.2, 2.5, 8.0])
@pytest.mark.parametrize("mode", ["fill", "fill+denoise"])
def test_constant_depth_stays(mode, metres):
    assert np.abs(_completed(np.where(HOLE, np.nan, metres), mode=mode) - metres).max() < 1e-5 * metres


@pytest.mark.parametrize(
    ("hole", "trend"), [(HOLE, True), (HOLE, False), ((ROWS < 40) | (COLUMNS > 110), True), (ROWS < 40, True)]
)
def test_a_hole_in_a_plane_comes_back(hole, trend):
    plane = 1.5 + 0.004 * ROWS + 0.006 * COLUMNS
    assert np.abs(_completed(np.where(hole, np.nan, plane), trend=trend) - plane).max() < 0.001


JUMP = np.where(COLUMNS < 80, 1.0 + 0.001 * ROWS, 2.0)
ACROSS = np.where(HOLE, np.nan, JUMP)


def test_a_hole_across_a_colour_edge_is_filled_from_both_sides():
    rgb = np.full((*SHAPE, 3), 128, np.uint8)
    rgb[:, 80:] = (220, 60, 30)
    frame = ilf.RGBDFrame(rgb, ACROSS)
    beside = HOLE & (np.abs(COLUMNS - 79.5) > 4)
    seen = np.abs(ilf.complete(frame, _whole(frame), _best()).depth - JUMP)[beside]
    blind = np.abs(_completed(ACROSS) - JUMP)[beside]
    assert seen.max() < 0.1
    assert seen.mean() < 0.01
    assert seen.mean() < blind.mean() / 5


def test_leaking_depth_does_not_exceed_a_blocks_own_unless_most_of_that_is_missing():
    near = COLUMNS < 80
    most = (ROWS >= 10) & (ROWS < 110) & (COLUMNS >= 4) & (COLUMNS < 120)
    for hole, limited in ((HOLE, True), (most, False)):
        frame = _grey(np.where(hole, np.nan, JUMP))
        depth = ilf.complete(frame, np.where(near, 1, 2).astype(np.int32), _best()).depth
        assert (depth[near].max() <= np.nanmax(frame.depth[near])) == limited


@pytest.mark.parametrize("count", [1, 12])
def test_flying_pixels_at_the_rim_hardly_move_the_hole(count):
    rng = np.random.default_rng(1)
    depth = 2.0 + 0.002 * ROWS + 0.001 * rng.standard_normal(SHAPE)
    depth[HOLE] = np.nan
    rim = (ROWS >= 29) & (ROWS < 91) & (COLUMNS >= 39) & (COLUMNS < 121) & ~HOLE
    flying = depth.copy()
    flying.flat[rng.choice(np.flatnonzero(rim), count, replace=False)] *= 1.5
    moved = np.abs(_completed(flying) - _completed(depth))[HOLE]
    assert moved.mean() < 0.005
    assert moved.max() < 0.05


def _sphere(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """A patch of 2.6 x 1.2 m at 2 m, and the middle 51 % of it along x."""
    rows, columns = np.mgrid[:540, :960]
    x, y = 1.3 * (2 * columns / 959 - 1), 0.6 * (2 * rows / 539 - 1)
    return 2.0 + radius - np.sqrt(radius**2 - x**2 - y**2), np.abs(columns - 479.5) < 0.51 * 480


@pytest.mark.parametrize("mode", ["fill", "fill+denoise"])
def test_half_a_sphere_is_recovered_to_4_mm_from_65_mm_of_noise(mode):
    ground_truth, hole = _sphere(2.0)
    depth = ground_truth + 0.065 * np.random.default_rng(0).standard_normal(ground_truth.shape)
    depth[hole] = np.nan
    found = _completed(depth, mode=mode)
    assert _rms((found - ground_truth)[hole]) <= 0.004
    if mode == "fill":
        assert np.array_equal(found[~hole], depth[~hole].astype(np.float32))
    else:
        assert _rms((found - ground_truth)[~hole]) < 0.004


def _bumpy() -> ilf.RGBDFrame:
    """Waves with 5 mm of noise, two holes, and colour edges at random places."""
    rng = np.random.default_rng(0)
    depth = 2.0 + 0.1 * np.sin(COLUMNS / 6) + 0.005 * rng.standard_normal(SHAPE)
    depth[50:70, 60:100] = np.nan
    depth[100:, :15] = np.nan
    rgb = np.repeat(np.repeat(rng.integers(0, 255, (6, 8, 3), dtype=np.uint8), 20, axis=0), 20, axis=1)
    return ilf.RGBDFrame(rgb, depth)


def test_smoothness_is_rougher_below_and_smoother_above():
    frame = _bumpy()
    bending, misfit = [], []
    for smoothness in (1e-3, 1.0, 1e3):
        depth = ilf.complete(frame, _whole(frame), _best(mode="fill+denoise", smoothness=smoothness)).depth
        bending.append(np.abs(np.diff(depth, 2, axis=1)).mean())
        misfit.append(_rms((depth - frame.depth)[frame.known]))
    assert bending[0] > 3 * bending[1] > 5 * bending[2]
    assert misfit[0] < misfit[1] / 5 < misfit[2] / 25


def test_sigma_is_the_change_of_the_surface_on_the_finest_grid():
    frame = _bumpy()
    steps = ilf.iterate(frame, _whole(frame), 1, _best(s_criteria=1e-5))
    before = None
    finest = 0
    for record in steps:
        if before is not None and record.cell == before[0]:
            finest += record.cell == 1
            if record.cell == 1:
                assert record.sigma_i == pytest.approx(_rms(steps.surface - before[1]), rel=1e-3, abs=1e-7)
        before = record.cell, steps.surface
    assert finest > 10


def test_held_out_pixels_are_not_seen_and_measured_at_the_end():
    frame = _bumpy()
    steps = ilf.iterate(frame, _whole(frame), 1, _best(mode="fill+denoise", validation_share=0.3))
    *_, last = steps
    squares = np.square(steps.surface.reshape(SHAPE) - frame.depth)[frame.known]
    held = int(0.3 * squares.size)
    both = last.held_out**2 * held + last.residual**2 * (squares.size - held)
    assert both == pytest.approx(squares.sum(), rel=1e-3)
    assert last.held_out > last.residual
    assert np.isnan(next(ilf.iterate(frame, _whole(frame), 1, _best())).held_out)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (6, 1), (2, 3), (5, 4)])
@pytest.mark.parametrize("metres", [0.2, 8.0])
def test_one_known_pixel_gives_its_depth_to_the_whole_block(shape, metres):
    depth = np.full(shape, np.nan)
    depth[-1, 0] = metres
    loose = {"min_known_pixels": 1, "min_known_share": 0.0}
    for mode in ("fill", "fill+denoise"):
        assert np.abs(_completed(depth, mode=mode, **loose) - metres).max() < 1e-4


@settings(max_examples=20)
@given(st.integers(1, 13), st.integers(1, 13), st.integers(0, 2**32 - 1), st.booleans())
def test_frames_smaller_than_the_context_are_filled(height, width, seed, denoise):
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[:height, :width]
    plane = rng.uniform(1.0, 8.0) + 0.02 * rows - 0.03 * columns
    known = rng.random((height, width)) < rng.choice([0.05, 0.3, 0.9])
    known.flat[rng.integers(known.size)] = True
    depth = np.where(known, plane, np.nan)
    frame = ilf.RGBDFrame(rng.integers(0, 255, (height, width, 3), dtype=np.uint8), depth)
    labels = rng.integers(0, 3, (height, width)).astype(np.int32)
    mode = "fill+denoise" if denoise else "fill"
    result = ilf.complete(frame, labels, _best(mode=mode, min_known_pixels=1, min_known_share=0.0), threads=1)
    for label, outcome in result.outcomes.items():
        found = result.depth[labels == label]
        assert np.isfinite(found).all() == (outcome.known > 0)
        if not denoise:
            raw = frame.depth[labels == label]
            assert np.array_equal(found[np.isfinite(raw)], raw[np.isfinite(raw)])


@pytest.mark.parametrize("smoothness", [1.0, 10.0, 100.0, 1000.0])
def test_two_known_pixels_and_no_weight_of_slope_are_enough(smoothness):
    depth = np.full((10, 10), np.nan)
    depth[0, 0], depth[3, 4] = 2.0, 2.7
    changes = {"slope_weight": 0.0, "min_known_pixels": 1, "min_known_share": 0.0}
    found = _completed(depth, smoothness=smoothness, **changes)
    assert 1.9 < found.min() <= found.max() < 4.0


def test_a_flying_pixel_outside_the_window_leaves_the_l1_norm_a_number():
    depth = np.full((100, 200), 2.0, np.float32)
    depth[45:55, 10:20] = np.nan
    depth[50, 150] = 3.0
    frame = ilf.RGBDFrame(np.zeros((100, 200, 3), np.uint8), depth)
    steps = ilf.iterate(frame, np.ones((100, 200), np.int32), 1)
    *_, last = steps
    assert last.l1 == pytest.approx(np.abs(steps.surface).sum(), rel=1e-4)


def test_flying_pixels_are_those_that_hardly_any_known_neighbour_is_like_found_once_per_frame():
    depth = np.full((20, 30), 2.0)
    depth[5, 7] = 2.5
    depth[15] = 1.5  # a line is no flying pixel
    depth[10:, 20:] = np.nan
    depth[16, 26] = 3.0  # with no known neighbour it is all there is
    frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    flying = flying_pixels(frame)
    assert np.argwhere(flying).tolist() == [[5, 7]]
    assert flying_pixels(frame) is flying
    assert not flying.flags.writeable


@pytest.mark.parametrize("mode", ["fill", "fill+denoise"])
def test_records_tell_of_grids_and_rounds(mode):
    frame, parameters = _bumpy(), _best(mode=mode)
    steps = ilf.iterate(frame, _whole(frame), 1, parameters)
    records = list(steps)
    for before, after in itertools.pairwise(records):
        assert after.cell in (before.cell, before.cell // 2)
        assert after.round - before.round in (0, 1)
        assert (after.stage > before.stage) == ((after.cell, after.round) != (before.cell, before.round))
        if after.round == 0 or mode == "fill":  # rounds that take off noise go on until it is the noise that is steady
            assert (after.stage > before.stage) == (before.sigma_i < parameters.s_criteria or before.i == 1)
    outcome = ilf.complete(frame, _whole(frame), parameters).outcomes[1]
    assert (outcome.iterations, outcome.status) == (len(records), Status.COMPLETED)
    assert records[-1].sigma_i < parameters.s_criteria
    rounds = 2 if mode == "fill" else 4
    assert records[-1].stage == 3 + rounds, "three grids and the rounds"
    assert (records[0].cell, records[0].round, records[-1].cell, records[-1].round) == (4, 0, 1, rounds)
