"""Guides by a user's own network: what it is given, and what its answer becomes."""

from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.errors import FormatError, InputError
from ilf.io.guide_models import GuideNetwork

from ..tiny_onnx import node, write_network

MEAN, DEVIATION = np.float32((0.485, 0.456, 0.406)), np.float32((0.229, 0.224, 0.225))


@pytest.fixture(autouse=True)
def _not_cached(monkeypatch):
    monkeypatch.setattr("ilf._runtime.networks.network._networks", {})


def brightness(path: Path) -> Path:
    """A network that predicts the mean of its normalised channels."""
    return write_network(path, [node("ReduceMean", ["image"], "strength", axes=[1], keepdims=1)])


def scene() -> tuple[np.ndarray, np.ndarray]:
    """A box before a wall, brighter where it is nearer; its depth has a hole over the box's rim."""
    rows, columns = np.indices((90, 120), np.float32)
    depth = np.where((abs(rows - 45) < 25) & (abs(columns - 60) < 30), 1.2 + rows / 300, 2 + columns / 120)
    # the mean of the channels has steps of a third
    rgb = np.floor(255 * (1.1 / depth)[..., None] + np.array([1, 3, 5]) / 6).astype(np.uint8)
    return rgb, depth.astype(np.float32)


def write_scene(folder: Path) -> Path:
    """The scene as a frame folder, with a gap in its depth."""
    rgb, depth = scene()
    depth[30:60, 70:110] = np.nan
    folder.mkdir(parents=True)
    (folder / "meta.json").write_text('{"depth_units_per_m": 1000}')
    cv2.imwrite(str(folder / "rgb.png"), rgb)
    cv2.imwrite(str(folder / "depth.png"), np.nan_to_num(1000 * depth).astype(np.uint16))
    return folder


def test_a_network_gets_normalised_colour_and_its_output_is_resized_to_the_frame(tmp_path):
    rgb, _ = scene()
    values = GuideNetwork.load(brightness(tmp_path / "net.onnx")).predict(rgb)
    assert values.shape == rgb.shape[:2]
    expected = ((rgb / 255 - MEAN) / DEVIATION).mean(axis=2)
    inside = np.s_[30:60, 40:80]
    np.testing.assert_allclose(values[inside], expected[inside], atol=0.02)


def test_a_file_that_is_no_guide_network_is_one_line(tmp_path):
    with pytest.raises(InputError, match=r"There is no guide network at .* or a file with the guide's values"):
        ilf.load_guide(tmp_path / "none.onnx", rgb=scene()[0])
    (tmp_path / "foreign.onnx").write_bytes(b"no network")
    with pytest.raises(FormatError, match=r"foreign\.onnx cannot be read as an ONNX network"):
        ilf.load_guide(tmp_path / "foreign.onnx", rgb=scene()[0])
    three = write_network(tmp_path / "three.onnx", [node("Relu", ["image"], "strength")], outputs={"strength": 3})
    with pytest.raises(FormatError, match=r"three\.onnx is not a guide network: its output is \(1, 3, .* per pixel"):
        ilf.load_guide(three, rgb=scene()[0])
    depth_too = write_network(
        tmp_path / "two.onnx",
        [node("ReduceMean", ["depth"], "strength", axes=[1], keepdims=1)],
        {"image": 3, "depth": 6},
    )
    with pytest.raises(FormatError, match=r"two\.onnx is not a guide network: it does not accept one RGB image"):
        ilf.load_guide(depth_too, rgb=scene()[0])
    with pytest.raises(InputError, match="predicts a guide from the frame's colour"):
        ilf.load_guide(brightness(tmp_path / "net.onnx"))
