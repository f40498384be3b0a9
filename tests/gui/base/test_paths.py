"""Paths that are given or dropped are sorted by what they are."""

import pytest

from gui.base.paths import sort_paths


@pytest.mark.parametrize("names", [("rgb.png", "depth.mat"), ("rgb.png", "take.h5:/depth"), ("depth.mat", "bag.mcap")])
def test_a_matlab_file_after_a_colour_image_is_its_depth(tmp_path, names):
    for name in ("rgb.png", "depth.mat", "take.h5", "bag.mcap"):
        (tmp_path / name).touch()
    paths = [tmp_path / name for name in names]
    is_pair = names[0] == "rgb.png"
    assert sort_paths(paths) == ([], [] if is_pair else paths, [], paths if is_pair else [])
