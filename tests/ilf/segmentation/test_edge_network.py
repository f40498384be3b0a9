"""The edge network: any size of image, one message for any foreign file, and the network that ships."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest

from ilf._runtime.installation import asset_path
from ilf.errors import FormatError, InputError
from ilf.segmentation.edges.detectors import EdgeNetwork

from ..tiny_onnx import node, write_network

MEAN = node("ReduceMean", ["image"], "strength", axes=[1], keepdims=1)


def noise(height: int, width: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)


@pytest.fixture
def grey(tmp_path):
    """A network whose strength is the mean of the channels, so that every pixel of the result is known."""
    return EdgeNetwork.load(write_network(tmp_path / "grey.onnx", [MEAN]))


@pytest.mark.parametrize("size", [(1, 1), (5, 40), (64, 80), (97, 33)])
def test_padding_leaves_every_pixel_in_its_place(grey, size):
    rgb = noise(*size)
    strength = grey.strength(rgb)
    assert strength.dtype == np.float32
    np.testing.assert_allclose(strength, rgb.mean(axis=2) / 255, atol=1e-6)


def test_scales_are_averaged_in_register(grey):
    rgb = np.repeat(np.linspace(0, 255, 120).astype(np.uint8)[None, :, None], 70, axis=0).repeat(3, axis=2)
    strength = grey.strength(rgb, multiscale=True)
    assert strength.shape == (70, 120)
    np.testing.assert_allclose(strength, rgb[..., 0] / 255, atol=0.01)


def test_threads_do_not_mix_their_images(grey):
    images = [noise(40 + k, 50, seed=k) for k in range(24)]
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(grey.strength, images))
    for rgb, strength in zip(images, results, strict=True):
        np.testing.assert_allclose(strength, rgb.mean(axis=2) / 255, atol=1e-6)


def test_a_file_is_read_once_until_it_changes(tmp_path):
    path = write_network(tmp_path / "one.onnx", [MEAN])
    first = EdgeNetwork.load(path)
    assert EdgeNetwork.load(str(path)) is first
    largest = node("ReduceMax", ["image"], "strength", axes=[1], keepdims=1)
    write_network(path, [largest, node("Abs", ["strength"], "same")], outputs={"same": 1})
    assert EdgeNetwork.load(path) is not first


FOREIGN: dict[str, Callable[[Path], object]] = {
    "empty": lambda path: path.write_bytes(b""),
    "half the size": lambda path: write_network(
        path, [MEAN, node("MaxPool", ["strength"], "small", kernel_shape=[2, 2], strides=[2, 2])], outputs={"small": 1}
    ),
}


@pytest.mark.parametrize("kind", FOREIGN)
def test_a_foreign_file_is_refused(tmp_path, kind):
    path = tmp_path / "foreign.onnx"
    FOREIGN[kind](path)
    with pytest.raises(FormatError, match=r"foreign\.onnx (is not an? .*edge network|cannot be read|is empty)"):
        EdgeNetwork.load(path)


@pytest.mark.parametrize("rgb", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3), np.float32), noise(0, 5)])
def test_what_is_no_rgb_image_is_refused(grey, rgb):
    with pytest.raises(InputError, match="8-bit RGB"):
        grey.strength(rgb)


@pytest.mark.parametrize("multiscale", [False, True])
def test_the_network_that_ships_finds_an_outline_and_nothing_else(multiscale):
    rgb = np.full((150, 210, 3), (200, 190, 180), np.uint8)
    cv2.circle(rgb, (100, 75), 45, (40, 60, 110), cv2.FILLED)
    rgb = np.clip(rgb + np.random.default_rng(0).normal(0, 3, rgb.shape), 0, 255).astype(np.uint8)
    strength, probability = EdgeNetwork.load(asset_path("models/edges.onnx")).contours(rgb, multiscale)
    assert strength.shape == probability.shape == (150, 210)
    y, x = np.mgrid[:150, :210]
    distance = np.abs(np.hypot(x - 100, y - 75) - 45)
    assert np.median(strength[distance < 0.7]) > 0.7
    assert np.median(probability[distance < 0.7]) > 0.5
    assert np.percentile(probability[distance > 8], 99) < 0.1
    assert np.median(strength[distance > 8]) < 0.1


def test_the_network_that_ships_finds_the_same_in_a_mirror():
    rgb = np.random.default_rng(3).integers(0, 255, (6, 8, 3), np.uint8).repeat(16, axis=0).repeat(20, axis=1)
    network = EdgeNetwork.load(asset_path("models/edges.onnx"))
    found, mirrored = (network.contours(image)[1] for image in (rgb, np.ascontiguousarray(rgb[:, ::-1])))
    np.testing.assert_allclose(mirrored[:, ::-1], found, atol=1e-5)
