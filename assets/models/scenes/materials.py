"""The materials of one scene, drawn at random as rows of a table, and their colour at points."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass, field

import numpy as np

from .fields import noise
from .patterns import NUMBER, PATTERNS

CLOTHS = ("plain", "plain", "stripes", "plaid", "dots", "zigzag", "waves", "diamonds", "weave", "ribs", "blotches")
RUGS = ("diamonds", "plaid", "zigzag", "rings", "stripes", "waves", "checker", "picture", "camouflage", "confetti")
WALLS = (
    "plain",
    "plain",
    "plain",
    "plain",
    "plain",
    "plain",
    "plain",
    "stripes",
    "pinstripes",
    "diamonds",
    "dots",
    "blotches",
    "gradient",
    "tiles",
)
FLOORS = (
    "planks",
    "planks",
    "tiles",
    "checker",
    "granite",
    "marble",
    "plain",
    "plain",
    "diamonds",
    "blotches",
    "weave",
)
STREETS = ("cobbles", "tiles", "bricks", "granite", "plain", "blotches", "planks")
PACKS = ("label", "label", "poster", "text", "stripes", "picture", "plain", "plain", "confetti", "dots", "gradient")
SEAMS = ("panels", "panels", "tiles", "tiles", "stripes", "pinstripes", "checker", "bricks", "planks", "parquet")
ANYTHING = tuple(name for name in NUMBER if name not in ("parquet", "panels"))
HUES = ((0.04, 0.13), (0.0, 0.04), (0.54, 0.66), (0.2, 0.45), (0.0, 1.0))
HUE_SHARES = (0.42, 0.13, 0.2, 0.1, 0.15)
"""Browns and yellows, reds, blues, greens, and all."""


@dataclass
class Material:
    """One row: three colours (linear RGB), how they are drawn, how light fares on them.

    Parameters
    ----------
    a, b, c : ndarray (3,)
        Colours that the pattern mixes.
    pattern : str
        Name in `patterns`.
    period, turn, number, shift : float
        Of the pattern: period [m], angle [rad], its own random number, and where it starts.
    grain, grain_period : float
        Strength and size [m] of noise on the colour.
    gloss, shine : float
        Mirror reflection at normal incidence, and exponent of the highlight.
    black, glossy, transparent, emitting : bool
        What a depth sensor has trouble with.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    pattern: str = "plain"
    period: float = 0.1
    turn: float = 0.0
    number: float = 0.5
    shift: float = 0.0
    grain: float = 0.04
    grain_period: float = 0.3
    gloss: float = 0.0
    shine: float = 20.0
    black: bool = False
    glossy: bool = False
    transparent: bool = False
    emitting: bool = False


