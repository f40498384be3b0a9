"""The small frames of the sessions, as files."""

import json
from pathlib import Path

import cv2
import numpy as np

import ilf
from tests.ilf.small_sequences import CAMERA, write_sequence
from tests.ilf.tiny_onnx import node, write_network

_SAMPLE = Path(__file__).parents[3] / "assets" / "samples" / "room"
_STEP = 4


def room(folder: Path, name: str = "room", ground_truth: bool = True) -> Path:
    """The bundled sample, every fourth pixel: 120 x 160, with holes and ground truth."""
    sample = ilf.load_frame(_SAMPLE)
    camera, target = sample.intrinsics, folder / name
    assert camera is not None
    target.mkdir(parents=True)
    cv2.imwrite(str(target / "rgb.png"), sample.rgb[::_STEP, ::_STEP, ::-1])
    _write_depth(target / "depth.png", sample.depth)
    if ground_truth:
        _write_depth(target / "gt.png", sample.ground_truth)
    numbers = [value / _STEP for value in (camera.fx, camera.fy, camera.cx, camera.cy)]
    meta = {"name": name, "depth_units_per_m": 1000, "gt_units_per_m": 1000, "K": numbers}
    (target / "meta.json").write_text(json.dumps(meta))
    return target


def true_depth(folder: Path) -> Path:
    """The ground truth of `room` as a file of its own."""
    return _write_depth(folder / "truth.png", ilf.load_frame(_SAMPLE).ground_truth)


def guide(folder: Path) -> Path:
    """A guide for `room`: the inverse of its ground truth."""
    truth = ilf.load_frame(_SAMPLE).ground_truth
    assert truth is not None
    np.save(folder / "guide.npy", 1 / truth[::_STEP, ::_STEP])
    return folder / "guide.npy"


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


def _write_depth(path: Path, depth: np.ndarray | None) -> Path:
    assert depth is not None
    millimetres = np.nan_to_num(depth[::_STEP, ::_STEP] * 1000).round().astype(np.uint16)
    cv2.imwrite(str(path), millimetres)
    return path
