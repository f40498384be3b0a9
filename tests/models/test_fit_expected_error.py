"""The fit of the expected error: data made by a law give it back."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fit_expected_error import Sample, calibrate, fit, main

import ilf
from ilf.completion.confidence.fitted import MODELS
from ilf.completion.confidence.model import (
    FEATURES,
    FLOOR,
    WITHIN,
    WITHIN_TWICE,
    ErrorModel,
    error_features,
    gap_weight,
)

from ..ilf.small_frames import write_small_frame

ROWS, COLUMNS = np.mgrid[:96, :128].astype(np.float32)
PLANE = (2 + 0.002 * ROWS + 0.004 * COLUMNS).astype(np.float32)
HOLE = (ROWS - 48) ** 2 + (COLUMNS - 64) ** 2 < 30**2
COLOUR = np.zeros((*PLANE.shape, 3), np.uint8)


def law(**curves):
    """A model of straight curves: feature -> slope."""
    ends = np.array([-9.0, 9.0])
    slopes = [curves.get(name.replace(" ", "_"), 0.0) for name in FEATURES]
    return ErrorModel(-1.5, tuple((tuple(ends), tuple(slope * ends)) for slope in slopes))


def sample_of(model, rng, name="a", difficulty_samples=None):
    """Pixels of a rough plane with holes, whose errors are as a model says."""
    rough = (PLANE + rng.normal(0, 0.01, PLANE.shape)).astype(np.float32)
    hidden = rng.uniform(size=PLANE.shape) < 0.7
    frame = ilf.RGBDFrame(COLOUR, np.where(hidden | HOLE, np.nan, rough))
    filled = (rough + rng.normal(0, 0.03, PLANE.shape)).astype(np.float32)
    features = error_features(frame, filled, np.zeros(PLANE.shape, np.float32))
    shares = model.shares(features) * np.abs(rng.normal(size=len(features)))
    ones = np.ones(len(features))
    return Sample(name, "random", features, ones, shares, ones.astype(np.float32), difficulty_samples)


def test_the_fit_finds_the_law_that_made_the_errors_and_calibrates_it():
    rng = np.random.default_rng(0)
    made_by = law(depth=0.1, gap=0.2, bend=0.3, small_jump=0.6, large_jump=0.7, slope=0.15)
    samples = [sample_of(made_by, rng, name) for name in ("a", "b", "c")]
    found = fit(samples)
    (line,) = calibrate(samples, [found] * 3)
    assert line.mean == pytest.approx(WITHIN, abs=0.015)
    assert line.twice == pytest.approx(WITHIN_TWICE, abs=0.015)
    ratio = found.shares(samples[0].features) / made_by.shares(samples[0].features)
    assert np.quantile(np.abs(np.log(ratio)), 0.9) < 0.15
    (none,) = calibrate(samples, [replace(law(), level=-9.0)] * 3)
    assert none.mean < 0.1
    assert none.calibrated == 0


def test_what_frames_have_of_their_own_is_found_in_wide_gaps():
    rng = np.random.default_rng(0)
    plain = law(bend=0.3)
    samples = []
    for name, own in (("easy", -0.4), ("usual", 0.0), ("hard", 0.4)):
        sample = sample_of(plain, rng, name)
        shares = sample.shares * np.exp(own * gap_weight(sample.features))
        there = sample.features, np.log(np.maximum(plain.shares(sample.features) * np.exp(own), FLOOR))
        samples.append(replace(sample, shares=shares, difficulty_samples=there))
    found = fit(samples)
    assert found.own == pytest.approx(1.0, abs=0.25)
    easy, usual, hard = (sample.expected(found)[gap_weight(sample.features) == 1].mean() for sample in samples)
    assert easy < 0.75 * usual < 0.75 * 0.75 * hard
    narrow = gap_weight(samples[0].features) == 0
    np.testing.assert_array_equal(samples[0].expected(found)[narrow], found.shares(samples[0].features)[narrow])


def test_the_command_prints_and_writes_the_models(tmp_path, capsys):
    for name in ("one", "other"):
        write_small_frame(tmp_path / name)
        (tmp_path / name / "meta.json").write_text(json.dumps({"name": name, "depth_units_per_m": 1000}))
    one, other, written = (str(tmp_path / name) for name in ("one", "other", "fitted.py"))
    arguments = ["--method", "linear", "--model", "ideal", "--fit", one, other, "--check", other, "--others"]
    assert main([*arguments, "--write", written]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("ErrorModel(")
    assert [line.split(":")[0] for line in lines[1:]] == [
        "fitted, random", "fitted, areas", "checked, random", "checked, areas",
        "fitted to others, random", "fitted to others, areas",
    ]  # fmt: skip
    names: dict[str, dict[str, ErrorModel]] = {}
    exec(Path(written).read_text().replace("from .model", "from ilf.completion.confidence.model"), names)
    models = names["MODELS"]
    assert set(models) == set(MODELS)
    assert str(models["ideal"]) == lines[0]
    assert models["edge-aware"] == MODELS["edge-aware"]
