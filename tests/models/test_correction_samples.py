"""Samples that the correction network learns from."""

import numpy as np
from recipes.correction_samples import UNKNOWN_LINES, SampleFolder, augmented, read_sample

from ilf.completion.correction import CHANNELS

from .tiny_data import write_correction_sample


def test_samples_of_pictures_with_low_numbers_are_held_out(tmp_path):
    for name in ("000041-0", "000003-1", "000003-0", "100-0", "000041", "other-0"):
        write_correction_sample(tmp_path, name)
    folder = SampleFolder(tmp_path)
    assert [path.stem for path in folder.held_out] == ["000003-0", "000003-1"]
    assert [path.stem for path in folder.learnt] == ["000041-0", "100-0"], "in order of numbers"


def test_a_sample_has_depth_less_the_median_of_the_known_one(tmp_path):
    image, features, lines, log_depth, completed = read_sample(write_correction_sample(tmp_path, "000041-0"))
    assert image.shape == (32, 32, 3)
    assert features.shape == (32, 32, len(CHANNELS))
    assert lines.shape == (32, 32, 2)
    np.testing.assert_allclose(completed - log_depth, np.log(1.01), rtol=1e-3)


def test_a_mirrored_sample_marks_the_same_pairs(tmp_path):
    sample = read_sample(write_correction_sample(tmp_path, "000041-0"))
    seen = {augmented(sample, np.random.default_rng(seed))[2][0, :, 0].argmax() for seed in range(8)}
    # pixels 5 and 6 are the pair; mirrored, 25 and 26 are
    assert seen == {5, 25}


def test_lines_of_real_frames_are_not_known(tmp_path):
    path = write_correction_sample(tmp_path, "900000-0")
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **{**arrays, "lines": np.full((32, 32, 2), UNKNOWN_LINES, np.uint8)})
    assert np.isnan(read_sample(path)[2]).all()
