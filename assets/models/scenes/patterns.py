"""Drawn surfaces: each pattern takes points (N,) in periods and a random number per material, and gives how much of a
material's second and third colour there is, and how bright it is there, (N,) each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .fields import hashed, noise

Shares = tuple[np.ndarray, np.ndarray, np.ndarray]


def _soft(low: float, high: float, x: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def _none(u: np.ndarray) -> np.ndarray:
    return np.zeros_like(u)


def _one(u: np.ndarray) -> np.ndarray:
    return np.ones_like(u)


def _cells(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    i, j = np.floor(u), np.floor(v)
    return i, j, u - i, v - j


def _rim(x: np.ndarray, width: float) -> np.ndarray:
    """1 near the edges of a cell, for the cell's own coordinate in [0, 1)."""
    return 1 - _soft(width * 0.6, width, np.minimum(x, 1 - x))


def plain(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    return _none(u), _none(u), _one(u)


def stripes(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    x = u % 1
    return (x < 0.2 + 0.6 * w) * 1.0, (np.abs(x - 0.1 - 0.3 * w) < 0.04) * 1.0, _one(u)


def pinstripes(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    return (np.abs(u % 1 - 0.5) < 0.03 + 0.1 * w) * 1.0, _none(u), _one(u)


def waves(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    x = (u + 0.35 * np.sin(2 * np.pi * v * (0.4 + w))) % 1
    return (x < 0.45) * 1.0, ((x > 0.7) & (x < 0.75)) * 1.0, _one(u)


def zigzag(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    x = (u + (0.3 + w) * np.abs(v % 1 - 0.5)) % 1
    return (x < 0.5) * 1.0, ((x > 0.6) & (x < 0.7)) * (w > 0.5), _one(u)


def checker(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    i, j, _, _ = _cells(u, v)
    return (i + j) % 2, _none(u), 0.94 + 0.12 * hashed(i, j)


def plaid(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    a, b = (u % 1 < 0.25 + 0.4 * w) * 0.5, (v % 1 < 0.25 + 0.4 * w) * 0.5
    thin = ((u % 1 > 0.85) & (u % 1 < 0.9)) | ((v % 1 > 0.85) & (v % 1 < 0.9))
    return a + b, thin * 0.7, _one(u)


def tiles(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    i, j, x, y = _cells(u, v)
    joint = np.maximum(_rim(x, 0.035), _rim(y, 0.035))
    return joint, (hashed(i, j) < 0.25 * w) * (1 - joint), 0.88 + 0.2 * hashed(j, i)


def bricks(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    v = v * 2.2
    u = u + 0.5 * (np.floor(v) % 2)
    i, j, x, y = _cells(u, v)
    joint = np.maximum(_rim(x, 0.05), _rim(y, 0.11))
    return joint, hashed(i, j) * 0.6 * (1 - joint), 0.75 + 0.4 * hashed(j, i) + 0.06 * noise("grain", u, v)


def cobbles(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    nearest, second, tone = np.full_like(u, 9.0), np.full_like(u, 9.0), _none(u)
    i, j, _, _ = _cells(u, v)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            away = np.hypot(i + a + hashed(i + a, j + b) - u, j + b + hashed(j + b, i + a, i) - v)
            closer = away < nearest
            second = np.where(closer, nearest, np.minimum(second, away))
            tone = np.where(closer, hashed(i + a, j + b, j), tone)
            nearest = np.minimum(nearest, away)
    return 1 - _soft(0.04, 0.12, second - nearest), tone * w, 0.7 + 0.5 * tone


def planks(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    row = np.floor(v)
    along = u * (0.06 + 0.1 * w) + hashed(row, row)
    board = np.floor(along)
    tone = hashed(row, board)
    joint = np.maximum(_rim(v - row, 0.03), _rim(along - board, 0.004))
    fibre = 0.5 + 0.22 * noise("fibre", u * 0.2 + 40 * tone, v * 0.5 + 9 * tone)
    return np.clip(fibre, 0, 1), _none(u), (0.75 + 0.4 * tone) * (1 - 0.6 * joint)


def parquet(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    i, j, x, y = _cells(u, v)
    strip = np.where((i + j) % 2 == 0, x, y) * 4
    tone = hashed(i, j, np.floor(strip))
    joint = np.maximum(_rim(strip % 1, 0.08), np.maximum(_rim(x, 0.02), _rim(y, 0.02)))
    return tone * w, joint * (w > 0.4), 0.75 + 0.35 * hashed(j, i, np.floor(strip))


def panels(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    """Fronts side by side with dark gaps, at times with a field in each."""
    i, j, x, y = _cells(u, v * (0.35 + 0.6 * w))
    gap = np.maximum(_rim(x, 0.025), _rim(y, 0.025 * (0.35 + 0.6 * w)))
    field = (np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y)) > 0.13) * ((7 * w) % 1 < 0.5)
    return gap, field * (1 - gap), 0.93 + 0.1 * hashed(i, j)


def wood(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    bend = noise("cloud", u * 0.06 + 7 * w, v * 0.1)
    rings = 0.5 + 0.5 * np.sin(5 * v + 3.5 * bend)
    return np.clip(0.5 * rings + 0.25 + 0.16 * noise("fibre", u * 0.3, v * 0.7), 0, 1), _none(u), _one(u)


def marble(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    warp = noise("cloud", u * 0.3, v * 0.3 + 5 * w)
    vein = 1 - np.abs(np.sin(2.2 * (u + 0.6 * v) + 2.4 * warp))
    return vein**4, np.clip(0.25 * warp, 0, 0.6), _one(u)


def granite(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    grain = noise("grain", u * 0.7, v * 0.7)
    return _soft(0.3, 1.0, grain), _soft(0.6, 1.2, -grain), _one(u)


def blotches(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    cloud = noise("cloud", u * 0.25 + 3 * w, v * 0.25)
    return _soft(-0.2, 0.4, cloud), _soft(0.7, 0.9, noise("cloud", v * 0.3, u * 0.3 + w)), _one(u)


def camouflage(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    first, second = noise("cloud", u * 0.3, v * 0.3 + w * 9), noise("cloud", u * 0.35 + 4, v * 0.35)
    return (first > 0.1) * 1.0, (second > 0.5) * 1.0, _one(u)


def dots(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    u = u + 0.5 * (np.floor(v) % 2)
    _, _, x, y = _cells(u, v)
    away = np.hypot(x - 0.5, y - 0.5)
    return 1 - _soft(0.12 + 0.25 * 0.5, 0.16 + 0.25 * 0.5, away), (away < 0.08) * (w > 0.6), _one(u)


def confetti(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    i, j, x, y = _cells(u, v)
    turn, size = 6.3 * hashed(i, j), 0.1 + 0.3 * hashed(j, i)
    a, b = x - 0.5, y - 0.5
    inside = (np.abs(a * np.cos(turn) + b * np.sin(turn)) < size) & (
        np.abs(b * np.cos(turn) - a * np.sin(turn)) < size * (0.2 + w)
    )
    kind = hashed(i, j, i)
    return inside * (kind < 0.5), inside * (kind > 0.7), _one(u)


def diamonds(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    x, y = np.abs(u % 1 - 0.5), np.abs(v % 1 - 0.5)
    return (np.abs(x + y - 0.5) < 0.06) * 1.0, (x + y < 0.1 + 0.25 * w) * 1.0, _one(u)


def rings(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    i, j, x, y = _cells(u * 0.5, v * 0.5)
    away = np.hypot(x - 0.5, y - 0.5) * (4 + 8 * w)
    return (away % 1 < 0.5) * 1.0, (hashed(i, j) < 0.3) * (away % 1 > 0.8), _one(u)


def text(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    """Rows of small marks in words, some lines missing, like print."""
    line = np.floor(v)
    word = np.floor(u * 0.35 + hashed(line, line) * 3)
    i, _, x, y = _cells(u * 2.2, v)
    present = (hashed(word, line) > 0.18) & (hashed(line, line * 3) > 0.2)
    strokes = hashed(np.floor(u * 6.6), np.floor(v * 4), i) > 0.42
    return present * strokes * ((y > 0.2) & (y < 0.75) & (x < 0.85)), _none(u), _one(u)


def poster(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    """Large shapes one over another, with a block of print."""
    second, third = _none(u), _none(u)
    i, j, x, y = _cells(u, v)
    for n in range(5):
        a, b, c, d = (hashed(i + 31 * n, j, np.floor(w * 999) + k) for k in range(4))
        box = (np.abs(x - a) < 0.05 + 0.3 * c) & (np.abs(y - b) < 0.05 + 0.3 * d)
        disc = np.hypot(x - a, y - b) < 0.05 + 0.25 * c
        inside = np.where(d > 0.5, box, disc)
        second = np.where(inside, n % 2, second)
        third = np.where(inside, ((n + 1) % 3 == 0) * 0.9, third)
    print_here = (y > 0.1 + 0.5 * w) & (y < 0.25 + 0.5 * w) & (x > 0.1) & (x < 0.9)
    marks, _, _ = text(u * 24, v * 24, w)
    return np.where(print_here, marks, second), np.where(print_here, 0, third), _one(u)


def picture(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    """Something like a photograph: hills of noise at all scales under a bright part."""
    high, low = noise("cloud", u * 0.9 + 11 * w, v * 0.9), noise("cloud", u * 0.4 + 3, v * 0.4 + 8 * w)
    return _soft(-1, 1, low + 1.2 * np.sin(2.5 * v + 6 * w)), _soft(0.2, 0.5, high - v % 1 + 0.5), 0.8 + 0.25 * high


def weave(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    thread = np.sin(2 * np.pi * u) * np.sin(2 * np.pi * v)
    return 0.5 + 0.5 * thread, _none(u), 0.95 + 0.07 * noise("grain", u, v)


def ribs(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    return _none(u), _none(u), 0.75 + 0.35 * np.abs(np.sin(np.pi * u)) ** (0.3 + w)


def wicker(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    over = np.sin(np.pi * u + np.pi * np.floor(v)) * np.sin(np.pi * (v % 1))
    return np.clip(0.5 - 0.5 * over, 0, 1), _none(u), 0.8 + 0.3 * over


def gradient(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    return np.abs((v + w) % 2 - 1), _none(u), _one(u)


def label(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    """Packaging: a field of another colour with a sign and print on it."""
    _, _, x, y = _cells(u, v)
    field = (y > 0.2 + 0.3 * w) & (y < 0.7 + 0.2 * w)
    sign = (np.hypot(x - 0.3 - 0.4 * w, (y - 0.55) * 1.3) < 0.14 + 0.1 * w) | ((y > 0.05) & (y < 0.09))
    marks, _, _ = text(u * 14, v * 14, w)
    return field * 1.0, np.where(sign, 1.0, marks * field * (x > 0.55) * 0.8), _one(u)


def page(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    """Window of a program: bars, a column, lines of print, a picture."""
    _, _, x, y = _cells(u, v)
    marks, _, _ = text(u * 30, v * 30, w)
    column = x < 0.1 + 0.2 * w
    image = (x > 0.6) & (x < 0.9) & (y > 0.15) & (y < 0.5)
    shown, other, tone = picture(u * 3, v * 3, w)
    return np.where(image, shown, marks * (y < 0.85) * (x < 0.58)), np.where(image, other, column | (y > 0.93)), tone


def leaf(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Shares:
    vein = np.abs((v * 3 + np.abs(u % 1 - 0.5) * 2) % 1 - 0.5) < 0.06
    return vein * 0.5, _none(u), 0.85 + 0.15 * noise("cloud", u, v)


PATTERNS: tuple[Callable[[np.ndarray, np.ndarray, np.ndarray], Shares], ...] = (
    plain, stripes, pinstripes, waves, zigzag, checker, plaid, tiles, bricks, cobbles, planks, wood, marble, granite,
    blotches, camouflage, dots, confetti, diamonds, rings, text, poster, picture, weave, ribs, wicker, gradient, label,
    page, leaf, parquet, panels,
)  # fmt: skip
NUMBER = {pattern.__name__: number for number, pattern in enumerate(PATTERNS)}
