"""NYU Depth V2's labelled file: read as the toolbox stores it, split, and refused with one clear message."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from ilf.errors import FormatError, InputError
from ilf.lab.experiments.experiment import Settings
from ilf.lab.experiments.sources import find_sources, load_source
from ilf.sources.nyu import NyuLabelled, read_split

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
    with NyuLabelled(labelled) as file:
        assert len(file) == FRAMES
        frame = file.frame(3)
        assert frame.name == "nyu_0004"
        assert np.array_equal(frame.rgb, colour_of(3))
        assert np.array_equal(frame.known, ~hole())
        assert np.array_equal(frame.depth[~hole()], depth_of(3)[~hole()])
        assert np.array_equal(file.filled(3), depth_of(3))
        assert frame.intrinsics is None, "those of NYU are for 640 x 480"
        with pytest.raises(InputError, match="no frame 6; it has 1 to 5"):
            file.frame(FRAMES)


def test_the_official_split_beside_the_file_is_taken(labelled):
    savemat(labelled.with_name("splits.mat"), {"testNdxs": np.array([[2], [5]]), "trainNdxs": np.array([[1]])})
    sources = find_sources(Settings(data=labelled))
    assert [(source.name, source.index) for source in sources.frames] == [("nyu_0002", 1), ("nyu_0005", 4)]
    assert "2 of 5 frames" in sources.notes[0]
    assert "in-painting" in sources.notes[0]
    loaded = load_source(sources.frames[1])
    assert np.array_equal(loaded.ground_truth, depth_of(4))
    assert np.array_equal(loaded.frame.known, ~hole())


def test_a_list_goes_before_it_and_without_either_all_frames_are_taken(labelled, tmp_path):
    assert len(find_sources(Settings(data=labelled)).frames) == FRAMES
    listed = tmp_path / "mine.txt"
    listed.write_text("4\n1\n4\n")
    assert read_split(listed) == [3, 0]
    savemat(labelled.with_name("splits.mat"), {"testNdxs": np.array([[2]])})
    assert [source.index for source in find_sources(Settings(data=labelled, split=listed)).frames] == [3, 0]


def test_a_quick_run_takes_few_frames_of_few_pixels(labelled):
    sources = find_sources(Settings(data=labelled, quick=True))
    assert [source.index for source in sources.frames] == [0, 2, 4]
    thin = load_source(sources.frames[1])
    assert thin.frame.shape == thin.ground_truth.shape == (HEIGHT // 2, WIDTH // 2)
    assert np.array_equal(thin.ground_truth, depth_of(2)[::2, ::2])


def _without(path: Path, name: str) -> None:
    with h5py.File(path, "a") as file:
        del file[name]


def _of_other_size(path: Path, name: str) -> None:
    _without(path, name)
    with h5py.File(path, "a") as file:
        file[name] = np.ones((FRAMES, HEIGHT, WIDTH), np.float32)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: _without(path, "rawDepths"), "has no rawDepths"),
        (lambda path: _of_other_size(path, "depths"), "do not fit each other"),
        (lambda path: path.write_bytes(path.read_bytes()[:3000]), "not a complete HDF5"),
        (lambda path: path.write_bytes(b"MATLAB 5.0 MAT-file"), r"a MATLAB file \(5\), not an HDF5"),
        (lambda path: path.write_bytes(b""), "is empty"),
    ],
)
def test_bad_files_are_refused(labelled, spoil, message):
    spoil(labelled)
    with pytest.raises(FormatError, match=message):
        NyuLabelled(labelled)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        find_sources(Settings(data=tmp_path / "nyu.mat"))


def test_bad_splits_are_refused(labelled, tmp_path):
    words = tmp_path / "words.txt"
    words.write_text("one\ntwo\n")
    with pytest.raises(FormatError, match="one whole number per line"):
        read_split(words)
    words.write_text("0\n")
    with pytest.raises(FormatError, match="whole numbers from 1"):
        read_split(words)
    other = tmp_path / "other.mat"
    savemat(other, {"trainNdxs": np.array([[1]])})
    with pytest.raises(FormatError, match="lists no frames"):
        read_split(other)
    with pytest.raises(FormatError, match=r"not a MATLAB v5 file|lists no frames"):
        read_split(labelled)
    words.write_text("7\n")
    with pytest.raises(InputError, match="lists frame 7, but"):
        find_sources(Settings(data=labelled, split=words))
    with pytest.raises(InputError, match="Give that file as the data"):
        find_sources(Settings(split=words))
