"""Samples that the correction of sparse depth learns from."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from ilf.completion.sparse_correction import CHANNELS
from ilf.data.frame import RGBDFrame
from ilf.errors import InputError
from ilf.lab.training.sparse_correction.samples import Sample, is_held_out, kept_pixels, make_samples

SHAPE = (120, 160)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
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


def test_what_is_kept_is_known_and_sparse() -> None:
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


def test_samples_are_made_once_and_read_again(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "samples"
    make_samples([folder], out, 1)
    paths = sorted(out.glob("*.npz"))
    assert paths
    assert all(path.stem.startswith("frame_0-") for path in paths)
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


def test_what_is_no_sample_is_named(tmp_path: Path) -> None:
    path = tmp_path / "frame_0-0.npz"
    np.savez(path, features=np.zeros(3))
    with pytest.raises(InputError, match=r"frame_0-0\.npz is not a sample"):
        Sample.load(path)


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")  # of PyTorch's export
def test_the_loss_is_that_of_its_formula_and_the_file_gives_what_the_model_does(tmp_path: Path) -> None:
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnx")
    from ilf.completion.sparse_correction import SparseCorrectionNetwork
    from ilf.lab.training.sparse_correction.task import SparseCorrectionTraining, errors

    rng = np.random.default_rng(5)
    for name in ("a-0", "frame_3-0", *(f"b{k}-0" for k in range(20))):
        true = np.where(rng.random((70, 90)) < 0.8, 2, np.nan).astype(np.float32)
        features = rng.normal(size=(len(CHANNELS), 70, 90)).astype(np.float32)
        Sample(features, true, np.full((70, 90), 2.1, np.float32), np.ones((70, 90), np.float32)).save(
            tmp_path / f"{name}.npz"
        )
    task = SparseCorrectionTraining(tmp_path)
    batch = tuple(torch.from_numpy(one).permute(0, 3, 1, 2) for one in task.batch(np.random.default_rng(0)))
    change = torch.full((4, 1, *batch[0].shape[2:]), -0.02)
    mean, rms = errors(change, batch[1])
    expected = abs(2.1 * np.exp(-0.02) - 2)
    assert mean.numpy() == pytest.approx(expected, rel=1e-4)
    assert rms.numpy() == pytest.approx(expected, rel=1e-3)
    model = task.new_model().eval()
    assert float(task.loss(model, batch).detach()) == pytest.approx(
        0.1 / (0.1 + 0.021) + 0.5 * 0.1 / (0.1 + 0.042), rel=1e-3
    )
    torch.nn.init.normal_(model.last.weight)
    task.export(model, tmp_path / "net.onnx")
    sample = rng.normal(size=(len(CHANNELS), 30, 40)).astype(np.float32)
    found = SparseCorrectionNetwork.load(tmp_path / "net.onnx")._cells(sample)
    with torch.no_grad():
        np.testing.assert_allclose(found, model(torch.from_numpy(sample)[None])[0, 0].clamp(-1.5, 1.5), atol=1e-4)
