"""The recipes of the networks: a step of training on a few pixels, and networks that the library can use."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import train
from recipes.sparse_samples import Sample

from ilf.completion.correction import CorrectionNetwork
from ilf.completion.sparse_correction import CHANNELS, SparseCorrectionNetwork
from ilf.segmentation.edges.detectors import DepthEdgeNetwork, EdgeNetwork

from .tiny_data import write_bsds500, write_correction_sample, write_picture

RGB = np.random.default_rng(0).integers(0, 256, (48, 64, 3), np.uint8)
DEPTH = np.full((48, 64), 2, np.float32)
HOLES = np.where(np.indices(DEPTH.shape).sum(0) % 7, np.float32(np.nan), DEPTH)
FLAT = np.zeros_like(DEPTH)

Use = Callable[[Path], np.ndarray]
USES: dict[str, Use] = {
    "depth-edges": lambda path: DepthEdgeNetwork.load(path).look(RGB, HOLES)[0],
    "contours": lambda path: EdgeNetwork.load(path).strength(RGB),
    "correction": lambda path: CorrectionNetwork.load(path).change(RGB, HOLES, DEPTH, FLAT),
    "sparse-correction": lambda path: SparseCorrectionNetwork.load(path).change(RGB, HOLES, DEPTH, FLAT, FLAT),
    "bsds500": lambda path: EdgeNetwork.load(path).strength(RGB),
}
"""What the library does with each network."""


@pytest.fixture
def threads():
    """Training takes threads from OpenCV."""
    before = cv2.getNumThreads()
    yield
    cv2.setNumThreads(before)


def write_data(network, folder):
    if network == "bsds500":
        write_bsds500(folder, 3)
    elif network == "sparse-correction":
        write_sparse_samples(folder)
    else:
        write = write_correction_sample if network == "correction" else write_picture
        for number in (3, 41):
            write(folder, f"{number:06d}-0" if network == "correction" else number)


def write_sparse_samples(folder):
    """Samples of some frames, one of which is held out: 2 m, corrected to 2.1 m."""
    rng = np.random.default_rng(5)
    for name in ("a", "frame_3", *(f"b{k}" for k in range(20))):
        true = np.where(rng.random((70, 90)) < 0.8, 2, np.nan).astype(np.float32)
        features = rng.normal(size=(len(CHANNELS), 70, 90)).astype(np.float32)
        one = np.ones((70, 90), np.float32)
        Sample(features, true, np.float32(2.1) * one, one).save(folder / f"measured-{name}-0.npz")


# warnings of PyTorch's export
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")
@pytest.mark.usefixtures("threads")
@pytest.mark.parametrize("network", train.MINUTES)
def test_a_step_is_trained_and_the_library_uses_the_network(network, tmp_path, capsys):
    torch = pytest.importorskip("torch", reason="training needs PyTorch")
    pytest.importorskip("onnx", reason="training needs onnx")
    data, out = tmp_path / "data", tmp_path / "out"
    data.mkdir()
    write_data(network, data)
    arguments = [network, "--data", str(data), "--out", str(out), "--threads", "1", "--minutes", "1e-6"]
    assert train.main(arguments) == 0
    assert capsys.readouterr().out.startswith("step 1, ")
    assert (out / "log.csv").read_text().count("\n") == 2
    found = USES[network](next(out.glob("*.onnx")))
    assert found.shape == DEPTH.shape
    assert np.isfinite(found).all()
    state = torch.load(out / "checkpoint.pt", weights_only=True)
    assert state["step"] == 1
    assert train.main([*arguments, "--resume"]) == 0, "the time is over"
    assert torch.load(out / "checkpoint.pt", weights_only=True)["step"] == 1


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")
@pytest.mark.usefixtures("threads")
def test_a_training_that_starts_from_a_network_ends_at_a_mean_of_both(tmp_path, monkeypatch):
    pytest.importorskip("torch", reason="training needs PyTorch")
    onnx = pytest.importorskip("onnx", reason="training needs onnx")
    from recipes.sparse_correction import SparseCorrectionRecipe

    write_sparse_samples(tmp_path)

    def weights(folder, *given):
        arguments = ["sparse-correction", "--data", str(tmp_path), "--out", str(folder), "--threads", "1"]
        assert train.main([*arguments, "--minutes", "1e-6", *given]) == 0
        graph = onnx.load(str(folder / "sparse-correction.onnx")).graph
        return [onnx.numpy_helper.to_array(one) for one in graph.initializer]

    monkeypatch.setattr(SparseCorrectionRecipe, "seed", 5)
    first = weights(tmp_path / "first")
    start = ("--start", str(tmp_path / "first" / "sparse-correction.onnx"))
    mean = weights(tmp_path / "mean", *start)
    monkeypatch.setattr(SparseCorrectionRecipe, "finish", lambda self, path: None)
    trained = weights(tmp_path / "trained", *start)
    for before, after, both in zip(first, trained, mean, strict=True):
        assert both == pytest.approx(0.6 * before + 0.4 * after, abs=1e-6)


def test_without_pytorch_one_line_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    assert train.main(["contours", "--data", str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    told = capsys.readouterr().err
    assert "pip install torch onnx" in told
    assert told.count("\n") == 1


def test_the_loss_of_sparse_depth_is_that_of_its_formula(tmp_path):
    torch = pytest.importorskip("torch", reason="training needs PyTorch")
    from recipes.sparse_correction import SparseCorrectionRecipe, errors

    write_sparse_samples(tmp_path)
    recipe = SparseCorrectionRecipe(tmp_path)
    batch = tuple(torch.from_numpy(one).permute(0, 3, 1, 2) for one in recipe.batch(np.random.default_rng(0)))
    change = torch.full((4, 1, *batch[0].shape[2:]), -0.02)
    mean, rms = errors(change, batch[1])
    expected = abs(2.1 * np.exp(-0.02) - 2)
    assert mean.numpy() == pytest.approx(expected, rel=1e-4)
    assert rms.numpy() == pytest.approx(expected, rel=1e-3)
    unchanged = 0.1 / (0.1 + 0.021) + 0.1 / (0.1 + 0.042)
    assert float(recipe.loss(recipe.new_model().eval(), batch).detach()) == pytest.approx(unchanged, rel=1e-3)


def test_the_gradient_of_spread_changes_is_that_of_their_values():
    torch = pytest.importorskip("torch", reason="training needs PyTorch")
    from recipes.correction_model import conduct

    rng = np.random.default_rng(0)
    sizes = ((1, 3, 3), (1, 2, 4), (1, 3, 3), (1, 2, 4), (1, 3, 4), (1, 3, 4))
    inputs = [torch.from_numpy(rng.uniform(0.5, 1, size)).requires_grad_() for size in sizes]
    assert torch.autograd.gradcheck(conduct, inputs)
