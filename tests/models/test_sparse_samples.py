"""Samples that the correction of sparse depth learns from."""

import cv2
import numpy as np
import pytest
from recipes import sparse_samples
from recipes.sparse_samples import Sample, is_held_out, kept_pixels, make_samples

from ilf.completion.sparse_correction import CHANNELS
from ilf.data.frame import RGBDFrame

SHAPE = (120, 160)


@pytest.fixture
def folder(tmp_path):
    """A real frame's folder: a slope, two thirds of it known."""
    rows, columns = np.indices(SHAPE)
    depth = 1500 + 4 * rows + 2 * columns
    depth[:40] = 0
    path = tmp_path / "frame_0"
    path.mkdir()
    cv2.imwrite(str(path / "rgb.jpg"), np.random.default_rng(0).integers(0, 255, (*SHAPE, 3), np.uint8))
    cv2.imwrite(str(path / "depth.png"), depth.astype(np.uint16))
    (path / "meta.json").write_text('{"depth_units_per_m": 1000}')
    return path


def test_what_is_kept_is_known_and_sparse():
    rng = np.random.default_rng(3)
    depth = np.where(rng.random(SHAPE) < 0.8, np.float32(2), np.float32(np.nan))
    frame = RGBDFrame(rng.integers(0, 255, (*SHAPE, 3)).astype(np.uint8), depth)
    shares = []
    for _ in range(30):
        kept = kept_pixels(frame, rng)
        assert not np.any(kept & ~frame.known)
        shares.append(kept.mean())
    assert 0 < min(shares) < 0.02
    assert max(shares) < 0.6


def test_samples_are_made_once_and_read_again(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(sparse_samples, "FROM_EACH", 2)
    out = tmp_path / "samples"
    make_samples([folder], out, 1)
    paths = sorted(out.glob("*.npz"))
    assert paths
    assert all(path.stem.startswith("measured-frame_0-") for path in paths)
    before = [path.stat().st_mtime_ns for path in paths]
    make_samples([folder], out, 1)
    assert [path.stat().st_mtime_ns for path in paths] == before
    sample = Sample.load(paths[0])
    assert sample.features.shape == (len(CHANNELS), *sample.true.shape)
    learnt = np.isfinite(sample.true)
    assert learnt.any()
    assert np.all(sample.fading[learnt] > 0)
    assert np.all((sample.true[learnt] > 1.4) & (sample.true[learnt] < 2.5)), "in metres"
    assert is_held_out(paths[0]) == is_held_out(paths[-1]), "a frame is held out with all its samples"
