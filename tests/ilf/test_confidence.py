"""The expected error: where it is, how it grows, and that it comes back from data made by its own law."""

import json
from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.bench import METHODS
from ilf.bench.calibration import Sample, calibrate, fit, main
from ilf.completion import complete
from ilf.confidence import FLOOR, MODELS, ErrorModel, depth_error, error_features, expected_error
from ilf.errors import InputError, ParameterError
from ilf.parameters import Parameters

from .small_frames import QUICK, write_small_frame

ROWS, COLUMNS = np.mgrid[:96, :128].astype(np.float32)
PLANE = (2 + 0.002 * ROWS + 0.004 * COLUMNS).astype(np.float32)
HOLE = (ROWS - 48) ** 2 + (COLUMNS - 64) ** 2 < 30**2
COLOUR = np.zeros((*PLANE.shape, 3), np.uint8)


def error_of(depth, hole=HOLE, completed=None):
    frame = ilf.RGBDFrame(COLOUR, np.where(hole, np.nan, depth))
    return depth_error(frame, depth if completed is None else completed)


def test_there_is_one_wherever_depth_was_filled_and_nowhere_else():
    completed = PLANE.copy()
    completed[40:44, 60:70] = np.nan
    completed[44:48, 60:70] = 0
    error = error_of(PLANE, completed=completed)
    assert error.dtype == np.float32
    np.testing.assert_array_equal(np.isfinite(error), HOLE & (np.nan_to_num(completed) > 0))
    assert (error[np.isfinite(error)] > 0).all()
    assert not np.isfinite(error_of(PLANE, hole=np.zeros_like(HOLE))).any()


@pytest.mark.parametrize("model", MODELS)
def test_it_grows_with_the_distance_to_known_depth(model):
    frame = ilf.RGBDFrame(COLOUR, np.where(COLUMNS >= 32, np.nan, PLANE))
    error = depth_error(frame, PLANE, model)
    inner = error[48, 32:-1]
    assert (np.diff(inner) > -1e-6 * inner[:-1]).all()
    assert inner[-1] > 3 * inner[0]


def test_flat_depth_is_trusted_and_rough_depth_is_not():
    rng = np.random.default_rng(0)
    flat, rough = np.full_like(PLANE, 2.0), (2 + rng.normal(0, 0.05, PLANE.shape)).astype(np.float32)
    small, large = (error_of(depth, completed=np.where(HOLE, 2.0, depth)) for depth in (flat, rough))
    assert np.nanmax(small) < 0.01
    assert np.nanmedian(large) > 3 * np.nanmedian(small)


def test_a_jump_away_from_the_known_depth_is_doubted():
    near, far = (error_of(PLANE, completed=np.where(HOLE, PLANE + step, PLANE)) for step in (0.02, 0.5))
    assert (far[HOLE] > near[HOLE]).all()


def test_it_grows_with_depth_at_least_in_proportion_but_never_beyond_it():
    near, far = error_of(PLANE), error_of(3 * PLANE)
    assert (far[HOLE] > 2.99 * near[HOLE]).all()
    wild = np.where(HOLE, np.random.default_rng(0).uniform(0.2, 40, PLANE.shape), PLANE).astype(np.float32)
    error = error_of(PLANE, completed=wild)
    assert (error[HOLE] <= wild[HOLE]).all()
    assert (error[HOLE] >= 0.999 * FLOOR * wild[HOLE]).all()


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (3, 3), (7, 33)])
def test_a_single_known_pixel_gives_finite_errors_that_are_no_certainty(shape):
    depth = np.full(shape, np.nan, np.float32)
    depth[0, 0] = 2.0
    frame = ilf.RGBDFrame(np.zeros((*shape, 3), np.uint8), depth)
    error = depth_error(frame, np.full(shape, 2.0, np.float32))
    assert np.isfinite(error).sum() == depth.size - 1
    assert np.nanmin(error) > 2 * FLOOR * 2.0


def test_each_block_of_a_completion_has_the_model_of_its_filter(tmp_path):
    frame = ilf.load_frame(*write_small_frame(tmp_path))
    labels = np.tile(np.where(np.arange(80) < 40, 1, 2).astype(np.int32), (60, 1))
    completion = complete(frame, labels, ilf.preset("paper", **QUICK, rgb_iterations=5))
    of_filter = {name: depth_error(frame, completion.depth, name) for name in MODELS}
    np.testing.assert_array_equal(expected_error(frame, completion), of_filter["ideal"])
    second = replace(completion.results[2], parameters=Parameters(filter="edge-aware"))
    mixed = replace(completion, results={**completion.results, 2: second})
    expected = np.where(labels == 1, of_filter["ideal"], of_filter["edge-aware"])
    np.testing.assert_array_equal(expected_error(frame, mixed), expected)
    np.testing.assert_array_equal(np.isfinite(expected), completion.filled)
    guesses = replace(completion, guessed=completion.filled & (labels == 2))
    np.testing.assert_array_equal(expected_error(frame, guesses), expected)


def test_what_does_not_fit_is_refused():
    frame = ilf.RGBDFrame(COLOUR, np.where(HOLE, np.nan, PLANE))
    with pytest.raises(InputError, match="does not belong"):
        depth_error(frame, PLANE[1:])
    with pytest.raises(ParameterError, match="no error model 'wavelet'"):
        depth_error(frame, PLANE, "wavelet")


def test_the_fit_finds_the_law_that_made_the_errors_and_calibrates_it():
    rng = np.random.default_rng(0)
    law = ErrorModel(-1.5, 0.1, 0.2, 0.3, 0.6, 0.7, 0.15)
    samples = []
    for name in ("a", "b", "c"):
        rough = (PLANE + rng.normal(0, 0.01, PLANE.shape)).astype(np.float32)
        hidden = rng.uniform(size=PLANE.shape) < 0.7
        frame = ilf.RGBDFrame(COLOUR, np.where(hidden | HOLE, np.nan, rough))
        features = error_features(frame, (rough + rng.normal(0, 0.03, PLANE.shape)).astype(np.float32))
        shares = law.shares(features) * np.abs(rng.normal(size=len(features)))
        samples.append(Sample(name, "random", features, shares, np.ones(len(features), np.float32)))
    found = fit(samples)
    (line,) = calibrate(found, samples)
    assert line.mean == pytest.approx(0.6827, abs=0.01)
    ratio = found.shares(samples[0].features) / law.shares(samples[0].features)
    assert np.quantile(np.abs(np.log(ratio)), 0.95) < 0.1
    (half,) = calibrate(ErrorModel(-9.0, 0, 0, 0, 0, 0, 0), samples)
    assert half.mean < 0.1


def test_calibration_command(tmp_path, capsys):
    for name in ("one", "two"):
        write_small_frame(tmp_path / name)
        (tmp_path / name / "meta.json").write_text(json.dumps({"name": name, "depth_units_per_m": 1000}))
    arguments = ["--method", "linear", "--fit", str(tmp_path / "one"), "--check", str(tmp_path / "two")]
    assert "linear" in METHODS
    assert main(arguments) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("ErrorModel(")
    assert [line.split(":")[0] for line in lines[1:]] == [
        "fitted, random", "fitted, areas", "checked, random", "checked, areas",
    ]  # fmt: skip
    assert main(["--method", "linear", "--check", str(tmp_path / "none")]) == 1
    assert "is not a folder" in capsys.readouterr().err
