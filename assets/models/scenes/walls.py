"""Walls with doors and windows, rooms made of them, and what belongs to a building."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .frames import hanging
from .furniture import BY_WALL
from .parts import Kit, Parts, copied, extent, moved, one_object, turned
from .shapes import Shape, ball, bar, box, joined, lathe, rotation, sheet, standing
from .storage import laid_out

Opening = tuple[float, float, float, float]
"""Left, right, bottom and top of a hole in a wall [m]."""

MakeWall = Callable[[Kit, float, float, int], tuple[Parts, list[Opening]]]
"""Makes a wall of a width, height [m] and material, as `one_wall`."""


def wall_with(width: float, height: float, thick: float, openings: list[Opening]) -> Shape:
    """Wall in the plane z = 0 .. thick, its left lower corner at the origin, around openings side by side."""
    boxes, x = [], 0.0
    for left, right, low, high in sorted(openings):
        boxes.append(standing((left - x, height, thick)).moved((x + left) / 2))
        if low > 0:
            boxes.append(standing((right - left, low, thick)).moved((left + right) / 2))
        boxes.append(standing((right - left, height - high, thick)).moved((left + right) / 2, high))
        x = right
    boxes.append(standing((width - x, height, thick)).moved((x + width) / 2))
    return joined(boxes).moved(z=thick / 2)


@one_object
def door_leaf(kit: Kit, width: float, height: float, turn: float) -> Parts:
    """Door hung at the origin that opens by a turn [degrees]."""
    leaf = standing((width, height, 0.04)).moved(x=width / 2)
    knob = bar((width - 0.1, 1.0, -0.07), (width - 0.1, 1.0, 0.07), 0.012)
    parts: Parts = [(leaf, kit.materials.one_of("wood", "paint", "wall")), (knob, kit.materials.metal())]
    if kit.chance(0.4):
        panels = [box((width * 0.6, height * 0.35, 0.05)).moved(width / 2, height * y) for y in (0.28, 0.72)]
        parts.append((joined(panels), parts[0][1] if kit.chance(0.6) else kit.materials.glass()))
    return turned(parts, rotation(turn))


def one_wall(kit: Kit, width: float, height: float, paint: int) -> tuple[Parts, list[Opening]]:
    """Wall from x = 0 to `width` seen from -z, with doors, windows, pictures, skirting; also its doors."""
    thick, openings, parts = kit.between(0.08, 0.3), [], []
    doors: list[Opening] = []
    x = kit.between(0.1, 1.0)
    while x < width - 0.9:
        wide = kit.between(0.7, 1.6)
        if x + wide > width - 0.15:
            break
        if kit.chance(0.25):
            opening, leaf = _doorway(kit, x, min(wide, 1.0), height, thick)
            doors.append(opening)
            openings.append(opening)
            parts += leaf
        elif kit.chance(0.3):
            opening, panes = _window_in_wall(kit, x, wide, height, thick)
            openings.append(opening)
            parts += panes
        elif kit.chance(0.5):
            parts += kit.one_of(ON_WALL)(kit, x, wide, height)
        x += wide + kit.between(0.1, 1.5)
    parts.append((wall_with(width, height, thick, openings), paint))
    if kit.chance(0.5):
        parts.append(_skirting(kit, width, doors))
    return parts, doors


def _skirting(kit: Kit, width: float, doors: list[Opening]) -> tuple[Shape, int]:
    boards = [standing((b - a, 0.08, 0.02)).moved((a + b) / 2, 0, -0.01) for a, b in _between_doors(width, doors)]
    return joined(boards), kit.materials.paint()


def panelled_wall(kit: Kit, width: float, height: float, paint: int) -> tuple[Parts, list[Opening]]:
    """Wall as `one_wall`, with paint in fields and bands, and doors alike in frames; also those that are open."""
    thick, tall, wide = kit.between(0.1, 0.3), min(kit.between(1.95, 2.2), height - 0.15), kit.between(0.7, 1.2)
    places = np.arange(kit.between(0.2, 2.5), width - wide - 0.15, wide + kit.between(0.3, 4))
    doors = [(float(x), float(x) + wide, 0.0, tall) for x in places]
    parts = painted_wall(kit, wall_with(width, height, thick, doors), _between_doors(width, doors), paint)
    leaf, case = door_leaf(kit, wide, tall, 0.0), _door_frame(kit, wide, tall)
    back, share, opened = kit.rng.choice([0.0, 0.01, 0.04, thick - 0.05]), kit.rng.choice([0.0, 0.15, 0.5]), []
    for door in doors:
        turn = 0.0
        if kit.chance(share):
            turn = float(kit.rng.choice([-110.0, -85.0, -40.0, -15.0, 80.0]))
            opened.append(door)
        parts += moved(turned(copied(leaf), rotation(turn)), door[0], 0, 0.025 + back) + moved(copied(case), door[0])
    for a, b in _between_doors(width, doors):
        if b - a > 0.9 and kit.chance(0.2):
            parts += kit.one_of(ON_WALL)(kit, a + 0.15, min(b - a - 0.3, 1.6), height)
    if kit.chance(0.7):
        parts.append(_skirting(kit, width, doors))
    return parts, opened


@one_object
def painted_wall(kit: Kit, wall: Shape, pieces: list[tuple[float, float]], paint: int) -> Parts:
    """A wall in the plane z = 0, with bands or fields painted on its pieces between doors."""
    height = wall.high[1]
    parts: Parts = [(unbroken(wall), paint)]
    inset, other = kit.rng.choice([0.0, 0.0, 0.12]), kit.materials.one_of("paint", "seamed", "wood")
    for n in range(kit.rng.choice([0, 0, 1, 1, 2])):
        low = kit.rng.choice([inset, kit.between(0.5, 0.8 * height)])
        tall = min(kit.rng.choice([0.06, 0.2, 1.1, 3.0]), height - low - inset)
        for a, b in pieces:
            if b - a > 3 * inset:
                parts.append((painted(b - a - 2 * inset, tall).moved(a + inset, low, -0.001 * (n + 1)), other))
    return parts


def unbroken(wall: Shape) -> Shape:
    """The wall in the plane z = 0 with a pattern that runs on past its openings."""
    return replace(wall, uv=wall.vertices[:, :2])


def painted(width: float, height: float) -> Shape:
    """Paint on a wall in the plane z = 0, its left lower corner at the origin."""
    return sheet(np.array([[(0, 0, 0), (width, 0, 0)], [(0, height, 0), (width, height, 0)]]))


@one_object
def _door_frame(kit: Kit, width: float, height: float) -> Parts:
    """Three boards around an opening, before the wall."""
    broad, proud = kit.between(0.04, 0.12), kit.between(0.005, 0.03)
    boards = [standing((broad, height, proud)).moved(x) for x in (-broad / 2, width + broad / 2)]
    boards.append(standing((width + 2 * broad, broad, proud)).moved(width / 2, height))
    return [(joined(boards).moved(z=-proud / 2), kit.materials.one_of("paint", "wood", "metal"))]


def _doorway(kit: Kit, x: float, wide: float, height: float, thick: float) -> tuple[Opening, Parts]:
    """Opening in a wall, and its door, if it has one."""
    opening = (x, x + wide, 0.0, min(kit.between(1.95, 2.15), height - 0.1))
    if not kit.chance(0.6):
        return opening, []
    turn = float(kit.rng.choice([0.0, 60.0, 95.0, -20.0, -80.0]))
    return opening, moved(door_leaf(kit, opening[1] - x, opening[3], turn), x, 0, thick * 0.5)


def _window_in_wall(kit: Kit, x: float, wide: float, height: float, thick: float) -> tuple[Opening, Parts]:
    """Opening in a wall, with its window, at times with curtains."""
    opening = (x, x + wide, kit.between(0.4, 1.1), height - kit.between(0.15, 0.5))
    parts = moved(window(kit, wide, opening[3] - opening[2]), x, opening[2], thick * 0.7)
    if kit.chance(0.4):
        for side in (0, 1):
            curtain = hanging(kit, wide * kit.between(0.2, 0.7), opening[3] + 0.05 - kit.between(0.0, 0.8))
            parts.append((curtain.moved(x + side * wide, opening[3] + 0.05, -0.1), kit.materials.cloth()))
    return opening, parts


@one_object
def _hung_picture(kit: Kit, x: float, wide: float, height: float) -> Parts:
    tall = kit.between(0.25, 1.1)
    middle = x + wide / 2, kit.between(1.0, height - tall / 2 - 0.1), -0.012
    frame = box((wide * 0.7, tall, 0.024)).moved(*middle), kit.materials.one_of("wood", "black", "paint")
    canvas = box((wide * 0.7 - 0.05, tall - 0.05, 0.002)).moved(*middle[:2], -0.026), kit.materials.poster()
    return [frame, canvas]


@one_object
def _board(kit: Kit, x: float, wide: float, height: float) -> Parts:
    """Whiteboard, mirror or screen in a frame."""
    tall, wide = kit.between(0.5, 1.2), 0.95 * wide
    middle = x + wide / 2, min(kit.between(1.1, 1.6), height - tall / 2 - 0.05), -0.01
    frame = box((wide, tall, 0.02)).moved(*middle), kit.materials.one_of("metal", "wood", "black")
    face = kit.materials.one_of("paper", "mirror", "screen")
    return [frame, (box((wide - 0.05, tall - 0.05, 0.002)).moved(*middle[:2], -0.021), face)]


def _wall_shelf(kit: Kit, x: float, wide: float, height: float) -> Parts:
    """Board with things on it."""
    y, deep = kit.between(1.1, height - 0.4), kit.between(0.15, 0.3)
    board = standing((wide, 0.02, deep)), kit.materials.one_of("wood", "paint", "black")
    things = laid_out(kit, 0.9 * wide, 0.6 * deep, 0.022, kit.number(2, 9))
    return moved([board, *things], x + wide / 2, y, -deep / 2)


@one_object
def _radiator(kit: Kit, x: float, wide: float, height: float) -> Parts:
    """Ribs between two pipes."""
    tall, pitch = kit.between(0.4, 0.8), kit.between(0.04, 0.08)
    ribs = [standing((0.7 * pitch, tall, 0.08)).moved(x + at, 0.12, -0.08) for at in np.arange(0, wide, pitch)]
    pipes = [bar((x, y, -0.08), (x + wide, y, -0.08), 0.015) for y in (0.15, 0.09 + tall)]
    return [(joined(ribs + pipes), kit.materials.paint())]


@one_object
def _pipes(kit: Kit, x: float, wide: float, height: float) -> Parts:
    """Pipes or cords that run up the wall."""
    thick, parts = kit.between(0.004, 0.04), []
    for at in x + wide * np.sort(kit.rng.uniform(0, 1, kit.number(1, 4))):
        parts.append((bar((at, 0, -0.05), (at, height, -0.05), thick), kit.materials.one_of("paint", "metal", "black")))
    return parts


ON_WALL = (_hung_picture, _hung_picture, _hung_picture, _board, _board, _wall_shelf, _wall_shelf, _radiator, _pipes)
"""What hangs on or stands at a wall, given its left end and its width along the wall and the wall's height [m]."""