@dataclass
class Materials:
    """Draws materials for one scene; their colours belong together, and in some scenes hardly differ.

    Parameters
    ----------
    rng : numpy.random.Generator
        Where all chance comes from.
    """

    rng: np.random.Generator
    rows: list[Material] = field(default_factory=list)

    def __post_init__(self) -> None:
        rng = self.rng
        self._hues = rng.uniform(0, 1, rng.integers(1, 5))
        # Most scenes mix the colours of households; the others keep to a few, even to one.
        self._freedom = rng.choice([0.02, 0.1, np.inf], p=[0.1, 0.15, 0.75])
        self._vivid = rng.choice([0.1, 0.4, 0.75, 1.0], p=[0.15, 0.3, 0.35, 0.2])
        # Scenes of low contrast keep to one brightness, near and far alike.
        self._level = rng.uniform(0.25, 0.8)
        self._contrast = rng.choice([0.06, 0.3, 1.0], p=[0.12, 0.23, 0.65])
        self._plainness = rng.choice([0.0, 0.4, 0.85], p=[0.45, 0.35, 0.2])

    def colour(self, low: float = 0.05, high: float = 0.95, vivid: float = 1.0) -> np.ndarray:
        """Linear RGB between two brightnesses, in the manner of the scene."""
        rng = self.rng
        if np.isinf(self._freedom):
            low_hue, high_hue = HUES[int(rng.choice(len(HUES), p=HUE_SHARES))]
            hue = rng.uniform(low_hue, high_hue)
        else:
            hue = (rng.choice(self._hues) + rng.normal(0, self._freedom)) % 1
        value = rng.uniform(low, high)
        value = float(np.clip(self._level + self._contrast * (value - self._level), 0.03, 0.97))
        srgb = np.array(colorsys.hsv_to_rgb(hue, float(rng.uniform(0, 1) ** 1.3 * self._vivid * vivid), value))
        return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)

    def add(self, **options: object) -> int:
        """Number of a new material."""
        rng = self.rng
        colours = [options.pop(name, None) for name in "abc"]
        a, b, c = (self.colour() if colour is None else colour for colour in colours)
        options.setdefault("turn", rng.choice([0.0, np.pi / 2, 0.0, rng.uniform(0, np.pi)]))
        self.rows.append(Material(a, b, c, number=rng.random(), shift=rng.uniform(0, 50), **options))
        return len(self.rows) - 1

    def drawn(self, patterns: tuple[str, ...], low: float, high: float, **options: object) -> int:
        """Material with one of these patterns, its period between two sizes [m]."""
        rng = self.rng
        pattern = "plain" if rng.random() < self._plainness else str(rng.choice(patterns))
        period = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        return self.add(pattern=pattern, period=period, **options)

    def wall(self) -> int:
        colours = {name: self.colour(0.35, 0.95, 0.35) for name in "abc"}
        if self.rng.random() < 0.12:
            return self.drawn(("bricks", "planks", "granite"), 0.15, 0.3, turn=0.0, grain=0.1, **colours)
        return self.drawn(WALLS, 0.05, 0.5, turn=0.0, grain=0.1 * self.rng.random() ** 3, grain_period=0.6, **colours)

    def ceiling(self) -> int:
        return self.drawn(("plain", "plain", "tiles", "planks"), 0.3, 0.8, a=self.colour(0.6, 0.97, 0.2), turn=0.0)

    def floor(self) -> int:
        rng = self.rng
        gloss = rng.choice([0.0, 0.0, 0.03, 0.06])
        pattern = "plain" if rng.random() < self._plainness * 0.6 else str(rng.choice(FLOORS))
        period = rng.uniform(0.08, 0.16) if pattern == "planks" else rng.uniform(0.04, 0.6)
        b = self.colour(0.2, 0.7)
        return self.add(
            pattern=pattern, period=period, a=b * rng.uniform(0.5, 1.2), b=b, gloss=gloss, shine=60.0,
            glossy=bool(gloss > 0.04), grain=rng.uniform(0, 0.12),
        )  # fmt: skip

    def seamed(self, *patterns: str) -> int:
        """Seams, fields or stripes of strong contrast on one flat surface."""
        rng = self.rng
        light, dark = self.colour(0.55, 0.97, 0.6), self.colour(0.03, 0.4)
        a, b = (light, dark) if rng.random() < 0.7 else (dark, light)
        return self.add(
            pattern=str(rng.choice(patterns or SEAMS)), period=float(np.exp(rng.uniform(np.log(0.12), 0.2))), a=a, b=b,
            turn=rng.choice([0.0, 0.0, np.pi / 2]), gloss=rng.choice([0.0, 0.0, 0.03]), grain=0.1 * rng.random() ** 2,
        )  # fmt: skip

    def street(self) -> int:
        return self.drawn(STREETS, 0.1, 0.8, grain=0.12, a=self.colour(0.25, 0.7, 0.4))

    def grass(self) -> int:
        green = np.array([0.08, 0.2, 0.04]) * self.rng.uniform(0.5, 2, 3)
        return self.add(pattern="granite", period=0.05, a=green, b=green * 1.7, c=green * 0.5, grain=0.25)

    def bark(self) -> int:
        brown = np.array([0.16, 0.11, 0.07]) * self.rng.uniform(0.4, 1.8) * self.rng.uniform(0.85, 1.15, 3)
        return self.add(pattern="wood", period=0.06, a=brown, b=0.4 * brown, turn=np.pi / 2, grain=0.3)

    def wood(self) -> int:
        light = np.array([0.45, 0.27, 0.13]) * self.rng.uniform(0.25, 1.5) * self.rng.uniform(0.8, 1.2, 3)
        gloss = self.rng.choice([0.0, 0.03])
        return self.add(
            pattern="wood", period=self.rng.uniform(0.03, 0.1), a=light, b=light * self.rng.uniform(0.4, 0.8),
            turn=self.rng.choice([0.0, np.pi / 2]), gloss=gloss,
        )  # fmt: skip

    def cloth(self) -> int:
        return self.drawn(CLOTHS, 0.01, 0.15, grain=self.rng.uniform(0.02, 0.25), grain_period=0.05)

    def rug(self) -> int:
        return self.drawn(RUGS, 0.08, 0.6, grain=0.2, grain_period=0.03)

    def pack(self) -> int:
        gloss = self.rng.choice([0.0, 0.03])
        return self.drawn(PACKS, 0.04, 0.3, gloss=gloss, turn=self.rng.choice([0.0, 0.0, np.pi / 2]), grain=0.02)

    def poster(self) -> int:
        return self.drawn(("poster", "picture", "page", "text", *ANYTHING), 0.2, 0.8, turn=0.0, grain=0.02)

    def paper(self) -> int:
        return self.drawn(("text", "text", "plain", "page"), 0.006, 0.03, a=self.colour(0.75, 0.97, 0.2), turn=0.0)

    def anything(self) -> int:
        return self.drawn(ANYTHING, 0.01, 0.6, grain=self.rng.uniform(0, 0.2))

    def plastic(self) -> int:
        return self.drawn(("plain", "plain", "plain", "label", "ribs"), 0.02, 0.2, gloss=0.04, shine=80.0, grain=0.0)

    def glaze(self) -> int:
        return self.drawn(("plain", "stripes", "dots", "poster", "rings"), 0.02, 0.15, gloss=0.05, shine=200.0, grain=0)

    def paint(self) -> int:
        return self.add(a=self.colour(0.2, 0.95), grain=0.02, gloss=self.rng.choice([0.0, 0.03]))

    def metal(self) -> int:
        tone = self.rng.uniform(0.15, 0.5)
        return self.add(a=np.full(3, tone), grain=0.05, gloss=self.rng.uniform(0.2, 0.6), shine=120.0, glossy=True)

    def black(self) -> int:
        tone = self.rng.uniform(0.004, 0.02)
        gloss = self.rng.choice([0.0, 0.04])
        return self.add(a=np.full(3, tone), grain=0.1, gloss=gloss, shine=150.0, black=True, glossy=bool(gloss))

    def glass(self) -> int:
        tint = 1 - self.rng.uniform(0.04, 0.35, 3) * self.rng.choice([0.4, 1.0])
        return self.add(a=tint, grain=0.0, gloss=0.06, shine=400.0, transparent=True, glossy=True)

    def leaves(self) -> int:
        green = np.array([0.07, 0.2, 0.05]) * self.rng.uniform(0.4, 2, 3)
        return self.add(pattern="leaf", period=0.05, a=green, b=green * 2, c=green, turn=0.0, gloss=0.02)

    def screen(self) -> int:
        """Face of a monitor: dark, or showing something."""
        if self.rng.random() < 0.5:
            return self.add(a=np.full(3, 0.006), grain=0.0, gloss=0.04, shine=300.0, black=True, glossy=True)
        return self.drawn(("page", "page", "poster", "picture"), 0.3, 0.6, turn=0.0, black=True, emitting=True, grain=0)

    def lamp(self, strength: float = 3.0) -> int:
        warm = np.array([1.0, self.rng.uniform(0.75, 1), self.rng.uniform(0.5, 1)])
        return self.add(a=warm * strength, grain=0.0, emitting=True)

    def outside(self) -> int:
        """What is seen through a window: bright, with something of a picture in it."""
        strength = self.rng.uniform(0.5, 4)
        colours = {name: strength * self.colour(0.3, 0.97, 0.6) for name in "abc"}
        return self.drawn(("picture", "gradient", "blotches"), 0.4, 1.5, turn=0.0, emitting=True, grain=0.1, **colours)

    def mirror(self) -> int:
        return self.add(a=np.full(3, 0.03), grain=0.0, gloss=0.85, shine=900.0, glossy=True)

    def skin(self) -> int:
        return self.add(a=np.array([0.5, 0.28, 0.19]) * self.rng.uniform(0.15, 1.4), grain=0.03)

    def one_of(self, *kinds: str) -> int:
        """Material of a kind drawn among these methods."""
        return int(getattr(self, str(self.rng.choice(kinds)))())


