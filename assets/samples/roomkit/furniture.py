"""The pieces of the room, each as a list of (mesh, material) about its own origin on the floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import textures as tx
from .meshes import Mesh, box, curve, ellipsoid, grid, joined, lathe, tube
from .scene import Material

Parts = list[tuple[Mesh, Material]]


def matt(colour: str, texture: tx.Texture | None = None, **options: object) -> Material:
    return Material(colour=tx.linear(colour), texture=texture, **options)


OAK = matt("#b98a5a", tx.wood("#94683f", "#c99c69"), gloss=0.03, roughness=0.06)
WALNUT = matt("#6b4630", tx.wood("#4a2e1f", "#855a3c"), gloss=0.03, roughness=0.06)
LEGS = matt("#b98a5a", tx.wood("#94683f", "#c99c69", along=1))
BRASS = matt("#b08a4a", gloss=0.2, roughness=0.2)
GLOSSY_BLACK = matt("#08080a", gloss=0.05, roughness=0.004, black=True)
MATT_BLACK = matt("#141416", gloss=0.02, roughness=0.1, black=True)
LACQUER = matt("#1a1a1d", gloss=0.05, roughness=0.03, black=True)
CERAMIC = matt("#e9e4da", gloss=0.05, roughness=0.01)
GLASS = matt("#ffffff", gloss=0.08, roughness=0.004, clear=True)
PAPER = matt("#eee7d6", tx.banded("#eee7d6", "#d9d0bb", 0.0, 0.004))


def placed(parts: Parts, x: float, y: float, z: float, turn: float = 0.0) -> Parts:
    return [(mesh.turned(turn).moved(x, y, z), material) for mesh, material in parts]


def desk(width: float, depth: float, height: float) -> Parts:
    """Desk with a pedestal of three drawers under its left end."""
    top = box((width, 0.032, depth), 0.006).moved(y=height - 0.016)
    legs = []
    for x, z in ((width / 2 - 0.07, depth / 2 - 0.07), (width / 2 - 0.07, 0.07 - depth / 2)):
        legs.append(tube([(x + 0.02, 0, z), (x, height - 0.03, z)], (0.014, 0.023)))
    pedestal, front_z = box((0.44, height - 0.12, depth - 0.08), 0.006), 0.04 - depth / 2
    left = 0.24 - width / 2
    parts: Parts = [(top, OAK), (joined(legs), LEGS), (pedestal.moved(left, height / 2 + 0.02, 0), LACQUER)]
    feet = [tube([(left + x, 0, z), (left + x, 0.09, z)], 0.018) for x in (-0.18, 0.18) for z in (-0.2, 0.2)]
    parts.append((joined(feet), LEGS))
    pitch = (height - 0.14) / 3
    for i in range(3):
        y = 0.09 + pitch * (i + 0.5)
        parts.append((box((0.41, pitch - 0.014, 0.02), 0.004).moved(left, y, front_z - 0.008), LACQUER))
        knob = ellipsoid((0.03, 0.03, 0.03)).moved(left, y, front_z - 0.032)
        parts.append((knob, BRASS))
    return parts


def monitor() -> Parts:
    screen = box((0.60, 0.36, 0.012), 0.004).moved(y=0.31, z=-0.012)
    shell = box((0.61, 0.37, 0.025), 0.008).moved(y=0.31, z=0.008)
    neck = box((0.06, 0.22, 0.02), 0.006).moved(y=0.12, z=0.03)
    foot = lathe([(0, 0), (0.115, 0), (0.115, 0.008), (0.03, 0.016), (0, 0.016)]).moved(z=0.03)
    return [(screen, GLOSSY_BLACK), (joined([shell, neck, foot]), MATT_BLACK)]


def keyboard() -> Parts:
    keys = []
    for row in range(5):
        for column in range(14):
            if row == 0 and 3 < column < 9:
                continue
            keys.append(
                box((0.024, 0.008, 0.021), 0.003, steps=1).moved(-0.182 + 0.028 * column, 0.018, -0.05 + 0.025 * row)
            )
    keys.append(box((0.136, 0.008, 0.021), 0.003, steps=1).moved(-0.014, 0.018, -0.05))
    case = box((0.41, 0.014, 0.14), 0.005).moved(y=0.008)
    return [(case, matt("#c9ccd0", gloss=0.04, roughness=0.1)), (joined(keys), matt("#f2f1ee"))]


def mouse() -> Parts:
    return [(ellipsoid((0.062, 0.06, 0.105)).moved(y=0.008), matt("#dfe0e2", gloss=0.04, roughness=0.05))]


def mug(colour: str) -> Parts:
    body = lathe(
        [
            (0, 0.004),
            (0.034, 0.0),
            (0.041, 0.008),
            (0.042, 0.095),
            (0.0395, 0.097),
            (0.038, 0.09),
            (0.037, 0.012),
            (0, 0.012),
        ]
    )
    angle = np.linspace(-1.45, 1.45, 15)
    handle = tube([(0.038 + 0.034 * np.cos(a), 0.05 + 0.032 * np.sin(a), 0.0) for a in angle], 0.0065)
    coffee = lathe([(0, 0.078), (0.038, 0.078)])
    glaze = matt(colour, gloss=0.05, roughness=0.01)
    return [(joined([body, handle]), glaze), (coffee, matt("#2b1a10", gloss=0.03))]


def book(width: float, height: float, depth: float, colour: str, band: str) -> Parts:
    """Book that stands with its spine towards -z; its bottom is at y = 0."""
    cover = matt(colour, tx.banded(colour, band, height * 0.22, height * 0.36), gloss=0.03, roughness=0.1)
    shell = [
        box((0.003, height, depth)).moved(x=-width / 2),
        box((0.003, height, depth)).moved(x=width / 2),
        box((width, height, 0.004), 0.0019).moved(z=-depth / 2),
    ]
    block = box((width - 0.003, height - 0.012, depth - 0.01)).moved(z=0.002)
    return [(joined(shell).moved(y=height / 2), cover), (block.moved(y=height / 2), PAPER)]


SPINES = (
    ("#7a2f2b", "#d8b26a"), ("#2f4b63", "#e6dfcf"), ("#c58b34", "#4b2f1a"), ("#3f6b57", "#e8d9a8"),
    ("#d9d2c3", "#7a2f2b"), ("#54415f", "#d7c7a0"), ("#b5583a", "#f0e2c8"), ("#26333b", "#c58b34"),
)  # fmt: skip


def standing_books(count: int, rng: np.random.Generator) -> Parts:
    parts: Parts = []
    x, order = 0.0, rng.permutation(len(SPINES))
    for i in range(count):
        width, height = rng.uniform(0.022, 0.045), rng.uniform(0.19, 0.265)
        x += width / 2
        parts += placed(book(width, height, rng.uniform(0.15, 0.18), *SPINES[order[i % len(order)]]), x, 0, 0)
        x += width / 2 + 0.002
    return parts


def lying_books(count: int, rng: np.random.Generator) -> Parts:
    parts: Parts = []
    y, order = 0.0, rng.permutation(len(SPINES))
    for i in range(count):
        width, height = rng.uniform(0.02, 0.035), rng.uniform(0.20, 0.25) - 0.015 * i
        one = book(width, height, 0.16 - 0.01 * i, *SPINES[order[i]])
        flat = [(mesh.turned(90, "z").moved(x=height / 2, y=width / 2), material) for mesh, material in one]
        parts += placed(flat, 0, y, 0, rng.uniform(-14, 14))
        y += width + 0.003
    return parts


def desk_lamp(target: np.ndarray) -> tuple[Parts, np.ndarray]:
    """Jointed halogen lamp; its head points at `target` (own coordinates). Also gives the bulb's position."""
    foot = lathe([(0, 0), (0.085, 0), (0.085, 0.012), (0.07, 0.02), (0.012, 0.026), (0, 0.026)])
    elbow, head = np.array([0.09, 0.34, -0.06]), np.array([-0.02, 0.56, -0.20])
    arms = [tube([(0, 0.02, 0), elbow], 0.007), tube([elbow, head], 0.007), ellipsoid((0.03, 0.03, 0.03)).moved(*elbow)]
    aim = (target - head) / np.linalg.norm(target - head)
    profile = [(0.0, -0.05), (0.024, -0.045), (0.03, 0.0), (0.052, 0.085), (0.049, 0.085), (0.027, 0.0), (0.0, -0.02)]
    shell, bulb = lathe(profile), lathe([(0.0, 0.035), (0.018, 0.03), (0.018, 0.0)])
    turned = [_aimed(mesh, aim, head) for mesh in (shell, bulb)]
    glow = Material(colour=np.ones(3), emission=np.array([40.0, 34.0, 24.0]))
    enamel = matt("#2f5d62", gloss=0.05, roughness=0.03)
    return [(joined([foot, *arms, turned[0]]), enamel), (turned[1], glow)], head + 0.04 * aim


