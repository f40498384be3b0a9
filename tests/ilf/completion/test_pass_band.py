"""The stepper against the paper's formulas, written out by hand on tiny blocks."""

import itertools
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import ilf
from ilf.completion.edge_aware.iteration import EdgeAwareIteration
from ilf.completion.pass_band.band import colour_weight, inside_ellipse
from ilf.completion.pass_band.iteration import PassBandIteration, StagedSchedule, principal_lengths
from ilf.data.blocks import find_blocks
from ilf.data.results import hold_out_mask
from tests.reference.full_grid import FullGridIteration, squared_wave_numbers

from ..small_frames import without_edges


def _tiny(seed=3, shape=(5, 6)):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(1.0, 2.0, shape)
    depth[rng.random(shape) < 0.3] = np.nan
    labels = np.ones(shape, np.int32)
    labels[0, 0] = 0
    return ilf.RGBDFrame(rng.integers(0, 255, (*shape, 3), dtype=np.uint8), depth), labels


def _direct_dft(values, sign):
    """The sum over all pixels for every wave number."""
    rows, columns = (np.exp(sign * 2j * np.pi * np.outer(k := np.arange(n), k) / n) for n in values.shape)
    return rows @ values @ columns


STEPPERS = [PassBandIteration, FullGridIteration]