def _between_doors(width: float, doors: list[Opening]) -> list[tuple[float, float]]:
    ends = [0.0, *(x for door in sorted(doors) for x in door[:2]), width]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a > 0.02]


@one_object
def window(
    kit: Kit, width: float, height: float, panes: tuple[str, ...] = ("lamp", "outside", "outside", "outside", "black")
) -> Parts:
    """Frame with bars before a bright or dark outside, or before panes of other kinds of material."""
    bars = [standing((0.05, height, 0.05)).moved(x) for x in np.linspace(0.025, width - 0.025, kit.number(2, 4))]
    bars += [standing((width, 0.05, 0.05)).moved(width / 2, y) for y in np.linspace(0, height - 0.05, kit.number(2, 4))]
    outside = box((width, height, 0.005)).moved(width / 2, height / 2, 0.05)
    pane = kit.materials.one_of(*panes)
    return [(joined(bars), kit.materials.paint()), (outside, pane)]


def shell(kit: Kit, width: float, depth: float, height: float, paint: int, make_wall: MakeWall = one_wall) -> Parts:
    """Floor, ceiling (these come first) and four walls of a room, x from -width / 2, z from 0, with the room beyond
    each door."""
    parts: Parts = [(standing((width + 12, 0.1, depth + 12)).moved(0, -0.1, depth / 2), kit.materials.floor())]
    parts.append((standing((width + 12, 0.1, depth + 12)).moved(0, height, depth / 2), kit.materials.ceiling()))
    if kit.chance(0.15):
        slope = box((width + 2, 0.05, depth * 1.2)).turned(rotation(kit.between(25, 55) * kit.rng.choice([-1, 1]), "z"))
        parts.append((slope.moved(kit.rng.choice([-1, 1]) * width * 0.45, height * 0.85, depth / 2), paint))
    for turn, length, x, z in (
        (0, width, -width / 2, depth),
        (90, depth, width / 2, depth),
        (180, width, width / 2, 0),
        (270, depth, -width / 2, 0),
    ):
        wall, doors = make_wall(kit, length, height, paint if kit.chance(0.75) else kit.materials.wall())
        for left, right, _, _ in doors:
            away, wide = kit.between(0.8, 4), kit.between(0.4, 2)
            other = kit.materials.wall()
            back = standing((right - left + 2 * wide, height, 0.1)).moved((left + right) / 2, 0, away)
            # The sides begin within the wall: in its front plane they would show through.
            sides = [
                standing((0.1, height, away - 0.05)).moved(x_, 0, away / 2 + 0.025)
                for x_ in (left - wide, right + wide)
            ]
            wall += [(shape, other) for shape in (back, *sides)]
            if kit.chance(0.5):
                thing = kit.one_of(BY_WALL)(kit)
                wall += moved(thing, (left + right) / 2 + kit.rng.normal(0, 0.3), 0, away - 0.4)
        parts += moved(turned(wall, rotation(turn)), x, 0, z)
    return parts


