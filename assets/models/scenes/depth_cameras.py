"""Depth cameras: what each measures of a view, and where it measures nothing."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from . import gaps
from .view import View, jumps, ragged, smooth_noise

Cause = Callable[[View, np.random.Generator], np.ndarray]

Measured = tuple[np.ndarray, list[np.ndarray]]
"""Depth [m] everywhere, and the gaps by cause."""


def structured_light(view: View, rng: np.random.Generator) -> Measured:
    """Kinect v1, Xtion: steps that grow with the square of the depth, windows for outlines, shadows on one side."""
    steps = rng.uniform(180, 700)
    shared = smooth_noise(view.shape, rng.uniform(1.5, 5), rng)
    error = rng.uniform(0.1, 0.8) * (shared + 0.6 * smooth_noise(view.shape, 1, rng))
    seen, straddled = matched(torn(view.depth, rng), int(rng.choice([3, 5, 7], p=[0.4, 0.4, 0.2])), rng)
    depth = steps / np.maximum(np.round(steps / seen + error), 0.5)
    causes = [
        gaps.out_of_range(view, (0.3, 0.8), (3.5, 10), rng),
        gaps.shadow(view, rng),
        straddled,
        gaps.unanswered(view, rng),
        *often(0.5, gaps.parallax, view, rng),
        *often(0.25, gaps.seams, view, rng),
        *often(0.5, gaps.weak, view, rng),
        *often(0.4, gaps.steep, view, rng),
        *often(0.35, gaps.dropouts, view, rng),
        *often(0.8, gaps.border, view, rng),
    ]
    return depth, causes


def time_of_flight(view: View, rng: np.random.Generator) -> Measured:
    """Kinect v2, Azure: pixels that fly between surfaces, dark ones noisy, corners rounded, a shaped field of view."""
    seen = fattened(view.depth, rng) if rng.random() < 0.3 else view.depth
    if rng.random() < 0.5:
        seen = coarse(seen, rng)
    flying = jumps(seen, 0.03)
    between = cv2.blur(seen, (3, 3)) if rng.random() < 0.7 else cv2.GaussianBlur(seen, (0, 0), rng.uniform(1, 2))
    depth = np.where(flying, between, seen)
    bent = 1 - np.linalg.norm(cv2.blur(view.normals, (int(rng.integers(5, 25)),) * 2), axis=2)
    depth *= 1 + rng.uniform(0, 0.06) * bent
    spread = rng.uniform(0.0005, 0.004) * (1 + 0.3 * depth) / np.sqrt(view.shade + 0.03)
    depth += spread * smooth_noise(view.shape, rng.choice([1, 1.5, 2.5]), rng)
    removed = flying & (ragged(view.shape, rng.uniform(2, 10), rng) > rng.uniform(-2, 2))
    causes = [
        gaps.out_of_range(view, (0.2, 0.5), (3.5, 10), rng),
        removed,
        *often(0.35, gaps.outside_lens, view, rng),
        gaps.unanswered(view, rng),
        *often(0.5, gaps.parallax, view, rng),
        *often(0.5, gaps.weak, view, rng),
        *often(0.35, gaps.dropouts, view, rng),
        *often(0.25, gaps.seams, view, rng),
        *often(0.3, gaps.steep, view, rng),
        *often(0.3, gaps.border, view, rng),
    ]
    return depth, causes


def stereo(view: View, rng: np.random.Generator) -> Measured:
    """RealSense: blotches, smeared and displaced rims, a band and sides that the second camera does not see."""
    seen, straddled = matched(torn(view.depth, rng), int(rng.choice([3, 5, 7, 9, 11])), rng, prefer_near=0.12)
    inverse = cv2.GaussianBlur(1 / seen, (0, 0), rng.uniform(0.4, 1.6))
    blotches = ragged(view.shape, rng.uniform(5, 30), rng)
    plain = 1 - np.clip(np.abs(cv2.Laplacian(view.shade, cv2.CV_32F, ksize=3)) * 8, 0, 1)
    rough = rng.uniform(0.0005, 0.006) * (0.4 + cv2.blur(plain, (9, 9))) * blotches
    depth = 1 / np.maximum(inverse + rough + rng.uniform(0, 0.001) * smooth_noise(view.shape, 1.5, rng), 1 / 20)
    depth = with_speckles(depth, rng) if rng.random() < 0.4 else depth
    shift = rng.uniform(4, 25) * (1 if rng.random() < 0.8 else -1)
    causes = [
        gaps.out_of_range(view, (0.1, 0.4), (3, 12), rng),
        gaps.hidden_from_second(view, shift),
        *([straddled] if rng.random() < 0.5 else []),
        *often(0.5, gaps.unanswered, view, rng),
        *often(0.45, gaps.textureless, view, rng),
        *often(0.25, gaps.seams, view, rng),
        *often(0.3, gaps.weak, view, rng),
        *often(0.4, gaps.dropouts, view, rng),
        *often(0.2, gaps.border, view, rng),
    ]
    return depth, causes


def filled(view: View, rng: np.random.Generator) -> Measured:
    """Depth whose gaps somebody filled: nearly whole, smooth, in steps of centimetres."""
    seen = fattened(view.depth, rng) if rng.random() < 0.5 else view.depth
    if rng.random() < 0.4:
        seen = 1 / cv2.GaussianBlur(1 / seen, (0, 0), rng.uniform(0.5, 1.5))
    step = rng.choice([0.001, rng.uniform(0.01, 0.04)])
    noise = rng.uniform(0, 0.003) * view.depth * smooth_noise(view.shape, rng.uniform(1, 6), rng)
    depth = np.round((seen + noise) / step) * step
    causes = [gaps.out_of_range(view, (0.1, 0.3), (6, 12), rng), gaps.dropouts(view, rng)]
    return depth, causes + often(0.3, gaps.seams, view, rng) + often(0.2, gaps.border, view, rng)


def often(chance: float, cause: Cause, view: View, rng: np.random.Generator) -> list[np.ndarray]:
    """A cause of gaps, or none, by chance."""
    return [cause(view, rng)] if rng.random() < chance else []


def matched(
    depth: np.ndarray, side: int, rng: np.random.Generator, prefer_near: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Depth as matching windows of `side` pixels see it, and where they cannot decide.

    A window that straddles a jump takes the surface that fills more of it: outlines are rounded, bars thinner than
    half a window vanish, and small gaps close. `prefer_near` is taken off the share that what is near needs.
    """
    window = np.ones((side, side), np.uint8)
    inverse = 1 / depth
    near, far = cv2.dilate(inverse, window), cv2.erode(inverse, window)
    straddles = cv2.dilate(jumps(depth, 0.03).astype(np.uint8), window) > 0
    share = (cv2.blur(inverse, (side, side)) - far) / np.maximum(near - far, 1e-6)
    least = rng.uniform(0.38, 0.56) - prefer_near + rng.uniform(0.02, 0.14) * ragged(depth.shape, side, rng)
    is_near = inverse > (near + far) / 2
    taken = np.where(share > least, np.where(is_near, inverse, near), np.where(is_near, far, inverse))
    undecided = straddles & (np.abs(share - least) < rng.uniform(0, 0.1))
    return np.where(straddles, 1 / taken, depth), undecided


