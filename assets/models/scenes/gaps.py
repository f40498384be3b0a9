"""Where depth cameras measure nothing, cause by cause: bool (H, W), set = missing."""

from __future__ import annotations

import cv2
import numpy as np

from .view import View, jumps, patches, ragged, smooth_noise

MOST = (0.08, 0.45)
"""Range of the largest share of a picture that its causes take together."""


def together(causes: list[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """Causes in random order, but for those that would leave less depth than this picture's share."""
    most = rng.uniform(*MOST)
    taken = np.zeros_like(causes[0])
    for k in rng.permutation(len(causes)):
        joined = taken | causes[k]
        if joined.mean() <= most:
            taken = joined
    return taken


def seams(view: View, rng: np.random.Generator) -> np.ndarray:
    """Ragged seams along jumps, where the matching window straddles two surfaces."""
    line = jumps(view.depth, rng.uniform(0.02, 0.06))
    side = int(rng.choice([3, 5, 7], p=[0.5, 0.35, 0.15]))
    wide = cv2.dilate(line.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)))
    field = ragged(view.shape, rng.uniform(2, 6), rng) + 0.7 * smooth_noise(view.shape, rng.uniform(15, 60), rng)
    least = rng.uniform(-1.5, 1.5)
    return (line & (field > least - 0.8)) | ((wide > 0) & (field > least))


def shadow(view: View, rng: np.random.Generator) -> np.ndarray:
    """What the projector does not reach, its outline that of the matching window."""
    side = int(rng.choice([3, 5, 7]))
    closed = cv2.morphologyEx(view.unlit.astype(np.float32), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    least = rng.uniform(0.15, 0.6) + 0.1 * ragged(view.shape, rng.uniform(3, 8), rng)
    return cv2.blur(closed, (side, side)) > np.maximum(least, 0.02)


def parallax(view: View, rng: np.random.Generator) -> np.ndarray:
    """What the colour camera sees and the depth camera, which stands beside it, does not."""
    return hidden_from_second(view, -rng.uniform(3, 12))


def hidden_from_second(view: View, shift: float) -> np.ndarray:
    """What a second camera cannot see: pixels that move by `shift` / depth [px] behind those that move more.

    A positive shift puts that camera to the right, and the gaps to the left of what is near; the strip at that border
    which it does not see either is among them.
    """
    depth = view.depth if shift > 0 else view.depth[:, ::-1]
    columns = np.arange(depth.shape[1], dtype=np.float32)
    seen_at = columns - abs(shift) / depth
    nearest = np.minimum.accumulate(seen_at[:, ::-1], axis=1)[:, ::-1]
    hidden = (seen_at > nearest + 0.75) | (seen_at < 0)
    hidden = hidden if shift > 0 else hidden[:, ::-1]
    return cv2.morphologyEx(hidden.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0


def weak(view: View, rng: np.random.Generator) -> np.ndarray:
    """Where too little light comes back: dark, far and steep surfaces, in ragged patches."""
    dark, steep, far = rng.uniform(0, (1.2, 1.2, 1.6))
    returned = dark * np.log(view.shade + 0.04) + steep * np.log(view.facing + 0.04) - far * np.log(view.depth)
    returned = cv2.blur(returned, (3, 3)) + rng.uniform(0.05, 0.5) * ragged(view.shape, rng.uniform(4, 30), rng)
    return returned < np.quantile(returned, 0.3 * rng.random() ** 2)


def unanswered(view: View, rng: np.random.Generator) -> np.ndarray:
    """Black, glossy and light-emitting things, each wholly, in part or not at all, and some of what is around."""
    gone = np.zeros(view.shape, bool)
    field = ragged(view.shape, rng.uniform(4, 40), rng)
    for name, usual in (("black", 0.4), ("glossy", -0.4), ("emitting", 0.6)):
        mask = view.flags[name]
        if mask.any():
            level = patches(mask, rng) + usual + rng.uniform(-0.8, 0.8)
            gone |= mask & (level + rng.uniform(0.2, 0.9) * field > 0)
    side = int(rng.choice([1, 1, 3, 5]))
    grown = cv2.dilate(gone.astype(np.uint8), np.ones((side, side), np.uint8)) > 0
    return gone | (grown & (field > -0.5))


def steep(view: View, rng: np.random.Generator) -> np.ndarray:
    """Surfaces seen at a grazing angle."""
    return view.facing < rng.uniform(0.02, 0.2) * (1 + 0.7 * ragged(view.shape, rng.uniform(3, 10), rng))


def dropouts(view: View, rng: np.random.Generator) -> np.ndarray:
    """Small clusters that found no match, more of them far away."""
    field = smooth_noise(view.shape, rng.uniform(1.5, 7), rng) + rng.uniform(0, 0.8) * smooth_noise(view.shape, 50, rng)
    return field > rng.uniform(2.9, 4.5) - rng.uniform(0, 0.15) * np.minimum(view.depth, 8)


def textureless(view: View, rng: np.random.Generator) -> np.ndarray:
    """Where a pair of cameras finds nothing to match, in blotches."""
    window = (9, 9)
    mean, square = cv2.blur(view.shade, window), cv2.blur(view.shade**2, window)
    contrast = np.log(np.sqrt(np.maximum(square - mean**2, 0)) + 0.004)
    contrast += rng.uniform(0.4, 1.2) * ragged(view.shape, rng.uniform(8, 40), rng)
    return contrast < np.quantile(contrast, 0.25 * rng.random() ** 2)


def out_of_range(
    view: View, nearest: tuple[float, float], farthest: tuple[float, float], rng: np.random.Generator
) -> np.ndarray:
    """Nearer or farther than a camera measures, with limits drawn from two ranges [m]; ragged where it fades."""
    near, far = rng.uniform(*nearest), rng.uniform(*farthest)
    far = max(far, float(np.quantile(view.depth, rng.uniform(0.65, 1))))
    fading = 1 + rng.choice([0.0, 0.02, 0.06]) * ragged(view.shape, rng.uniform(3, 15), rng)
    return (view.depth < min(near, float(np.quantile(view.depth, 0.12)))) | (view.depth * fading > far)


def border(view: View, rng: np.random.Generator) -> np.ndarray:
    """Strips along the sides that a camera of another field of view does not cover, slightly askew."""
    height, width = view.shape
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    x, y = columns / width, rows / height
    slant = rng.uniform(-0.02, 0.02, 4)
    strip = rng.uniform(-0.03, 0.1, 4)
    return (
        (x + slant[0] * y < strip[0])
        | (1 - x + slant[1] * y < strip[1])
        | (y + slant[2] * x < strip[2])
        | (1 - y + slant[3] * x < strip[3])
    )


def outside_lens(view: View, rng: np.random.Generator) -> np.ndarray:
    """Outside of a round or six-sided field of view."""
    height, width = view.shape
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    x = (columns - width * rng.uniform(0.45, 0.55)) / width
    y = (rows - height * rng.uniform(0.45, 0.55)) / width
    radius = rng.uniform(0.46, 0.62)
    if rng.random() < 0.5:
        return np.hypot(x, y) > radius
    turns = np.deg2rad([0, 60, 120] if rng.random() < 0.5 else [30, 90, 150])
    return np.max([np.abs(x * np.cos(turn) + y * np.sin(turn)) for turn in turns], axis=0) > 0.9 * radius