def backdrop(kit: Kit, low: float, high: float) -> Parts:
    """Floor, and a wall or two at some distance behind the origin, perhaps with furniture."""
    away, height = kit.between(low, high), kit.between(2.3, 3.2)
    paint = kit.materials.wall()
    parts: Parts = [(standing((16, 0.1, 16)).moved(0, -0.1, 0), kit.materials.floor())]
    wall, _ = one_wall(kit, 10, height, paint)
    wall = moved(wall, -5, 0, away)
    ends = [standing((14, height, 0.1)).moved(0, 0, z) for z in (-5, away + kit.between(0.8, 4))]
    ends += [standing((0.1, height, 18)).moved(x, 0, 0) for x in (-kit.between(1.5, 5), kit.between(1.5, 5))]
    other = kit.materials.wall()
    wall += [(end, other) for end in ends]
    wall.append((standing((18, 0.1, 18)).moved(0, height, 0), kit.materials.ceiling()))
    if kit.chance(0.7):
        for _ in range(kit.number(1, 4)):
            thing = kit.one_of(BY_WALL)(kit)
            reach = extent(thing)[1][2]
            wall += moved(thing, kit.between(-3, 3), 0, away - reach - 0.02)
    return parts + turned(wall, rotation(kit.rng.normal(0, 20)))


