"""Kinds of scene whose long walls recede: halls and streets."""

from __future__ import annotations

import numpy as np

from .furniture import FREE
from .light import Lamp
from .outside import OUTSIDE
from .parts import Ground, Kit, Parts, copied, footprint, moved, one_object, turned
from .setting import Setting
from .shapes import ball, box, joined, lathe, rotation, standing
from .storage import cupboard_of
from .walls import carpet, door_leaf, painted, panelled_wall, shell, unbroken, wall_with, window


def hall(kit: Kit) -> Setting:
    """Corridor, hall or room with seams, panels and stripes on walls, floor and ceiling."""
    width, depth = (kit.between(1.3, 3.5), kit.between(6, 25)) if kit.chance(0.65) else kit.rng.uniform(3, 7, 2)
    height = kit.between(2.2, 3.4)
    plain, seamed = kit.materials.wall, kit.materials.seamed
    parts = shell(kit, width, depth, height, plain() if kit.chance(0.65) else seamed(), panelled_wall)
    if kit.chance(0.6):
        parts[0] = parts[0][0], seamed("tiles", "checker", "planks", "parquet", "stripes")
    if kit.chance(0.5):
        parts[1] = parts[1][0], seamed("tiles", "tiles", "planks")
    shining, lamps = _ceiling_lamps(kit, width, depth, height)
    parts += shining
    if kit.chance(0.4):
        parts += moved(carpet(kit, width * kit.between(0.4, 0.8), depth * kit.between(0.4, 0.9)), 0, 0.006, depth / 2)
    if kit.chance(0.4):
        side, deep, long = kit.rng.choice([-1, 1]), kit.between(0.3, 0.6), kit.between(1.2, 0.5 * depth)
        fronts = turned(fitted(kit, long, kit.between(0.8, height), deep), rotation(90 * side))
        parts += moved(fronts, side * (width / 2 - deep / 2 - 0.04), 0, kit.between(long / 2 + 1, depth - long / 2))
    ground = Ground(kit, (-width / 2 + 0.25, width / 2 - 0.25), (1.5, depth - 0.4))
    for _ in range(kit.number(0, 4)):
        thing = turned(kit.one_of(FREE)(kit), rotation(kit.between(0, 360)))
        if footprint(thing) < 0.35 * width:
            parts += ground.put(thing)
    stand = np.array([-width / 2 + 0.3, 0.7, 0.2]), np.array([width / 2 - 0.3, 1.9, 0.3 * depth])
    look = np.array([-width / 2, 0.5, 0.5 * depth]), np.array([width / 2, 1.9, depth])
    return Setting(parts, stand, look, lamps=lamps)


