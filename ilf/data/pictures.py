"""Display of frames and completions in notebooks and scripts: thumbnails as HTML, plots by matplotlib."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import optional

_WIDTH = 240
"""Maximum width of a thumbnail [px]."""

_MISSING = (178, 182, 189)
"""Colour of missing depth."""


def html_row(caption: str, rgb: NDArray[np.uint8], depths: Mapping[str, NDArray[np.float32]]) -> str:
    """Make a line of text and, side by side, thumbnails of colour and depth, all depth with one colour range.

    Parameters
    ----------
    caption : str
    rgb : ndarray of uint8, shape (H, W, 3)
    depths : mapping
        Title -> depth [m], shape (H, W), NaN = missing.

    Returns
    -------
    str
        HTML with the images as PNG data URIs.
    """
    limits = _limits(depths.values())
    pictures = {"Colour": _small(rgb)} | {title: _coloured(_small(depth), *limits) for title, depth in depths.items()}
    figures = "".join(
        f'<figure style="display:inline-block;margin:4px"><img src="{_data_uri(picture)}" alt="{title}">'
        f"<figcaption>{title}</figcaption></figure>"
        for title, picture in pictures.items()
    )
    return f"<div>{html.escape(caption)}</div><div>{figures}</div>"


def plot_row(rgb: NDArray[np.uint8], depths: Mapping[str, NDArray[np.float32]]) -> NDArray[Any]:
    """Plot colour and depth side by side by matplotlib, all depth with one colour range and a colour bar in metres.

    Parameters
    ----------
    rgb, depths
        As for `html_row`.

    Returns
    -------
    ndarray of matplotlib.axes.Axes, shape (1 + number of depths,)

    Raises
    ------
    InputError
        If matplotlib is not installed (extra `plot`).
    """
    pyplot = optional("matplotlib.pyplot", "plot", "A plot")
    low, high = _limits(depths.values())
    height, width = rgb.shape[:2]
    size = (4.0 * (1 + len(depths)), 4.0 * height / width + 0.5)
    figure, axes = pyplot.subplots(1, 1 + len(depths), figsize=size, sharex=True, sharey=True, layout="constrained")
    axes[0].imshow(rgb)
    axes[0].set_title("Colour")
    for axis, (title, depth) in zip(axes[1:], depths.items(), strict=True):
        image = axis.imshow(depth, cmap="turbo", vmin=low, vmax=high)
        axis.set_title(title)
        axis.set_facecolor(np.array(_MISSING) / 255)
    for axis in axes:
        axis.set(xticks=[], yticks=[])
    figure.colorbar(image, ax=axes[1:], label="Depth [m]")
    return np.asarray(axes)


def _limits(depths: Iterable[NDArray[np.float32]]) -> tuple[float, float]:
    """Return the 1st and 99th percentile of all known depth [m], at least 1 mm apart; (0, 1) if none is known."""
    known = np.concatenate([depth[np.isfinite(depth)] for depth in depths])
    low, high = np.percentile(known, (1, 99)).tolist() if known.size else (0.0, 1.0)
    return low, max(high, low + 1e-3)


def _small(picture: NDArray[Any]) -> NDArray[Any]:
    step = -(-picture.shape[1] // _WIDTH)
    return picture[::step, ::step]


def _coloured(depth: NDArray[np.float32], low: float, high: float) -> NDArray[np.uint8]:
    """Render depth as a colour image, uint8 (H, W, 3), RGB."""
    known = np.isfinite(depth)
    shares = np.clip((np.where(known, depth, low) - low) / (high - low), 0, 1)
    picture = cv2.applyColorMap(np.round(255 * shares).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1]
    return np.where(known[..., None], picture, np.array(_MISSING, np.uint8))


def _data_uri(picture: NDArray[np.uint8]) -> str:
    # the encoder expects BGR
    png = cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))[1]
    return f"data:image/png;base64,{base64.b64encode(png.tobytes()).decode('ascii')}"
