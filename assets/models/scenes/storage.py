"""Tables, cupboards and shelves, full of things; they stand on the floor about the origin, front towards -z."""

from __future__ import annotations

from .containers import bag, carton, open_box
from .devices import monitor
from .parts import Ground, Kit, Parts, Thing, moved, one_object, set_down, turned
from .shapes import bar, beam, box, joined, lathe, rotation, standing
from .small_things import SMALL
from .solids import fruit


def laid_out(kit: Kit, width: float, depth: float, y: float, count: int, things: tuple[Thing, ...] = SMALL) -> Parts:
    """Things on a horizontal rectangle about the origin."""
    ground, parts = Ground(kit, (-width / 2, width / 2), (-depth / 2, depth / 2), y), []
    for _ in range(count):
        parts += ground.put(turned(kit.one_of(things)(kit), rotation(kit.between(0, 360) if kit.chance(0.3) else 0)))
    return parts


@one_object
def table(kit: Kit) -> Parts:
    width, depth = kit.between(0.5, 2.0), kit.between(0.4, 1.0)
    height, thick = (
        kit.rng.choice([kit.between(0.3, 0.5), kit.between(0.68, 0.8), kit.between(0.68, 0.8)]),
        kit.between(0.015, 0.06),
    )
    top_of, legs_of = (
        kit.materials.one_of("wood", "wood", "paint", "glaze", "black", "glass", "anything"),
        kit.materials.one_of("wood", "metal", "paint", "black"),
    )
    round_one = kit.chance(0.25)
    if round_one:
        radius = depth / 2 + 0.1
        top = lathe([(0, height - thick), (radius, height - thick), (radius, height), (0, height)], 40)
        width = depth = radius * 1.3
    else:
        top = standing((width, thick, depth)).moved(y=height - thick)
    if round_one and kit.chance(0.5):
        legs = [bar((0, 0, 0), (0, height - thick, 0), 0.04), lathe([(0, 0), (0.25, 0), (0.25, 0.02), (0, 0.03)], 30)]
    else:
        inset, thickness, splay = kit.between(0.02, 0.1), kit.between(0.015, 0.035), kit.between(0.7, 1.0)
        square = kit.chance(0.5)
        legs = []
        for x in (-1, 1):
            for z in (-1, 1):
                foot, head = (
                    (x * (width / 2 - inset), 0, z * (depth / 2 - inset)),
                    (x * (width / 2 - inset) * splay, height - thick, z * (depth / 2 - inset) * splay),
                )
                legs.append(beam(foot, head, 2 * thickness, 2 * thickness) if square else bar(foot, head, thickness))
        if kit.chance(0.4):
            legs.append(standing((width - 2 * inset, 0.08, depth - 2 * inset)).moved(y=height - thick - 0.08))
    parts: Parts = [(top, top_of), (joined(legs), legs_of)]
    if kit.chance(0.12):
        drop = kit.between(0.1, 0.4)
        parts.append(
            (standing((width * 1.01, drop, depth * 1.01)).moved(y=height - drop + 0.002), kit.materials.cloth())
        )
    return parts + laid_out(kit, width * 0.9, depth * 0.85, height + 0.002, kit.number(0, 12))


@one_object
def desk(kit: Kit) -> Parts:
    width, depth, height = kit.between(1.0, 1.8), kit.between(0.5, 0.8), kit.between(0.7, 0.78)
    wood, other = kit.materials.one_of("wood", "paint", "black"), kit.materials.one_of("wood", "paint", "metal")
    parts: Parts = [(standing((width, 0.03, depth)).moved(y=height - 0.03), wood)]
    for side in (-1, 1):
        if kit.chance(0.5):
            parts.append((standing((0.03, height - 0.03, depth)).moved(x=side * (width / 2 - 0.02)), other))
        else:
            parts += moved(cupboard_of(kit, 0.4, height - 0.03, depth - 0.05), x=side * (width / 2 - 0.2))
    if kit.chance(0.7):
        parts += moved(monitor(kit), kit.between(-0.3, 0.3), height, depth * 0.2)
    return parts + laid_out(kit, width * 0.9, depth * 0.8, height, kit.number(2, 10))


