"""Procedural surface colours: each takes object coordinates (N, 3) [m] and gives linear RGB (N, 3)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Texture = Callable[[np.ndarray], np.ndarray]


def linear(hex_colour: str) -> np.ndarray:
    """Linear RGB of an sRGB colour "#rrggbb"."""
    srgb = np.array([int(hex_colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def hashed(*integers: np.ndarray) -> np.ndarray:
    """Uniform number in [0, 1) that belongs to a lattice cell."""
    mixed = np.zeros(np.broadcast_shapes(*(i.shape for i in integers)), np.uint32)
    for i in integers:
        mixed = (mixed ^ i.astype(np.int64).astype(np.uint32)) * np.uint32(0x9E3779B1)
        mixed ^= mixed >> np.uint32(15)
        mixed *= np.uint32(0x85EBCA77)
        mixed ^= mixed >> np.uint32(13)
    return mixed / 2.0**32


def noise(points: np.ndarray, *, octaves: int = 3) -> np.ndarray:
    """Value noise in [0, 1], lattice of one unit, (N, 3) -> (N,)."""
    total, weight = np.zeros(len(points)), 0.0
    for octave in range(octaves):
        scaled = points * 2.0**octave + 17.3 * octave
        cell = np.floor(scaled).astype(np.int64)
        t = scaled - cell
        t = t * t * (3 - 2 * t)
        value = np.zeros(len(points))
        for corner in np.ndindex(2, 2, 2):
            share = np.prod(np.where(corner, t, 1 - t), axis=1)
            value += share * hashed(*(cell + corner).T)
        total += value * 0.5**octave
        weight += 0.5**octave
    return total / weight


def mixed(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    share = np.clip(share, 0, 1)[:, None]
    return first * (1 - share) + second * share


def smooth(low: float, high: float, x: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def plaster(colour: str) -> Texture:
    base = linear(colour)

    def paint(p: np.ndarray) -> np.ndarray:
        return base * (0.95 + 0.06 * noise(p * 4, octaves=4) + 0.04 * noise(p * 90, octaves=1))[:, None]

    return paint


def wood(dark: str, light: str, along: int = 0) -> Texture:
    low, high = linear(dark), linear(light)
    stretch = np.full(3, 22.0)
    stretch[along] = 1.6

    def paint(p: np.ndarray) -> np.ndarray:
        bend = noise(p * 2.5, octaves=2)
        rings = np.sin(40 * (noise(p * stretch * 0.18, octaves=2) + 0.15 * bend)) * 0.5 + 0.5
        fibre = noise(p * stretch * 7, octaves=2)
        return mixed(low, high, 0.45 * rings + 0.55 * fibre)

    return paint


def planks(p: np.ndarray) -> np.ndarray:
    """Oak boards that run along z, 14 cm wide, with dark joints."""
    width, length = 0.14, 1.45
    row = np.floor(p[:, 0] / width)
    z = p[:, 2] + length * hashed(row, row * 0 + 3)
    board = np.floor(z / length)
    tone = hashed(row, board)
    local = np.stack([p[:, 0], tone * 50, z + tone * 9], axis=1)
    colour = wood("#8a5f3c", "#c79c6c", along=2)(local)
    colour = colour * (0.78 + 0.40 * tone)[:, None]
    across = np.abs(p[:, 0] / width - row - 0.5) * width
    joint = np.maximum(smooth(width / 2 - 0.0028, width / 2 - 0.001, across), (z - board * length) < 0.003)
    return colour * (1 - 0.62 * joint)[:, None]


def fabric(colour: str, thread: float = 0.006, contrast: float = 0.3) -> Texture:
    base = linear(colour)

    def paint(p: np.ndarray) -> np.ndarray:
        q = p / thread
        weave = noise(q * (1, 0.5, 0.5), octaves=1) + noise(q * (0.5, 1, 1) + 40, octaves=1)
        cloud = noise(p * 6, octaves=3)
        return base * (1 + contrast * (weave - 1) + 0.35 * (cloud - 0.5))[:, None]

    return paint


def rug(half_x: float, half_z: float) -> Texture:
    """Woven rug: cream ground, a lattice of diamonds, striped border."""
    cream, terracotta, blue = linear("#dccfb6"), linear("#b5583a"), linear("#33495f")

    def paint(p: np.ndarray) -> np.ndarray:
        wobble = 0.004 * (noise(p * 30, octaves=2) - 0.5)
        x, z = p[:, 0] + wobble, p[:, 2] + wobble
        edge = np.minimum(half_x - np.abs(x), half_z - np.abs(z))
        u, v = np.abs((x / 0.30) % 1 - 0.5), np.abs((z / 0.30) % 1 - 0.5)
        diamond = np.abs(u + v - 0.5)
        field = np.where((diamond < 0.045)[:, None], blue, cream)
        field = np.where((u + v < 0.17)[:, None], terracotta, field)
        border = np.where((edge < 0.035)[:, None], blue, terracotta)
        border = np.where(((edge > 0.085) & (edge < 0.10))[:, None], cream, border)
        colour = np.where((edge < 0.12)[:, None], border, field)
        pile = noise(p * (260, 1, 90), octaves=1) * 0.35 + noise(p * 9, octaves=2) * 0.25
        return colour * (0.68 + pile)[:, None]

    return paint


def painting(half_width: float, half_height: float) -> Texture:
    """Hills at dusk under a low sun."""
    sky_low, sky_high = linear("#f3c995"), linear("#7fa3b5")
    hills = [linear(c) for c in ("#b98d88", "#8d6f7d", "#59657c", "#33485c", "#1f3038")]

    def paint(p: np.ndarray) -> np.ndarray:
        u, v = p[:, 0] / half_width, p[:, 1] / half_height
        colour = mixed(sky_low, sky_high, smooth(-0.3, 1.0, v + 0.1 * noise(p * 12, octaves=3)))
        sun = np.hypot(p[:, 0] - 0.38 * half_width, p[:, 1] - 0.34 * half_height)
        colour = mixed(colour, linear("#fbe6b0"), 1 - smooth(0.036, 0.042, sun))
        for i, hill in enumerate(hills):
            line = np.stack([u * (1.3 + 0.5 * i), u * 0 + 7.7 * i, u * 0], axis=1)
            top = 0.28 - 0.27 * i + 0.55 * (noise(line, octaves=4) - 0.5)
            shade = hill * (0.85 + 0.4 * noise(p * 60, octaves=2))[:, None]
            colour = np.where((v < top)[:, None], shade, colour)
        return colour

    return paint


def wicker(colour: str) -> Texture:
    base = linear(colour)

    def paint(p: np.ndarray) -> np.ndarray:
        turn, row = p[:, 0] * 36 / (2 * np.pi), p[:, 1] / 0.014
        over = np.sin(np.pi * turn + np.pi * np.floor(row)) * np.sin(np.pi * (row % 1))
        return base * (0.62 + 0.38 * over + 0.25 * noise(p * (20, 60, 1), octaves=2))[:, None]

    return paint


def leaf(p: np.ndarray) -> np.ndarray:
    """Green blade; object x runs across the leaf, -1 to 1, and z along it."""
    vein = np.exp(-((p[:, 0] / 0.09) ** 2)) + 0.3 * (np.sin(30 * (p[:, 2] - np.abs(p[:, 0]) * 0.35)) > 0.93)
    tone = noise(p * (2, 5, 4), octaves=2) * 0.7 + 0.3 * hashed(np.floor(p[:, 1]))
    return mixed(mixed(linear("#2c5a30"), linear("#6d9a45"), tone), linear("#a9c27a"), 0.6 * vein)


def banded(colour: str, band: str, low: float, high: float, axis: int = 1) -> Texture:
    base, stripe = linear(colour), linear(band)

    def paint(p: np.ndarray) -> np.ndarray:
        inside = (p[:, axis] > low) & (p[:, axis] < high)
        return np.where(inside[:, None], stripe, base) * (0.92 + 0.12 * noise(p * 40))[:, None]

    return paint