def _aimed(mesh: Mesh, aim: np.ndarray, origin: np.ndarray) -> Mesh:
    """Turn the y axis of a mesh to `aim` and move it to `origin`."""
    side = np.cross(aim, (0.0, 0.0, 1.0) if abs(aim[2]) < 0.9 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    axes = np.stack([side, aim, np.cross(side, aim)])
    return Mesh(mesh.vertices @ axes + origin, mesh.triangles, mesh.texture)


def chair(cloth: str) -> Parts:
    """Wooden chair with an upholstered seat and a curved back; the back is on the -z side."""
    bars = []
    for x in (-1, 1):
        bars.append(tube([(0.20 * x, 0, 0.21), (0.185 * x, 0.44, 0.18)], (0.012, 0.019)))
        back = [
            (0.20 * x, 0, -0.25),
            (0.185 * x, 0.24, -0.21),
            (0.185 * x, 0.46, -0.19),
            (0.18 * x, 0.66, -0.215),
            (0.172 * x, 0.84, -0.26),
        ]
        bars.append(tube(back, (0.012, 0.017, 0.019, 0.017, 0.014)))
        bars.append(tube([(0.18 * x, 0.40, 0.18), (0.18 * x, 0.40, -0.19)], 0.014))
    for z in (0.18, -0.19):
        bars.append(tube([(-0.18, 0.40, z), (0.18, 0.40, z)], 0.014))
    rests = []
    for low, high, lean in ((0.70, 0.83, -0.235), (0.55, 0.61, -0.20)):
        x, y = np.meshgrid(np.linspace(-0.185, 0.185, 17), np.linspace(low, high, 5))
        bow = lean - 0.03 * np.cos(x / 0.185 * np.pi / 2) - 0.2 * (y - low)
        rests += [grid(np.stack([x, y, bow + d], axis=-1)) for d in (-0.009, 0.009)]
        board = np.stack([x, y, bow], axis=-1)
        rim = np.concatenate([board[0], board[-1, ::-1], board[0, :1]])
        rests.append(tube(rim, 0.009, 8))
    seat = box((0.42, 0.07, 0.42), 0.032, bulge=0.012).moved(y=0.455, z=-0.005)
    return [(joined(bars), LEGS), (joined(rests), OAK), (seat, matt(cloth, tx.fabric(cloth)))]


def sofa(length: float, cloth: str, cushions: tuple[str, ...]) -> Parts:
    """Sofa along x with rounded arms; it faces -z, its back is at z = +0.42."""
    body = [
        box((length - 0.1, 0.20, 0.80), 0.03).moved(y=0.23),
        box((length - 0.06, 0.52, 0.20), 0.08, bulge=0.01).turned(-7, "x").moved(y=0.54, z=0.32),
    ]
    for side in (-1, 1):
        body.append(box((0.20, 0.50, 0.84), 0.085, bulge=0.008).moved(side * (length / 2 - 0.10), 0.38, 0.0))
    seats, half = [], (length - 0.40) / 2
    for side in (-1, 1):
        seats.append(box((half - 0.006, 0.15, 0.66), 0.045, bulge=0.022).moved(side * half / 2, 0.40, -0.08))
        seats.append(
            box((half - 0.01, 0.38, 0.15), 0.055, bulge=0.03).turned(-13, "x").moved(side * half / 2, 0.645, 0.17)
        )
    feet = [
        tube([(x, 0, z), (x, 0.15, z)], (0.015, 0.022))
        for x in (0.12 - length / 2, length / 2 - 0.12)
        for z in (-0.33, 0.33)
    ]
    cover = matt(cloth, tx.fabric(cloth, 0.008, 0.26))
    parts: Parts = [(joined(body), cover), (joined(seats), cover), (joined(feet), WALNUT)]
    for i, colour in enumerate(cushions):
        pillow = box((0.40, 0.40, 0.02), 0.009, bulge=0.07).turned(12 - 20 * i, "z").turned(-27, "x")
        x = (length / 2 - 0.44) * (1 if i % 2 else -1)
        parts.append((pillow.moved(x, 0.69, -0.02), matt(colour, tx.fabric(colour, 0.005))))
    return parts


def round_table(radius: float, height: float) -> Parts:
    top = lathe(
        [
            (0, height),
            (radius - 0.008, height),
            (radius, height - 0.008),
            (radius - 0.012, height - 0.028),
            (0, height - 0.028),
        ],
        72,
    )
    wood_top = Mesh(top.vertices, top.triangles, top.vertices.copy())
    legs = []
    for turn in np.radians((80, 200, 320)):
        x, z = np.cos(turn), np.sin(turn)
        legs.append(
            tube(
                [(0.92 * radius * x, 0, 0.92 * radius * z), (0.6 * radius * x, height - 0.02, 0.6 * radius * z)],
                (0.012, 0.02),
            )
        )
    return [(wood_top, WALNUT), (joined(legs), WALNUT)]


def vase_with_tulips(rng: np.random.Generator) -> Parts:
    outline = curve([(0.045, 0.0), (0.075, 0.06), (0.078, 0.11), (0.045, 0.18), (0.036, 0.21), (0.046, 0.235)], 40)
    glaze = matt("#3f7f86", tx.banded("#3f7f86", "#e4dcc8", 0.085, 0.10), gloss=0.05, roughness=0.01)
    parts: Parts = [(lathe([(0, 0.0), *outline, (0.040, 0.235), (0.030, 0.20)]), glaze)]
    stems, petals, turns = [], [[], []], np.linspace(0, 2 * np.pi, 8)[:-1]
    for i, turn in enumerate(turns + rng.uniform(-0.3, 0.3, len(turns))):
        reach, height = rng.uniform(0.06, 0.15), rng.uniform(0.36, 0.46)
        x, z = reach * np.cos(turn), reach * np.sin(turn)
        stems.append(
            tube(
                [(0, 0.12, 0), (0.25 * x, 0.24, 0.25 * z), (0.65 * x, height - 0.07, 0.65 * z), (x, height, z)],
                0.004,
                8,
            )
        )
        bloom = lathe(curve([(0, -0.028), (0.021, -0.012), (0.024, 0.010), (0.013, 0.032)], 12), 16)
        petals[i % 2].append(bloom.turned(np.degrees(reach) * 2 * np.cos(turn), "z").moved(x, height + 0.015, z))
    blades = _blades(9, 0.24, 0.034, rng, lift=1.15).moved(y=0.20)
    parts += [(joined(stems), matt("#6d9a45")), (blades, matt("#4f7f3f", tx.leaf))]
    return parts + [(joined(p), matt(c)) for p, c in zip(petals, ("#d9483b", "#e9a13b"), strict=True)]


def plant(rng: np.random.Generator) -> Parts:
    """Broad-leaved plant in a wicker basket."""
    basket = lathe([(0, 0.0), (0.12, 0.0), (0.165, 0.10), (0.17, 0.20), (0.155, 0.29), (0.145, 0.29), (0.14, 0.22)], 72)
    soil = lathe([(0, 0.25), (0.15, 0.24)])
    parts: Parts = [(basket, matt("#b08d5f", tx.wicker("#b99666"))), (soil, matt("#33241a"))]
    low = _blades(9, 0.42, 0.15, rng, lift=0.75).moved(y=0.24)
    high = _blades(10, 0.56, 0.15, rng, lift=1.25).moved(y=0.26)
    return [*parts, (joined([low, high]), matt("#487a3c", tx.leaf, gloss=0.03, roughness=0.15))]


def _blades(count: int, length: float, width: float, rng: np.random.Generator, *, lift: float) -> Mesh:
    """Leaves that rise from the origin and arch outwards."""
    along, across = np.linspace(0, 1, 15), np.linspace(-1, 1, 7)
    s, a = np.meshgrid(along, across, indexing="ij")
    leaves = []
    for i in range(count):
        size, rise = length * rng.uniform(0.8, 1.15), lift * rng.uniform(0.85, 1.12)
        out = size * s * np.cos(rise * (1 - 0.75 * s))
        up = size * s * np.sin(rise * (1 - 0.55 * s)) * 1.15
        shape = width / 2 * np.sin(np.pi * np.clip((s - 0.18) / 0.82, 0.03, 1) ** 0.8) * np.clip(1.04 - s, 0, 1) ** 0.25
        points = np.stack([out, up + 0.25 * shape * np.abs(a), shape * a], axis=-1)
        leaf = grid(points)
        texture = np.stack([a, np.full_like(a, i + 0.5), s], axis=-1).reshape(-1, 3)
        turned = leaf.turned(360 / count * (i + rng.uniform(-0.25, 0.25)))
        leaves.append(Mesh(turned.vertices, turned.triangles, texture))
    return joined(leaves)


def floor_lamp(height: float) -> tuple[Parts, np.ndarray]:
    """Standing lamp with a cloth shade. Also gives the bulb's position."""
    stand = [
        lathe([(0, 0), (0.14, 0), (0.14, 0.015), (0.02, 0.03), (0, 0.03)]),
        tube([(0, 0.02, 0), (0, height - 0.1, 0)], 0.011),
    ]
    shade = lathe([(0.205, height - 0.28), (0.135, height)], 64)
    warm = Material(colour=tx.linear("#f3e3c4"), emission=np.array([2.3, 1.62, 0.92]))
    return [(joined(stand), BRASS), (shade, warm)], np.array([0.0, height - 0.14, 0.0])


def picture(width: float, height: float) -> Parts:
    """Framed painting, flat against a wall at z = 0 and facing -z."""
    bars = [box((width, 0.028, 0.03), 0.005).moved(y=s * (height / 2 - 0.014), z=-0.015) for s in (-1, 1)]
    bars += [box((0.028, height, 0.03), 0.005).moved(x=s * (width / 2 - 0.014), z=-0.015) for s in (-1, 1)]
    mount = box((width - 0.03, height - 0.03, 0.012)).moved(z=-0.006)
    canvas = box((width - 0.17, height - 0.17, 0.002)).moved(z=-0.013)
    art = matt("#8d8a83", tx.painting((width - 0.17) / 2, (height - 0.17) / 2))
    return [(joined(bars), WALNUT), (mount, matt("#efece3")), (canvas, art)]


def bowl_of_oranges() -> Parts:
    dish = lathe(
        [
            *curve([(0.0, 0.004), (0.05, 0.006), (0.095, 0.03), (0.115, 0.062)], 24),
            *((0.110, 0.063), (0.09, 0.036), (0.0, 0.012)),
        ]
    )
    fruit = [
        ellipsoid((0.074, 0.072, 0.074)).moved(0.042 * np.cos(t), 0.052, 0.042 * np.sin(t)) for t in (0.5, 2.6, 4.7)
    ]
    peel = matt(
        "#e08a2c",
        lambda p: tx.linear("#e08a2c") * (0.85 + 0.25 * tx.noise(p * 220, octaves=1))[:, None],
        gloss=0.03,
        roughness=0.12,
    )
    return [(dish, CERAMIC), (joined([*fruit, fruit[0].moved(-0.03, 0.055, -0.02)]), peel)]


def glass(outline: Sequence[tuple[float, float]]) -> Parts:
    """Empty vessel of thin glass, by radius and height of its outside."""
    return [(lathe([(0.0, outline[0][1]), *curve(outline, 32)], 64), GLASS)]


def carafe_and_tumblers() -> Parts:
    """Three vessels of clear glass, in a row along x."""
    carafe = [(0.048, 0.0), (0.060, 0.02), (0.062, 0.07), (0.036, 0.15), (0.028, 0.19), (0.040, 0.235)]
    tumbler = [(0.030, 0.0), (0.034, 0.03), (0.038, 0.09)]
    return [
        *glass(carafe),
        *placed(glass(tumbler), -0.115, 0.0, 0.02),
        *placed(glass(tumbler), -0.19, 0.0, 0.075),
    ]
