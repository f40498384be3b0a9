"""The bench of denoising: its scenes and its peers."""

import numpy as np
import pytest

from .denoising.filters import DENOISERS
from .denoising.scenes import SCENES, StructuredLight


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