@one_object
def cupboard_of(kit: Kit, width: float, height: float, depth: float) -> Parts:
    """Closed box with doors or drawers and their knobs."""
    body, front = (
        kit.materials.one_of("wood", "paint", "paint", "metal", "anything"),
        kit.materials.one_of("wood", "paint", "paint", "black"),
    )
    columns, rows = max(1, round(width / kit.between(0.35, 0.7))), max(1, round(height / kit.between(0.2, 1.2)))
    gap, thick = kit.between(0.002, 0.012), kit.between(0.004, 0.02)
    doors, knobs = [], []
    for i in range(columns):
        for j in range(rows):
            x, y = (i + 0.5) * width / columns - width / 2, (j + 0.5) * height / rows
            doors.append(box((width / columns - gap, height / rows - gap, thick)).moved(x, y, -(depth + thick) / 2))
            knobs.append(box((kit.rng.choice([0.02, 0.12]), 0.015, 0.025)).moved(x, y, -depth / 2 - thick - 0.012))
    return [(standing((width, height, depth)), body), (joined(doors), front), (joined(knobs), kit.materials.metal())]


def cupboard(kit: Kit) -> Parts:
    width, height, depth = kit.between(0.4, 2.2), kit.between(0.4, 2.2), kit.between(0.3, 0.65)
    parts = cupboard_of(kit, width, height, depth)
    if height < 1.5:
        parts += laid_out(kit, width * 0.9, depth * 0.7, height, kit.number(0, 6))
    return parts


def shelf(kit: Kit) -> Parts:
    """Open boards full of things, with or without a back."""
    width, height, depth = kit.between(0.5, 2.0), kit.between(0.6, 2.2), kit.between(0.2, 0.4)
    return shelf_of(kit, width, height, depth)


@one_object
def shelf_of(kit: Kit, width: float, height: float, depth: float) -> Parts:
    wood, thick = kit.materials.one_of("wood", "paint", "metal", "black"), kit.between(0.01, 0.035)
    boards = [standing((thick, height, depth)).moved(x=s * width / 2) for s in (-1, 1)]
    parts: Parts = []
    y, fullness = 0.04, kit.number(0, 9)
    while y < height - 0.1:
        boards.append(standing((width, thick, depth)).moved(y=y))
        room = kit.between(0.2, 0.45)
        on_it = laid_out(kit, width * 0.9, depth * 0.4, y + thick, fullness)
        parts += [(shape, m) for shape, m in on_it if shape.high[1] < y + room]
        y += room
    boards.append(standing((width, thick, depth)).moved(y=height))
    if kit.chance(0.6):
        parts.append(
            (standing((width, height, 0.008)).moved(z=depth / 2), kit.materials.one_of("wood", "paint", "wall"))
        )
    return [(joined(boards), wood), *parts]


def box_pile(kit: Kit) -> Parts:
    """Removal boxes and crates, one on another."""
    parts: Parts = []
    for x in range(kit.number(1, 3)):
        y = 0.0
        for _ in range(kit.number(1, 4)):
            size = kit.rng.uniform(0.2, 0.6, 3)
            parts.append(
                (
                    standing(size)
                    .turned(rotation(kit.rng.normal(0, 12)))
                    .moved(x * 0.5 + kit.rng.normal(0, 0.04), y, kit.rng.normal(0, 0.04)),
                    kit.materials.one_of("pack", "wood", "paint"),
                )
            )
            y += size[1]
    return parts


@one_object
def tub(kit: Kit) -> Parts:
    """Open crate on the floor with things in it."""
    width, depth, height = kit.between(0.3, 0.7), kit.between(0.3, 0.6), kit.between(0.2, 0.5)
    parts = open_box(width, depth, height, 0.012, kit.materials.one_of("plastic", "wood", "metal", "paint"))
    return parts + laid_out(kit, width * 0.5, depth * 0.5, 0.02, kit.number(1, 6), (carton, bag, fruit))


@one_object
def bin_(kit: Kit) -> Parts:
    radius, height = kit.between(0.1, 0.2), kit.between(0.2, 0.5)
    shell = lathe(
        [(0, 0.005), (radius * 0.8, 0), (radius, height), (radius - 0.006, height), (radius * 0.79, 0.01), (0, 0.01)],
        26,
    )
    return [
        (shell, kit.materials.one_of("plastic", "metal", "black", "paint")),
        *moved(set_down(bag(kit)), y=height * 0.4),
    ]