class Table:
    """The rows as columns, to look up many points at once."""

    def __init__(self, rows: list[Material]) -> None:
        self.colours = np.array([(m.a, m.b, m.c) for m in rows], np.float32)
        self.pattern = np.array([NUMBER[m.pattern] for m in rows])
        numbers = [(m.period, m.turn, m.number, m.shift, m.grain, m.grain_period, m.gloss, m.shine) for m in rows]
        (self.period, self.turn, self.number, self.shift, self.grain, self.grain_period, self.gloss, self.shine) = (
            np.array(numbers, np.float32).T
        )
        self.black, self.glossy, self.transparent, self.emitting = np.array(
            [(m.black, m.glossy, m.transparent, m.emitting) for m in rows], bool
        ).T

    def colour(self, material: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """Linear RGB of materials (N,) at texture coordinates (N, 2) [m], (N, 3)."""
        u, v = uv.T.astype(np.float32)
        cos, sin, scale = np.cos(self.turn), np.sin(self.turn), 1 / self.period
        across = (u * cos[material] + v * sin[material]) * scale[material] + self.shift[material]
        along = (v * cos[material] - u * sin[material]) * scale[material] + self.shift[material]
        colour = self.colours[material, 0]
        pattern = self.pattern[material]
        for number in np.unique(pattern[pattern > 0]):
            here = np.flatnonzero(pattern == number)
            row = material[here]
            second, third, tone = PATTERNS[number](across[here], along[here], self.number[row])
            a, b, c = np.moveaxis(self.colours[row], 1, 0)
            second, third = (np.asarray(x, np.float32)[:, None] for x in (second, third))
            mixed = a + (b - a) * second
            colour[here] = (mixed + (c - mixed) * third) * np.asarray(tone, np.float32)[:, None]
        grain = self.grain[material]
        rough = noise("cloud", u / self.grain_period[material], v / self.grain_period[material])
        return colour * np.clip(1 + grain * rough, 0.2, 2)[:, None]