@pytest.mark.parametrize("stepper_class", STEPPERS)
@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("centred", [False, True])
@pytest.mark.parametrize("schedule", ["staged", "linear"])
def test_iterates_equal_the_papers_formulas_by_direct_sums(schedule, centred, weighted, stepper_class):
    frame, labels = _tiny()
    changes = {"rgb_iterations": 3 if weighted else 0, "rgb_dilation": 1, "shortest_wavelength": 3.0}
    changes |= {"schedule": schedule, "centred": centred, "max_iterations": 5, "s_criteria": 0.05}
    stepper = stepper_class(frame, find_blocks(labels)[1], ilf.preset("paper", **changes))
    height, width = labels.shape
    grid = 2 * height, 2 * width
    mask = labels == 1
    known = mask & frame.known
    mean = float(frame.depth[known].astype(float).mean()) if centred else 0.0
    expanded = np.zeros(grid)
    expanded[:height, :width][known] = frame.depth[known].astype(float) - mean
    previous = expanded[:height, :width][mask].copy()
    half = colour_weight(frame.rgb, mask, grid, 1)
    mirrored = half[(-np.arange(grid[0])) % grid[0], width - 1 : 0 : -1]
    weight = np.concatenate([half, mirrored], axis=1)
    rows, columns = (np.arange(n) - n * (np.arange(n) > n // 2) for n in grid)

    for record in stepper:
        along_y, along_x = (
            np.divide(k, r) if r else np.where(k == 0, 0, np.inf)
            for k, r in zip((rows, columns), record.radii, strict=True)
        )
        spectrum = _direct_dft(expanded, -1) * (along_y[:, None] ** 2 + along_x**2 <= 1 + 1e-9)
        if weighted and record.i <= 3:
            spectrum *= weight
        expanded = _direct_dft(spectrum, +1).real / (grid[0] * grid[1])
        values = expanded[:height, :width][mask]
        assert_allclose(stepper.surface, values + mean, atol=1e-10)
        assert record.sigma_i == pytest.approx(math.sqrt(np.mean((values - previous) ** 2)), abs=1e-12)
        assert record.l1 == pytest.approx(np.abs(values + mean).sum(), rel=1e-12)
        assert record.weighted == (weighted and record.i <= 3)
        residuals = expanded[:height, :width][known] + mean - frame.depth[known]
        assert record.residual == pytest.approx(math.sqrt(np.mean(residuals**2)), abs=1e-12)
        previous = values
        expanded[:height, :width][known] = frame.depth[known].astype(float) - mean
    assert record.i == 5


def _bumpy(shape, seed=5):
    """A curved, noisy block of irregular outline with a hole."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[: shape[0], : shape[1]] / max(shape)
    depth = 1.5 + rows + 0.3 * np.sin(7 * columns) + 0.02 * rng.standard_normal(shape)
    depth[shape[0] // 4 : shape[0] // 2, shape[1] // 3 : 3 * shape[1] // 4] = np.nan
    labels = (np.hypot(rows - 0.3, columns - 0.5) < 0.55).astype(np.int32)
    return ilf.RGBDFrame(rng.integers(0, 255, (*shape, 3), dtype=np.uint8), depth), labels


CHANGES = [
    {},
    {"padding": 1.3, "centred": True},
    {"shortest_wavelength": 2.0, "max_iterations": 400},
    {"staged_start": 3.0, "stage_step": 4.0},
    {"validation_share": 0.05, "centred": True, "rgb_iterations": 0},
]


@pytest.mark.parametrize("changes", CHANGES, ids=str)
@pytest.mark.parametrize("name", ["paper", "released-code"])
def test_pass_band_and_full_grid_give_the_same_iterates(name, changes):
    frame, labels = _bumpy((37, 24))
    block = find_blocks(labels)[1]
    parameters = ilf.PRESETS[name].replace(**{"max_iterations": 300, **changes})
    fast, full = PassBandIteration(frame, block, parameters), FullGridIteration(frame, block, parameters)
    for ours, theirs in itertools.zip_longest(fast, full):
        for exact in ("i", "stage", "radii", "weighted"):
            assert getattr(ours, exact) == getattr(theirs, exact)
        assert ours.sigma_i == pytest.approx(theirs.sigma_i, rel=1e-8, abs=1e-12)
        assert ours.l1 == pytest.approx(theirs.l1, rel=1e-10)
        assert ours.residual == pytest.approx(theirs.residual, rel=1e-9)
        assert ours.held_out == pytest.approx(theirs.held_out, rel=1e-9, nan_ok=True)
        assert math.isnan(ours.held_out) == (parameters.validation_share == 0)
    assert fast.settled == full.settled
    assert_allclose(fast.surface, full.surface, atol=1e-10)


def test_l1_norm_is_exact_where_the_filter_goes_negative():
    depth = np.full((30, 30), 9.0)
    depth[:, :15] = 0.15
    depth[5:25, 10:15] = np.nan
    frame = ilf.RGBDFrame(np.zeros((30, 30, 3), np.uint8), depth)
    block = find_blocks(np.ones((30, 30), np.int32))[1]
    parameters = ilf.preset("paper", shortest_wavelength=2.5, s_criteria=1e-4, max_iterations=200)
    negative = False
    fast, full = PassBandIteration(frame, block, parameters), FullGridIteration(frame, block, parameters)
    for ours, theirs in itertools.zip_longest(fast, full):
        negative |= bool((full.surface < 0).any())
        assert ours.l1 == pytest.approx(theirs.l1, rel=1e-10)
    assert negative


def test_float32_is_close():
    frame, labels = _bumpy((60, 90))
    surfaces = {}
    for precision in ("float32", "float64"):
        steps = ilf.iterate(frame, labels, 1, ilf.preset("paper", precision=precision))
        list(steps)
        surfaces[precision] = steps.surface
    assert_allclose(surfaces["float32"], surfaces["float64"], atol=1e-4)
    assert not np.array_equal(surfaces["float32"], surfaces["float64"])


@pytest.mark.parametrize("name", ["paper", "released-code", "best"])
def test_what_is_held_out_has_no_part_in_the_iterates(name):
    frame, labels = _bumpy((50, 70))
    block = find_blocks(labels)[1]
    # flying pixels and noise, which are found with all of the depth, are switched off and given
    parameters = ilf.PRESETS[name].replace(
        validation_share=0.1, max_iterations=60, mode="fill+denoise", jump_share=0.0, noise=0.01
    )
    known = block.mask & frame.known[block.box]
    held_out = hold_out_mask(known, 0.1)
    assert np.count_nonzero(held_out) == int(0.1 * np.count_nonzero(known))
    assert not (held_out & ~known).any()
    other = frame.depth.copy()
    other[block.box][held_out] += 0.5
    runs = []
    for depth in (frame.depth, other):
        changed = ilf.RGBDFrame(frame.rgb, depth)
        steps = _stepper(changed, block, parameters)
        runs.append(([(record.sigma_i, record.residual, record.held_out) for record in steps], steps.surface))
    (before, surface), (after, same_surface) = runs
    np.testing.assert_array_equal(surface, same_surface)
    assert [record[:2] for record in before] == [record[:2] for record in after]
    assert all(b[2] != a[2] for b, a in zip(before, after, strict=True))


def _stepper(frame, block, parameters):
    if parameters.filter == "edge-aware":
        return EdgeAwareIteration(frame, block, parameters, without_edges(frame))
    return PassBandIteration(frame, block, parameters)


def test_surface_before_the_first_step_is_the_mean_or_nothing():
    frame, labels = _bumpy((30, 40))
    known = frame.depth[(labels == 1) & frame.known].astype(float)
    assert_allclose(ilf.iterate(frame, labels, 1, ilf.preset("paper", centred=True)).surface, known.mean())
    assert not ilf.iterate(frame, labels, 1, ilf.preset("paper")).surface.any()


def test_linear_schedule_has_the_released_codes_radii():
    frame, labels = _tiny(shape=(40, 60))
    steps = ilf.iterate(frame, labels, 1, ilf.preset("released-code"))
    records = [next(steps) for _ in range(120)]
    for record in records:
        i = record.i
        assert record.radii[0] == pytest.approx(0.5 * 80 / 40 + 80 / (15 * 1500) * (i - 1))
        assert record.radii[1] == pytest.approx(0.5 * 120 / 60 + 120 / (15 * 1500) * (i - 1))
    assert [record.weighted for record in records] == [True] * 99 + [False] * 21


@pytest.mark.parametrize(
    ("lengths", "start", "step", "first", "last", "stages"),
    [
        ((30.0, 20.0), 0.0, 0.5, 0.0, 1 / 15, 5),  # to the shortest wavelength: 2 basebands in steps of at most 0.5
        ((30.0, 8.0), 0.0, 0.5, 0.0, 1 / 8, 9),  # to the baseband of the shorter side
        ((30.0, 1.5), 0.0, 5.0, 0.0, 0.5, 4),  # and no further than one wave over two pixels
        ((30.0, 1.0), 0.0, 5.0, 0.0, 0.5, 4),
        ((30.0, 8.0), 2.0, 1.0, 2 / 30, 1 / 8, 3),
        ((30.0, 8.0), 9.0, 1.0, 9 / 30, 9 / 30, 1),  # a start beyond the end is the end
    ],
)
def test_stages_divide_the_way_to_the_last_radius_evenly(lengths, start, step, first, last, stages):
    parameters = ilf.preset("paper", staged_start=start, stage_step=step, shortest_wavelength=15.0)
    schedule = StagedSchedule((80, 120), lengths, parameters)
    found = [schedule.radii]
    assert not schedule.advance(steady=False)
    assert schedule.radii == found[0]
    while not schedule.advance(steady=True):
        found.append(schedule.radii)
    expected = np.linspace(first, last, stages)[:, None] * (80, 120)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert not schedule.advance(steady=False), "the last stage goes on until it is steady"


def test_a_band_limited_surface_is_recovered():
    """Papoulis and Gerchberg: what lies in the pass band comes back exactly where a few pixels are missing."""
    rows, columns = np.mgrid[:32, :40]
    ground_truth = 2.0 + 0.1 * np.cos(2 * np.pi * rows / 32) + 0.1 * np.sin(2 * np.pi * columns / 40)
    depth = ground_truth.copy()
    depth[10:16, 12:20] = np.nan
    frame = ilf.RGBDFrame(np.full((32, 40, 3), 120, np.uint8), depth)
    parameters = ilf.preset("paper", padding=1.0, rgb_iterations=0, s_criteria=1e-9, shortest_wavelength=20.0)
    steps = ilf.iterate(frame, np.ones((32, 40), np.int32), 1, parameters)
    list(steps)
    assert steps.settled
    assert_allclose(steps.surface, ground_truth.ravel(), atol=1e-6)


def test_where_the_pass_band_ends_its_filter_changes_nothing():
    """The surface is a fixed point of: known depth where it is known, the surface elsewhere, low-pass filtered."""
    frame, _ = _bumpy((32, 40))
    parameters = ilf.preset(
        "paper", padding=1.0, rgb_iterations=0, s_criteria=1e-7, shortest_wavelength=10.0, max_iterations=20_000
    )
    steps = ilf.iterate(frame, np.ones(frame.shape, np.int32), 1, parameters)
    *_, last = steps
    assert steps.settled
    surface = steps.surface.reshape(frame.shape)
    spectrum = np.fft.rfft2(np.where(frame.known, frame.depth, surface))
    spectrum *= inside_ellipse(squared_wave_numbers(frame.shape), last.radii)
    assert_allclose(np.fft.irfft2(spectrum, s=frame.shape), surface, atol=1e-6)


def test_colour_weight_is_a_symmetric_spectrum_in_0_1_with_its_top_at_zero_frequency():
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (9, 12, 3), dtype=np.uint8)
    mask = np.ones((9, 12), bool)
    weight = colour_weight(rgb, mask, (18, 24), 0)
    assert weight.shape == (18, 13)
    assert weight.min() >= 0
    assert weight[0, 0] == weight.max() == 1.0
    assert_allclose(weight[1:, 0], weight[:0:-1, 0], rtol=1e-9)
    dilated = colour_weight(rgb, mask, (18, 24), 2)
    assert (dilated >= weight).all()
    assert dilated[2, 0] == dilated[-2, 0] == dilated[0, 2] == 1.0


def test_colour_weight_of_a_black_block_leaves_the_filter_alone():
    weight = colour_weight(np.zeros((4, 4, 3), np.uint8), np.ones((4, 4), bool), (8, 8), 3)
    assert (weight == 1).all()


def test_ellipse_holds_its_rim_and_degenerate_radii():
    squared = squared_wave_numbers((12, 16))
    band = inside_ellipse(squared, (3.0, 4.0))
    assert band[3, 0]
    assert band[-3, 0]
    assert band[0, 4]
    assert not band[4, 0]
    assert not band[3, 1]
    assert inside_ellipse(squared, (0.0, 0.0)).sum() == 1


def test_principal_lengths_follow_a_turned_bar():
    mask = np.zeros((60, 60), bool)
    for k in range(40):
        mask[10 + k : 13 + k, 10 + k] = True
    longest, shortest = principal_lengths(mask)
    assert longest == pytest.approx(40 * math.sqrt(2), rel=0.06)
    assert shortest < 4
    assert principal_lengths(np.ones((1, 1), bool)) == (1.0, 1.0)
