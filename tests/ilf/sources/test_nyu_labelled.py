"""NYU Depth V2's labelled file: read as the toolbox stores it, and refused with one clear message."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from ilf import open_source
from ilf.errors import FormatError, InputError

FRAMES, HEIGHT, WIDTH = 5, 24, 32


def depth_of(index):
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return (2 + 0.1 * index + 0.01 * rows + 0.02 * columns).astype(np.float32)


def colour_of(index):
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return np.stack([rows * 8, columns * 4, np.full(rows.shape, 10 * index)], axis=-1).astype(np.uint8)


def hole():
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[5:12, 8:20] = True
    return mask


@pytest.fixture
def labelled(tmp_path):
    """A file of the structure that MATLAB writes: every array with its axes the other way round."""
    path = tmp_path / "nyu_depth_v2_labeled.mat"
    filled = np.stack([depth_of(index).T for index in range(FRAMES)])
    with h5py.File(path, "w", userblock_size=512) as file:
        file["images"] = np.stack([colour_of(index).transpose(2, 1, 0) for index in range(FRAMES)])
        file["depths"] = filled
        file["rawDepths"] = np.where(hole().T, np.float32(0), filled)
    return path


def test_frames_come_out_upright_with_their_holes(labelled):
    source = open_source(labelled)
    assert source.keys == ("1", "2", "3", "4", "5")
    frame = source["4"]
    assert np.array_equal(frame.rgb, colour_of(3))
    assert np.array_equal(frame.known, ~hole())
    assert np.array_equal(frame.depth[~hole()], depth_of(3)[~hole()])
    assert frame.ground_truth is None, "depth in the holes is the toolbox's in-painting"
    assert frame.intrinsics is None, "those of NYU are for 640 x 480"
    with pytest.raises(InputError, match="has no frame '6'"):
        source["6"]


def _without(path: Path, name: str) -> None:
    with h5py.File(path, "a") as file:
        del file[name]


def _of_other_size(path: Path, name: str) -> None:
    _without(path, name)
    with h5py.File(path, "a") as file:
        file[name] = np.ones((FRAMES, 3, 2, 2), np.uint8)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: _without(path, "rawDepths"), "has no rawDepths"),
        (lambda path: _of_other_size(path, "images"), "do not fit each other"),
        (lambda path: path.write_bytes(path.read_bytes()[:3000]), "not a complete HDF5"),
        (lambda path: path.write_bytes(b"MATLAB 5.0 MAT-file"), r"a MATLAB file \(5\), not an HDF5"),
        (lambda path: path.write_bytes(b""), "is empty"),
    ],
)
def test_bad_files_are_refused(labelled, spoil, message):
    spoil(labelled)
    with pytest.raises(FormatError, match=message):
        open_source(labelled)
