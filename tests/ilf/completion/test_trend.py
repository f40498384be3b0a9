"""The noise that is read off the depth, and the shape that most of a block lies on."""

import numpy as np
import pytest

from ilf.completion.edge_aware.shape import noise_of, trend_of

SHAPE = (90, 120)
ALL = np.ones(SHAPE, bool)


def _surface(kind: str, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    y, x = (axis / SHAPE[1] for axis in np.mgrid[: shape[0], : shape[1]])
    plane = 1.5 + 0.4 * y - 0.2 * x
    return (plane if kind == "plane" else plane + 0.4 * x**2 - 0.3 * x * y + 0.2 * y**2).astype(np.float32)


def _noisy(sigma: float, seed: int = 0) -> np.ndarray:
    return (_surface("plane") + sigma * np.random.default_rng(seed).standard_normal(SHAPE)).astype(np.float32)


@pytest.mark.parametrize("sigma", [0.001, 0.01, 0.065])
def test_noise_on_a_slope_is_found(sigma):
    assert noise_of(_noisy(sigma), ALL) == pytest.approx(sigma, rel=0.05)


def test_a_depth_jump_and_holes_hardly_change_the_noise():
    rng = np.random.default_rng(1)
    depth = _noisy(0.01)
    depth[:, 50:] += 1.0
    depth[20:60, 30:80] = np.nan
    depth[rng.random(SHAPE) < 0.3] = np.nan
    assert noise_of(depth, ALL) == pytest.approx(0.01, rel=0.1)


def test_only_the_blocks_own_depth_has_noise_that_counts():
    depth = _noisy(0.01)
    depth[:, 60:] += 0.5 * np.random.default_rng(2).standard_normal((90, 60)).astype(np.float32)
    mask = ALL.copy()
    mask[:, 60:] = False
    assert noise_of(depth, mask) == pytest.approx(0.01, rel=0.1)


def test_exact_or_hardly_any_depth_has_no_noise():
    assert noise_of(_surface("plane"), ALL) < 1e-6
    few = np.full(SHAPE, np.nan, np.float32)
    few[::2, ::2] = _noisy(0.1)[::2, ::2]  # nowhere three in a row
    assert noise_of(few, ALL) == 0.0
    assert noise_of(np.ones((1, 1), np.float32), np.ones((1, 1), bool)) == 0.0


@pytest.mark.parametrize("shape", [(24, 30), SHAPE], ids=str)
@pytest.mark.parametrize("kind", ["plane", "quadric"])
def test_a_shape_comes_back_under_scattered_outliers(kind, shape):
    rng = np.random.default_rng(1)
    ground_truth = _surface(kind, shape)
    depth = ground_truth.copy()
    outliers = rng.random(shape) < 0.18
    depth[outliers] *= rng.uniform(1.2, 2.0, np.count_nonzero(outliers)).astype(np.float32)
    trend = trend_of(depth, np.ones(shape, bool), 0.0)
    assert trend.surface.dtype == np.float32
    assert np.abs(trend.surface - ground_truth).max() < 1e-4


@pytest.mark.parametrize("kind", ["plane", "quadric"])
def test_a_shape_comes_back_across_a_hole_and_past_another_object(kind):
    ground_truth = _surface(kind)
    depth = ground_truth.copy()
    depth[25:60, 20:100] = np.nan
    mask = ALL.copy()
    mask[65:85, 50:80] = False
    depth[65:85, 50:80] = 5.0
    trend = trend_of(depth, mask, 0.0)
    assert np.abs(trend.surface - ground_truth).max() < 1e-4
    assert trend.spread < 1e-4


def _wall() -> np.ndarray:
    """A plane in space: its inverse depth is linear in the image."""
    rows, columns = np.indices(SHAPE)
    return (1.5 / (1 - 0.002 * rows + 0.001 * columns)).astype(np.float32)


def test_noise_alone_is_no_spread():
    noisy = (_wall() + 0.03 * np.random.default_rng(0).standard_normal(SHAPE)).astype(np.float32)
    smooth = trend_of(noisy, ALL, 0.03)
    assert smooth.spread < 0.003
    assert np.sqrt(np.mean((smooth.surface - _wall()) ** 2)) < 0.003
    waves = noisy + (0.02 * np.sin(np.arange(120) / 2.5)).astype(np.float32)
    wavy = trend_of(waves, ALL, 0.03)
    # a period is 16 pixels, so that cells of 4 see nearly all of its deviation, 20 mm / sqrt(2)
    assert wavy.spread == pytest.approx(0.02 / np.sqrt(2), rel=0.2)


def test_a_wall_beyond_a_narrow_face_goes_on_and_does_not_bend_away():
    depth = _wall()
    depth[:, :8] += (0.02 * np.arange(8, 0, -1)).astype(np.float32)
    depth[:, 50:] = np.nan
    trend = trend_of(depth, ALL, 0.001)
    assert np.abs(trend.surface - _wall())[:, 8:].max() < 0.08


def test_two_very_different_surfaces_have_no_trend_in_common():
    depth = _surface("plane")
    depth[:, 60:] = 4.0 - depth[:, 60:]
    assert trend_of(depth, ALL, 0.001) is None


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (4, 4)])
def test_too_little_depth_has_no_trend(shape):
    assert trend_of(np.full(shape, 2.0, np.float32), np.ones(shape, bool), 0.0) is None
    sparse = np.full(SHAPE, np.nan, np.float32)
    sparse[10, 10:14] = 2.0
    assert trend_of(sparse, ALL, 0.0) is None


def test_far_from_the_known_depth_the_surface_stays_within_reach():
    rows, columns = np.mgrid[:90, :120]
    bowl = (2.0 + 0.0008 * (columns - 20.0) ** 2 + 0 * rows).astype(np.float32)  # 10 m at the far side
    depth = bowl.copy()
    depth[:, 40:] = np.nan
    trend = trend_of(depth, ALL, 0.0)
    low, high = np.nanmin(depth), np.nanmax(depth)
    assert trend.surface.min() >= low - 0.51 * (high - low)
    assert high < trend.surface.max() <= high + 0.51 * (high - low)
    assert np.abs(trend.surface - bowl)[:, :40].max() < 0.01


def test_a_wall_that_recedes_steeply_continues_as_a_plane_into_its_hole():
    rows, columns = np.indices(SHAPE)
    wall = (1 / (1 - 0.0075 * columns + 0.0005 * rows)).astype(np.float32)  # 1 m to 9 m, of which no quadric is near
    depth = wall.copy()
    depth[20:70, 60:100] = np.nan
    trend = trend_of(depth, ALL, 0.0)
    assert np.abs(trend.surface / wall - 1)[20:70, 60:100].max() < 0.02


@pytest.mark.parametrize("seed", range(8))
def test_a_strip_of_known_depth_holds_a_shape(seed):
    rng = np.random.default_rng(seed)
    depth = np.full((23, 25), np.nan, np.float32)
    first = rng.integers(0, 15)
    strip = np.s_[first : first + 3, :] if seed % 2 else np.s_[:, first : first + 3]
    depth[strip] = 1 + 0.02 * rng.random(depth[strip].shape)
    depth[rng.random(depth.shape) < 0.3] = np.nan
    trend = trend_of(depth, np.ones(depth.shape, bool), 0.001)
    assert trend is None or (trend.surface.min() > 0.95 and trend.surface.max() < 1.07)