def _ceiling_lamps(kit: Kit, width: float, depth: float, height: float) -> tuple[Parts, tuple[Lamp, ...]]:
    """A row of like lamps in or under the ceiling, and the light of three of them."""
    size = np.array(kit.rng.choice([(0.6, 0.6), (0.15, 1.2), (1.2, 0.3), (0.2, 0.2)])).clip(max=0.7 * width)
    deep, first, pitch = kit.rng.choice([0.002, 0.06]), kit.between(0.5, 2), kit.between(1.5, 4)
    places = np.arange(first, depth - 0.7, pitch)
    one: Parts = [(box((size[0], deep, size[1])).moved(y=height - deep / 2), kit.materials.lamp())]
    colour = np.full(3, kit.between(0.4, 2))
    lamps = tuple(Lamp(np.array([0, height - 0.15, z]), colour, 0.2) for z in places[:: max(1, len(places) // 3)][:3])
    return [part for z in places for part in moved(one, z=z)], lamps


@one_object
def fitted(kit: Kit, width: float, height: float, depth: float) -> Parts:
    """Cupboards whose fronts differ from each other by gaps, handles and colour."""
    if kit.chance(0.4):
        return cupboard_of(kit, width, height, depth)
    return [(standing((width, height, depth)), kit.materials.seamed("panels", "panels", "tiles", "stripes"))]


def street(kit: Kit) -> Setting:
    """House fronts that recede on both sides, with pavements, kerbs and road markings between."""
    half, walk, length, kerb = kit.between(1.8, 5), kit.between(0.8, 2.5), kit.between(12, 32), kit.between(0.06, 0.16)
    parts, stone = _road(kit, half), (kit.materials.street(), kit.materials.street())
    for side in (-1, 1):
        parts += _pavement(side * half, side * (half + walk + 3), kerb, stone)
        z = -3.0
        while z < length:
            wide, edge = kit.between(4, 10), half + walk + kit.rng.choice([0.0, 0.0, 0.15, 0.4])
            place = (edge, kerb, z + wide) if side > 0 else (-edge, kerb, z)
            parts += moved(turned(house_front(kit, wide), rotation(90 * side)), *place)
            z += wide + kit.rng.choice([0.0, 0.0, 0.0, kit.between(1, 4)])
        ground = Ground(kit, tuple(sorted((side * (half + 0.3), side * (half + walk - 0.2)))), (2, length), kerb)
        for _ in range(kit.number(0, 5)):
            parts += ground.put(turned(kit.one_of(OUTSIDE)(kit), rotation(kit.between(0, 360))), 0.5)
        for z in np.arange(kit.between(5, 12), length, kit.between(4.5, 9)) if kit.chance(0.6) else ():
            parts += moved(car(kit), side * (half - 1.05), 0, z)
    if kit.chance(0.5):
        parts += moved(house_front(kit, 24), -12, 0, length)
    stand = np.array([-half - walk + 0.4, 1.2, -1.5]), np.array([half + walk - 0.4, 2.0, 1.0])
    look = np.array([-half, 0.8, 0.6 * length]), np.array([half, 2.5, length])
    return Setting(parts, stand, look, inside=False)


@one_object
def _road(kit: Kit, half: float) -> Parts:
    """Ground with painted lines."""
    parts: Parts = [(standing((60, 0.1, 58)).moved(0, -0.1, 25), kit.materials.street())]
    white, broad = kit.materials.paint(), kit.between(0.1, 0.25)
    marks = [(x, -4.0, broad, 58.0) for x in (0.35 - half, half - 0.35 - broad) if kit.chance(0.4)]
    dash = kit.between(1, 4)
    marks += [(-broad / 2, z, broad, dash) for z in np.arange(-4, 50, dash * kit.between(1.5, 3))]
    if kit.chance(0.3):
        z = kit.between(3, 9)
        marks += [(x, z, 0.5, 3.0) for x in np.arange(0.1 - half, half - 0.5, 1.0)]
    flat = joined([painted(wide, long).turned(rotation(90, "x")).moved(x, 0.001, z) for x, z, wide, long in marks])
    return [*parts, (flat, white)]


@one_object
def _pavement(kerb_at: float, end: float, high: float, stone: tuple[int, int]) -> Parts:
    """Raised ground from a kerb of another stone to its end in x."""
    edge = kerb_at + np.sign(end - kerb_at) * 0.15
    return [
        (standing((abs(b - a), high, 58)).moved((a + b) / 2, 0, 25), material)
        for a, b, material in ((kerb_at, edge, stone[1]), (edge, end, stone[0]))
    ]


def house_front(kit: Kit, width: float) -> Parts:
    """Front seen from -z, x from 0 to `width`: rows of like windows, flush or set back a little, and a door."""
    storey, wide, low, tall = kit.between(2.6, 3.5), kit.between(0.7, 1.8), kit.between(0.5, 1.0), kit.between(1.1, 1.7)
    back = kit.rng.choice([-0.02, 0.0, 0.03, 0.08, 0.2])
    places = [float(x) for x in np.arange(kit.between(0.4, 1.2), width - wide - 0.3, wide + kit.between(0.4, 2))]
    entrance = kit.number(0, len(places) - 1)
    pane, rows, parts = window(kit, wide, tall, ("black", "mirror", "screen", "outside")), [], []
    for n in range(kit.number(1, 4)):
        bottoms = [0.0 if (n, k) == (0, entrance) else low for k in range(len(places))]
        holes = [(x, x + wide, bottom, low + tall) for x, bottom in zip(places, bottoms, strict=True)]
        rows.append(wall_with(width, storey, 0.3, holes).moved(y=n * storey))
        for x, _, bottom, high in holes:
            thing = copied(pane) if bottom else door_leaf(kit, wide, high, 0.0)
            parts += moved(thing, x, n * storey + bottom, back + 0.03)
    kinds = ("wall", "street", "wood", "paint")
    paint = kit.materials.seamed("bricks", "tiles", "planks") if kit.chance(0.25) else kit.materials.one_of(*kinds)
    return [*parts, (unbroken(joined(rows)), paint)]


@one_object
def car(kit: Kit) -> Parts:
    """Parked along z."""
    length, shift, paint = kit.between(3.6, 4.8), kit.between(-0.4, 0.1), kit.materials.plastic()
    body = ball((1.75, 0.75, length), 0.35).moved(0, 0.65, 0)
    panes, roof = ball((1.5, 0.75, 0.55 * length), 0.5), ball((1.4, 0.2, 0.42 * length), 0.5)
    wheel = lathe([(0, -0.1), (0.32, -0.1), (0.32, 0.1), (0, 0.1)]).turned(rotation(90, "z"))
    wheels = [wheel.moved(x, 0.32, z * length) for x in (-0.8, 0.8) for z in (-0.3, 0.3)]
    dark = joined([*wheels, panes.moved(0, 1.1, shift)])
    return [(body, paint), (roof.moved(0, 1.43, shift), paint), (dark, kit.materials.black())]