def fattened(depth: np.ndarray, rng: np.random.Generator, at_most: int = 4) -> np.ndarray:
    """What is near grown over what is far, or the other way round now and then, unevenly along the rim."""
    side = int(rng.integers(1, at_most + 2))
    square = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    grown = cv2.erode(depth, square) if rng.random() < 0.8 else cv2.dilate(depth, square)
    return np.where(ragged(depth.shape, rng.uniform(4, 30), rng) > rng.uniform(-2, 1), grown, depth)


def torn(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Depth taken from beside the pixel, by a smooth random way."""
    height, width = depth.shape
    grain, reach = rng.uniform(1.5, 5), rng.uniform(0.2, 1.3)
    columns = np.arange(width, dtype=np.float32) + reach * smooth_noise(depth.shape, grain, rng)
    rows = np.arange(height, dtype=np.float32)[:, None] + reach * smooth_noise(depth.shape, grain, rng)
    return cv2.remap(depth, columns, rows, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def coarse(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Depth of a lower resolution, brought to this one."""
    height, width = depth.shape
    times = rng.uniform(1.3, 4)
    small = cv2.resize(depth, (round(width / times), round(height / times)), interpolation=cv2.INTER_NEAREST)
    return cv2.resize(small, (width, height), interpolation=int(rng.choice([cv2.INTER_NEAREST, cv2.INTER_LINEAR])))


def with_speckles(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Some small clusters of wrong depth."""
    wrong = smooth_noise(depth.shape, rng.uniform(1.5, 4), rng) > rng.uniform(2.5, 3.5)
    return np.where(wrong, depth * np.exp(0.4 * smooth_noise(depth.shape, 6, rng)), depth)
