"""Taking noise off known depth: how noisy it is found to be, and what is left of noise, jumps and thin things."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

import ilf
from ilf.completion.edge_aware.iteration import Denoising
from ilf.completion.edge_aware.noise import Noise, frame_noise
from ilf.completion.edge_aware.shape import polynomial_trend
from ilf.completion.edge_aware.view import swapped_pixels

ROWS, COLUMNS = np.indices((120, 160)).astype(float)
ROWS2, COLUMNS2 = np.indices((240, 320)).astype(float)
RNG_SEED = 3


def _grey(depth: np.ndarray) -> ilf.RGBDFrame:
    return ilf.RGBDFrame(np.full((*depth.shape, 3), 128, np.uint8), depth)


def _denoised(depth: np.ndarray, **changes: object) -> np.ndarray:
    frame = _grey(depth)
    return ilf.complete(frame, np.ones(depth.shape, np.int32), ilf.preset(mode="fill+denoise", **changes)).depth


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("deviation", [0.002, 0.03])
def test_even_noise_is_found(deviation):
    plane = 1.5 + 0.01 * COLUMNS
    found = frame_noise(_grey(plane + deviation * np.random.default_rng(RNG_SEED).standard_normal(plane.shape)))
    assert found.deviation(np.array([1.5, 3.0])) == pytest.approx([deviation] * 2, rel=0.15)
    assert found.grain < 1.3


def test_noise_that_grows_with_depth_is_found():
    plane = 1.0 + 0.02 * COLUMNS
    noisy = plane + 0.002 * plane**2 * np.random.default_rng(RNG_SEED).standard_normal(plane.shape)
    assert frame_noise(_grey(noisy)).deviation(np.array([1.2, 4.0])) == pytest.approx([0.0029, 0.032], rel=0.2)


def test_steps_of_depth_are_noise():
    step = 0.02
    terraces = step * np.round((1.0 + 0.001 * COLUMNS + 0.0005 * ROWS) / step)
    assert frame_noise(_grey(terraces)).deviation(np.array([1.1])) >= 0.9 * step / np.sqrt(12)


def test_noise_that_neighbours_share_has_a_grain():
    white = np.random.default_rng(RNG_SEED).standard_normal(ROWS.shape)
    shared = sum(np.roll(white, shift, (0, 1)) for shift in ((0, 0), (0, 1), (1, 0), (1, 1))) / 2
    assert frame_noise(_grey(2 + 0.01 * shared)).grain == pytest.approx(4, rel=0.3)


def test_too_little_depth_has_no_noise():
    assert frame_noise(_grey(np.full((3, 4), 2.0))) == Noise(0.0)


def test_a_polynomial_is_found_through_noise_and_across_a_gap_but_not_where_there_is_more():
    surface = 2 + 0.1 * (COLUMNS / 80 - 1) ** 4 + 0.05 * (ROWS / 60 - 1) ** 2
    noise = Noise(0.005)
    depth = (surface + 0.005 * np.random.default_rng(RNG_SEED).standard_normal(surface.shape)).astype(np.float32)
    depth[:, 60:90] = np.nan
    everywhere = np.ones(depth.shape, bool)
    found = polynomial_trend(depth, everywhere, noise)
    assert _rms(found - surface) < 0.0005
    waves = (depth + 0.02 * np.sin(COLUMNS / 3)).astype(np.float32)
    assert polynomial_trend(waves, everywhere, noise) is None


@pytest.mark.parametrize("grain", [1.0, 4.0])
def test_what_a_trend_leaves_stays_as_far_as_its_mean_over_squares_is_beyond_noise(grain):
    """A share 1 - (5 / z)^2 of it, z being the larger of the means of known pixels over 3 x 3 and 7 x 7, in deviations
    of such a mean's noise, to which as many pixels contribute independently as there are grains."""
    rng = np.random.default_rng(RNG_SEED)
    shape = 20, 24
    known = rng.random(shape) < 0.7
    known[:9, :9] = False
    deviation = rng.uniform(0.004, 0.006, shape).astype(np.float32)
    raised = np.where(COLUMNS[:20, :24] > 15, 3.0, 0.0)
    samples = np.where(known, deviation * (rng.standard_normal(shape) + raised), 0).astype(np.float32)
    u = rng.standard_normal(shape).astype(np.float32)
    denoising = Denoising(known, samples, deviation, grain, ilf.Parameters(), explained=True)
    z = np.zeros(shape)
    for side in (3, 7):
        total, count = (
            sliding_window_view(np.pad(values, side // 2, mode="reflect"), (side, side)).sum(axis=(2, 3))
            for values in (samples / deviation, known.astype(float))
        )
        z = np.maximum(z, np.abs(total) / np.sqrt(np.maximum(count * np.minimum(count, grain), 1)))
    assert 0.1 < np.mean(z > 5) < 0.5
    kept = np.where(z > 5, 1 - (5 / np.maximum(z, 5)) ** 2, 0)
    np.testing.assert_allclose(denoising.without_noise(u), u * kept, atol=1e-4)
    assert replace(denoising, explained=False).without_noise(u) is u


def test_jumps_and_thin_things_stay_where_noise_goes():
    ground_truth = np.where(COLUMNS < 70, 1.0 + 0.001 * ROWS, 1.15)
    ground_truth[:, 110:112] = 0.8
    noisy = ground_truth + 0.005 * np.random.default_rng(RNG_SEED).standard_normal(ground_truth.shape)
    error = _denoised(noisy) - ground_truth
    assert _rms(error) < 0.0017
    assert np.abs(error).max() < 0.03, "nothing is bridged or melted"


def test_the_noise_found_is_said_and_given_noise_is_not():
    frame = _grey(2 + 0.005 * np.random.default_rng(RNG_SEED).standard_normal(ROWS.shape))
    labels = np.ones(frame.shape, np.int32)
    (note,) = ilf.complete(frame, labels, ilf.preset(mode="fill+denoise")).notes
    assert note.startswith("Noise estimated from the known depth: standard deviation")
    assert ilf.complete(frame, labels, ilf.preset(mode="fill+denoise", noise=0.005)).notes == ()
    assert ilf.complete(frame, labels, ilf.preset()).notes == ()


def _rods(rng: np.random.Generator, jitter: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Rods of 2 to 9 px before a wall, exact and as seen with lateral jitter [px] and noise [m]."""
    truth = 2.5 + 0.002 * COLUMNS
    for left, width in ((20, 2), (45, 5), (75, 9), (120, 3)):
        truth[10:110, left : left + width] = 1.4
    down, across = np.round(jitter * rng.standard_normal((2, *truth.shape))).astype(int)
    seen = truth[np.clip(ROWS.astype(int) + down, 0, 119), np.clip(COLUMNS.astype(int) + across, 0, 159)]
    return truth, seen + noise * rng.standard_normal(truth.shape)


def test_pixels_swapped_across_jagged_jumps_return_to_their_side():
    truth, seen = _rods(np.random.default_rng(RNG_SEED), jitter=0.45, noise=0.002)
    swapped = swapped_pixels(_grey(seen))
    assert (np.abs(seen - truth) > 0.5)[swapped].mean() > 0.8
    assert _rms(_denoised(seen) - truth) < 0.7 * _rms(seen - truth)


@pytest.mark.parametrize(("spokes", "width"), [(24, 1.0), (40, 0.8)])
def test_spokes_are_no_swapped_pixels(spokes, width):
    """A wheel of thin spokes before a wall, with 10 mm of noise: beside its jumps 3 to 4 mm are left."""
    y, x = ROWS2 - 119.5, COLUMNS2 - 159.5
    radius, angle = np.hypot(x, y), np.arctan2(y, x) * spokes / (2 * np.pi)
    off = np.abs((angle + 0.37) % 1 - 0.5) * 2 * np.pi / spokes * radius
    wheel = ((off < width / 2) | (np.abs(radius - 105) < 3)) & (radius < 108)
    truth = np.where(wheel, 1.5, 2.8 + 0.001 * COLUMNS2)
    depth = truth + 0.01 * np.random.default_rng(RNG_SEED).standard_normal(truth.shape)
    frame = ilf.RGBDFrame(np.repeat(np.where(wheel, 60, 170).astype(np.uint8)[..., None], 3, axis=2), depth)
    assert not swapped_pixels(frame).any()
    done = ilf.complete(frame, np.ones(truth.shape, np.int32), ilf.preset(mode="fill+denoise")).depth
    beside = wheel | np.roll(wheel, 1, 0) | np.roll(wheel, -1, 0) | np.roll(wheel, 1, 1) | np.roll(wheel, -1, 1)
    assert _rms((done - truth)[beside]) < 0.006


@pytest.mark.parametrize("noise", [0.0005, 0.065])
def test_thin_objects_with_even_jumps_and_strong_noise_have_no_swapped_pixels(noise):
    _, seen = _rods(np.random.default_rng(RNG_SEED), jitter=0.0, noise=noise)
    assert not swapped_pixels(_grey(seen)).any()
