"""The small frames of the sessions, as files."""

from pathlib import Path

import numpy as np

import ilf
from tests.ilf.small_sequences import CAMERA, write_sequence
from tests.ilf.tiny_onnx import node, write_network

from .. import frames


def room(folder: Path) -> Path:
    """The bundled sample, every fourth pixel: 120 x 160, with holes and ground truth."""
    frames.write_frame(folder / "room", frames.room())
    return folder / "room"


def true_depth(folder: Path) -> Path:
    """The ground truth of `room` as a file of its own."""
    ilf.write_depth(folder / "truth.png", _truth(), units=10_000)
    return folder / "truth.png"


def guide(folder: Path) -> Path:
    """A guide for `room`: the inverse of its ground truth."""
    np.save(folder / "guide.npy", 1 / _truth())
    return folder / "guide.npy"


def _truth() -> np.ndarray:
    truth = frames.room().ground_truth
    assert truth is not None
    return truth


def guide_network(folder: Path) -> Path:
    """A network that takes the mean of the colours for a guide."""
    mean = node("ReduceMean", ["image"], "strength", axes=[1], keepdims=1)
    return write_network(folder / "mean.onnx", [mean])


def walk(folder: Path) -> Path:
    """Four frames with poses and intrinsics: a camera that moves past a wall."""
    target = write_sequence(folder / "walk", count=4)
    numbers = [[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]]
    np.savetxt(target / "camera-intrinsics.txt", np.array(numbers))
    return target