@one_object
def rug(kit: Kit) -> Parts:
    size = kit.between(0.8, 2.5), 0.012, kit.between(0.8, 2.0)
    if kit.chance(0.3):
        flat = lathe([(size[0] / 2, -0.006), (size[0] / 2, 0.006), (0, 0.006)], 40)
        return [(flat, kit.materials.rug())]
    return turned(carpet(kit, size[0], size[2]), rotation(kit.rng.normal(0, 10)))


@one_object
def carpet(kit: Kit, width: float, depth: float) -> Parts:
    """Rectangular, about the origin, most with a border or two of other colours."""
    parts: Parts = [(box((width, 0.012, depth)), kit.materials.rug())]
    for n in range(1, kit.number(1, 3)):
        inset = 0.1 * n * kit.between(0.6, 1.3)
        middle = painted(width - 2 * inset, depth - 2 * inset).turned(rotation(90, "x"))
        parts.append((middle.moved(inset - width / 2, 0.006 + 0.001 * n, inset - depth / 2), kit.materials.rug()))
    return parts


@one_object
def hanging_lamp(kit: Kit) -> Parts:
    drop, radius = kit.between(0.2, 1.0), kit.between(0.06, 0.25)
    shade = (
        lathe([(radius, -drop), (radius * kit.between(0.2, 0.9), -drop + radius)], 26)
        if kit.chance(0.6)
        else ball((2 * radius,) * 3).moved(y=-drop)
    )
    return [
        (bar((0, 0, 0), (0, -drop + radius, 0), 0.004), kit.materials.black()),
        (shade, kit.materials.lamp(kit.between(1, 4))),
    ]


@one_object
def railing(kit: Kit, length: float, slope: float) -> Parts:
    """Rails along x that rise with a slope, on many thin posts."""
    high, pitch, thin = kit.between(0.8, 1.1), float(kit.rng.choice([0.1, 0.14, 1.0])), kit.between(0.005, 0.015)
    bars = [bar((x, slope * x, 0), (x, slope * x + high, 0), thin) for x in np.arange(0, length, pitch)]
    for y in (0.1, high) if pitch < 0.5 else (0.3, 0.55, high):
        bars.append(bar((0, y, 0), (length, slope * length + y, 0), 2 * thin))
    return [(joined(bars), kit.materials.one_of("metal", "paint", "black", "wood"))]


@one_object
def column(kit: Kit) -> Parts:
    radius, height = kit.between(0.08, 0.4), kit.between(1, 4)
    shaft = (
        lathe([(radius, 0), (radius * 0.9, height), (0, height)], 26)
        if kit.chance(0.6)
        else standing((2 * radius, height, 2 * radius))
    )
    return [(shaft, kit.materials.one_of("street", "wall", "paint", "metal"))]
