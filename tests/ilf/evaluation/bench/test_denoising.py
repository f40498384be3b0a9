"""`ilf bench denoise`: its scenes, its peers, and the command."""

import csv

import numpy as np
import pytest

from ilf.evaluation.bench.denoisers import DENOISERS
from ilf.evaluation.bench.denoising import SCENES, StructuredLight


@pytest.mark.parametrize("name", ["cylinder, 6.5 mm", "steps and slopes, Kinect", "things, 0.4 %"])
def test_scenes_have_the_noise_they_tell(name):
    scene, again = SCENES[name](1), SCENES[name](1)
    assert np.array_equal(scene.frame.depth, again.frame.depth, equal_nan=True)
    part = scene.parts.get("flat", scene.parts.get("all"))
    relative = (scene.frame.depth - scene.ground_truth)[part] / scene.noise[part]
    assert 0.9 < relative.std() < 1.2
    assert not any((mask & ~scene.frame.known).any() for mask in scene.parts.values())


@pytest.mark.parametrize("name", DENOISERS)
def test_peers_take_noise_off_a_slope_and_keep_its_depth(name):
    ground_truth = np.broadcast_to(2 + 0.0002 * np.arange(80), (60, 80))
    noisy = ground_truth + 0.01 * np.random.default_rng(0).standard_normal(ground_truth.shape)
    error = DENOISERS[name](noisy, 0.01) - ground_truth
    assert error.std() < 0.007
    assert abs(error.mean()) < 0.001


def test_structured_light_measures_in_steps_whose_size_grows_with_depth():
    light = StructuredLight(500.0)
    near, far = (np.unique(light.measured(np.full((40, 50), z), np.random.default_rng(0))) for z in (1.0, 4.0))
    assert np.diff(far).mean() == pytest.approx(16 * np.diff(near).mean(), rel=0.1)
    assert light.deviation(np.array([4.0])) == pytest.approx(16 * light.deviation(np.array([1.0])))


def test_the_command_compares_and_writes(tmp_path, cli, monkeypatch):
    for name in set(SCENES) - {"cylinder, 6.5 mm"}:
        monkeypatch.delitem(SCENES, name)
    shown = cli("bench", "denoising", "--methods", "input,best,median", "--csv", tmp_path / "rows.csv").out
    assert "cylinder, 6.5 mm: all (230,400 pixels)" in shown
    with open(tmp_path / "rows.csv", newline="") as file:
        errors = {row["method"]: float(row["rmse"]) for row in csv.DictReader(file)}
    assert errors["best"] < errors["median"] / 5 < errors["input"] / 5
    assert errors["input"] == pytest.approx(0.0065, rel=0.01)
