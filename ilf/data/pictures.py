"""Colour maps, and the display of frames, runs and completions in notebooks and scripts."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import optional

# Colour maps: lookup tables from 8-bit indices to colours. Index 0, missing, is grey in all of them.

Colour = tuple[int, int, int]
"""Red, green, blue, 0-255."""

MISSING: Colour = (178, 182, 189)

DEPTH_MAP = "viridis"
"""Colour map of depth, as in the window: its steps look equal, and colour-blind people can read it."""

_BELOW, _ZERO, _ABOVE = (33, 84, 176), (246, 246, 244), (186, 32, 42)


def depth_colours() -> NDArray[np.uint8]:
    """Colour map of depth, uint8 (256, 3): near is dark."""
    return _of_map(cv2.COLORMAP_VIRIDIS)


def error_colours() -> NDArray[np.uint8]:
    """Colour map of absolute errors, uint8 (256, 3): inferno, small is dark."""
    return _of_map(cv2.COLORMAP_INFERNO)


def difference_colours() -> NDArray[np.uint8]:
    """Colour map of signed differences, uint8 (256, 3): blue below zero, nearly white at zero, red above."""
    below, zero, above = (np.array(colour, np.float64) for colour in (_BELOW, _ZERO, _ABOVE))
    t = np.linspace(-1, 1, 255)[:, None]
    return _with_missing(np.round(zero + np.abs(t) ** 0.8 * (np.where(t < 0, below, above) - zero)))


def _of_map(number: int) -> NDArray[np.uint8]:
    column = np.round(np.linspace(0, 255, 255)).astype(np.uint8)[:, None]
    return _with_missing(cv2.applyColorMap(column, number)[:, 0, ::-1])


def _with_missing(colours: NDArray[np.number]) -> NDArray[np.uint8]:
    return np.vstack([MISSING, colours]).astype(np.uint8)


# Thumbnails as HTML, and plots by matplotlib.

_WIDTH = 240
"""Maximum width of a thumbnail [px]."""

_MOST_NAMED = 12
"""Largest number of blocks of which a plot has a legend."""


def html_row(caption: str, images: Mapping[str, NDArray[Any]]) -> str:
    """Make a line of text and, side by side, thumbnails of images, all depth with one colour range.

    Parameters
    ----------
    caption : str
    images : mapping
        Title -> image: uint8 (H, W, 3) is colour, float32 (H, W) depth [m], NaN = missing.

    Returns
    -------
    str
        HTML with the images as PNG data URIs.
    """
    limits = _limits(image for image in images.values() if _is_depth(image))
    figures = ""
    for title, image in images.items():
        small = _small(image)
        picture = _coloured(small, *limits) if _is_depth(image) else small
        figures += (
            f'<figure style="display:inline-block;margin:4px"><img src="{_data_uri(picture)}" alt="{title}">'
            f"<figcaption>{title}</figcaption></figure>"
        )
    return f"<div>{html.escape(caption)}</div><div>{figures}</div>"


def plot_row(images: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
    """Plot images side by side by matplotlib, all depth with one colour range and a colour bar in metres.

    Parameters
    ----------
    images : mapping
        As for `html_row`, with at least one depth.

    Returns
    -------
    ndarray of matplotlib.axes.Axes, shape (number of images,)

    Raises
    ------
    InputError
        If matplotlib is not installed (extra `plot`).
    """
    low, high = _limits(image for image in images.values() if _is_depth(image))
    axes = _axes([*images], next(iter(images.values())).shape)
    for axis, image in zip(axes, images.values(), strict=True):
        shown = axis.imshow(image, cmap=DEPTH_MAP, vmin=low, vmax=high) if _is_depth(image) else axis.imshow(image)
    axes[0].figure.colorbar(shown, ax=axes, label="Depth [m]")
    return axes


def plot_error(rgb: NDArray[np.uint8], error: NDArray[np.float32]) -> NDArray[Any]:
    """Plot colour, and the expected error [m], shape (H, W), on a logarithmic colour range in millimetres.

    Returns and raises as `plot_row` does.
    """
    axes = _axes(["Colour", "Expected error"], error.shape)
    axes[0].imshow(rgb)
    low, high = _limits([1000 * error])
    norm = optional("matplotlib.colors", "ilf-studio[plot]", "A plot").LogNorm(max(low, 1e-3), max(high, 1e-2))
    shown = axes[1].imshow(1000 * error, cmap="inferno", norm=norm)
    axes[0].figure.colorbar(shown, ax=axes, label="Expected error [mm]")
    return axes


def _axes(titles: Sequence[str], shape: tuple[int, ...]) -> NDArray[Any]:
    """Axes side by side for images of this height and width."""
    pyplot = optional("matplotlib.pyplot", "ilf-studio[plot]", "A plot")
    size = (4.0 * len(titles), 4.0 * shape[0] / shape[1] + 0.5)
    _, axes = pyplot.subplots(1, len(titles), figsize=size, sharex=True, sharey=True, layout="compressed")
    for axis, title in zip(axes, titles, strict=True):
        axis.set(title=title, xticks=[], yticks=[], facecolor=np.array(MISSING) / 255)
    return np.asarray(axes)


def plot_curves(histories: Mapping[int, Sequence[Any]]) -> NDArray[Any]:
    """Plot sigma_i [mm] and the change of the L1 norm [%] against the iteration, a line for each block.

    Parameters
    ----------
    histories : mapping
        Block label -> each `IterationRecord` of the block; blocks without any are left out.

    Returns
    -------
    ndarray of matplotlib.axes.Axes, shape (2,)

    Raises
    ------
    InputError
        If matplotlib is not installed (extra `plot`).
    """
    pyplot = optional("matplotlib.pyplot", "ilf-studio[plot]", "A plot")
    _, axes = pyplot.subplots(1, 2, figsize=(10.0, 3.6), layout="constrained")
    for label, records in histories.items():
        if records:
            iterations = [record.i for record in records]
            axes[0].plot(iterations, [1000 * record.sigma_i for record in records], label=f"Block {label}")
            axes[1].plot(iterations, [100 * (record.l1 / records[-1].l1 - 1) for record in records])
    axes[0].set(title="Deviation of an iteration", xlabel="Iteration", ylabel="sigma_i [mm]", yscale="log")
    axes[1].set(title="L1 norm", xlabel="Iteration", ylabel="Difference from the last [%]")
    if 0 < len(axes[0].lines) <= _MOST_NAMED:
        axes[0].legend()
    return np.asarray(axes)


def _is_depth(image: NDArray[Any]) -> bool:
    return image.ndim == 2


def _limits(depths: Iterable[NDArray[np.float32]]) -> tuple[float, float]:
    """Return the 1st and 99th percentile of all known values, at least 0.001 apart; (0, 1) if none is known."""
    known = np.concatenate([depth[np.isfinite(depth)] for depth in depths])
    low, high = np.percentile(known, (1, 99)).tolist() if known.size else (0.0, 1.0)
    return low, max(high, low + 1e-3)


def _small(picture: NDArray[Any]) -> NDArray[Any]:
    """Return a picture of at most `_WIDTH`: colour is averaged, so that thin lines stay, and depth is sampled."""
    step = -(-picture.shape[1] // _WIDTH)
    if step == 1 or _is_depth(picture):
        return picture[::step, ::step]
    size = -(-picture.shape[1] // step), -(-picture.shape[0] // step)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))


def _coloured(depth: NDArray[np.float32], low: float, high: float) -> NDArray[np.uint8]:
    """Render depth as a colour image, uint8 (H, W, 3), RGB."""
    known = np.isfinite(depth)
    shares = np.clip((np.where(known, depth, low) - low) / (high - low), 0, 1)
    return depth_colours()[np.where(known, np.round(254 * shares) + 1, 0).astype(np.uint8)]


def _data_uri(picture: NDArray[np.uint8]) -> str:
    # the encoder expects BGR
    png = cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))[1]
    return f"data:image/png;base64,{base64.b64encode(png.tobytes()).decode('ascii')}"
