"""The sample room: shell, furniture and lamps in their places, and the camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import furniture as fu
from . import textures as tx
from .furniture import Parts, matt, placed
from .light import Area, Bulb, Light, Spot, Sun
from .meshes import Mesh, box, joined, tube
from .scene import Material, Scene

LEFT, RIGHT, BACK, BEHIND, CEILING = -1.75, 1.85, 3.7, -1.0, 2.55
HALL_END, HALL_LEFT, HALL_RIGHT = 5.0, -0.5, 2.6
DOOR = (0.22, 1.00, 2.03)
"""Left edge, right edge and height of the doorway in the back wall [m]."""
WINDOW = (0.95, 2.45, 0.80, 2.15)
"""Near edge, far edge, sill and head of the window in the left wall [m]."""
SPOT = np.array([-0.16, 1.33, BACK])
"""Where the halogen lamp shines on the back wall [m]."""
SPOT_RADIUS = 0.075
SKY = np.array([6.6, 7.4, 8.4])
"""Radiance behind the window."""


@dataclass(frozen=True)
class Camera:
    """Pinhole camera. `right`, `down`, `forward` are its axes in the world."""

    position: np.ndarray
    right: np.ndarray
    down: np.ndarray
    forward: np.ndarray

    def directions(self, columns: np.ndarray, rows: np.ndarray, intrinsics: tuple[float, ...]) -> np.ndarray:
        """Rays through pixels, (N, 3), scaled so that a hit at distance t has depth t."""
        fx, fy, cx, cy = intrinsics
        x, y = (columns - cx) / fx, (rows - cy) / fy
        return self.forward + x[:, None] * self.right + y[:, None] * self.down


@dataclass(frozen=True)
class Room:
    scene: Scene
    lights: list[Light]
    sky: np.ndarray
    camera: Camera


def camera() -> Camera:
    """At eye height, tilted down by 12 degrees and turned 2 degrees to the left."""
    tilt, turn = np.radians(12.0), np.radians(-2.0)
    forward = np.array([np.sin(turn) * np.cos(tilt), -np.sin(tilt), np.cos(turn) * np.cos(tilt)])
    right = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    return Camera(np.array([0.08, 1.5, 0.0]), right, np.cross(right, forward), forward)


def build(seed: int, more: Parts = ()) -> Room:
    """The room with its lights, and more parts; the seed varies books, leaves and flowers."""
    rng = np.random.default_rng([seed, 1])
    parts = _shell()
    parts += placed(fu.desk(1.40, 0.66, 0.74), -1.03, 0, BACK - 0.35)
    parts += placed(fu.monitor(), -1.03, 0.74, BACK - 0.20, 4)
    parts += placed(fu.keyboard(), -1.03, 0.74, BACK - 0.50, 2)
    parts += placed(fu.mouse(), -0.74, 0.74, BACK - 0.49, -8)
    parts += placed(fu.standing_books(6, rng), -1.68, 0.74, BACK - 0.13)
    parts += placed(fu.mug("#c8553d"), -0.58, 0.74, BACK - 0.42, -40)
    lamp_at = np.array([-0.45, 0.74, BACK - 0.16])
    lamp, halogen = fu.desk_lamp(SPOT - lamp_at)
    parts += placed(lamp, *lamp_at)
    parts += placed(fu.picture(0.86, 0.56), -1.03, 1.62, BACK)
    parts += placed(fu.chair("#c39550"), -0.74, 0, 2.68, 14)
    parts += placed(fu.plant(rng), -0.13, 0, BACK - 0.27)
    parts += placed(fu.sofa(1.50, "#5f8798", ("#d8a24a", "#e5dccb")), RIGHT - 0.45, 0, 2.62, 90)
    standing, bulb = fu.floor_lamp(1.52)
    lamp_foot = np.array([RIGHT - 0.33, 0.0, BACK - 0.27])
    parts += placed(standing, *lamp_foot)
    parts += placed(fu.round_table(0.33, 0.42), 0.07, 0.012, 2.27)
    parts += placed(fu.vase_with_tulips(rng), 0.15, 0.432, 2.39)
    parts += placed(fu.lying_books(2, rng), -0.10, 0.432, 2.28, 12)
    parts += placed(fu.bowl_of_oranges(), 0.19, 0.432, 2.13)
    return Room(Scene([*parts, *more]), _lights(halogen + lamp_at, bulb + lamp_foot), SKY, camera())


def _lights(halogen: np.ndarray, bulb: np.ndarray) -> list[Light]:
    near, far, sill, head = WINDOW
    return [
        Area(
            corner=np.array([LEFT - 0.16, sill, near]),
            edges=(np.array([0.0, head - sill, 0.0]), np.array([0.0, 0.0, far - near])),
            radiance=SKY,
            normal=np.array([1.0, 0.0, 0.0]),
            samples=8,
        ),
        Sun(towards=np.array([-0.80, 0.62, -0.34]), radiance=np.array([15.5, 12.8, 9.4]), spread=0.012, samples=4),
        Area(
            corner=np.array([-0.5, CEILING - 0.02, 0.2]),
            edges=(np.array([1.2, 0.0, 0.0]), np.array([0.0, 0.0, 1.2])),
            radiance=np.array([5.0, 4.6, 4.0]),
            normal=np.array([0.0, -1.0, 0.0]),
            samples=5,
        ),
        Area(
            corner=np.array([0.3, 2.5, BACK + 0.4]),
            edges=(np.array([0.9, 0.0, 0.0]), np.array([0.0, 0.0, 0.6])),
            radiance=np.array([8.0, 7.0, 5.6]),
            normal=np.array([0.0, -1.0, 0.0]),
            samples=3,
        ),
        Bulb(position=bulb, radius=0.03, intensity=np.array([0.85, 0.62, 0.36]), samples=3),
        Spot(
            position=halogen,
            target=SPOT,
            radius=0.012,
            cone=SPOT_RADIUS,
            intensity=np.array([5.5, 4.7, 3.4]),
            samples=3,
        ),
    ]


def _shell() -> Parts:
    paint_back = matt("#a9b8a8", tx.plaster("#a9b8a8"))
    paint_side = matt("#e8e0d0", tx.plaster("#e8e0d0"))
    paint_hall = matt("#e3cfb0", tx.plaster("#e3cfb0"))
    trim = matt("#f1efe9", gloss=0.03, roughness=0.08)
    boards = Material(tx.linear("#a97c50"), tx.planks, gloss=0.06, roughness=0.03, floor=True)
    door_left, door_right, door_head = DOOR
    near, far, sill, head = WINDOW
    floor = _slab((HALL_LEFT - 2, -0.1, BEHIND), (HALL_RIGHT + 1, 0.0, HALL_END))
    ceiling = _slab((LEFT, CEILING, BEHIND), (HALL_RIGHT, CEILING + 0.1, HALL_END))
    back = [
        _slab((LEFT, 0, BACK), (door_left, CEILING, BACK + 0.12)),
        _slab((door_right, 0, BACK), (RIGHT, CEILING, BACK + 0.12)),
        _slab((door_left, door_head, BACK), (door_right, CEILING, BACK + 0.12)),
    ]
    left = [
        _slab((LEFT - 0.14, 0, BEHIND), (LEFT, CEILING, near)),
        _slab((LEFT - 0.14, 0, far), (LEFT, CEILING, BACK + 0.1)),
        _slab((LEFT - 0.14, 0, near), (LEFT, sill, far)),
        _slab((LEFT - 0.14, head, near), (LEFT, CEILING, far)),
    ]
    sides = [
        *left,
        _slab((RIGHT, 0, BEHIND), (RIGHT + 0.1, CEILING, BACK + 0.1)),
        _slab((LEFT, 0, BEHIND - 0.1), (RIGHT, CEILING, BEHIND)),
    ]
    hall = [
        _slab((HALL_LEFT, 0, HALL_END), (HALL_RIGHT, CEILING, HALL_END + 0.1)),
        _slab((HALL_LEFT - 0.1, 0, BACK + 0.05), (HALL_LEFT, CEILING, HALL_END)),
        _slab((HALL_RIGHT, 0, BACK + 0.05), (HALL_RIGHT + 0.1, CEILING, HALL_END)),
    ]
    return [
        (floor, boards),
        (ceiling, matt("#f2f0ea")),
        (joined(back), paint_back),
        (joined(sides), paint_side),
        (joined(hall), paint_hall),
        (joined([*_skirting(), *_door_frame(), *_window_frame()]), trim),
        *_door_leaf(trim),
        *_rug(),
        *_switch(trim),
    ]


def _slab(low: tuple[float, float, float], high: tuple[float, float, float], bevel: float = 0.0) -> Mesh:
    low_corner, high_corner = np.array(low), np.array(high)
    block = box(high_corner - low_corner, bevel).moved(*((low_corner + high_corner) / 2))
    return Mesh(block.vertices, block.triangles, block.vertices.copy())


def _skirting() -> list[Mesh]:
    height, deep = 0.11, 0.016
    left, right, _ = DOOR
    return [
        _slab((LEFT, 0, BACK - deep), (left - 0.07, height, BACK), 0.005),
        _slab((right + 0.07, 0, BACK - deep), (RIGHT, height, BACK), 0.005),
        _slab((LEFT, 0, BEHIND), (LEFT + deep, height, BACK), 0.005),
        _slab((RIGHT - deep, 0, BEHIND), (RIGHT, height, BACK), 0.005),
        _slab((HALL_LEFT, 0, HALL_END - deep), (HALL_RIGHT, height, HALL_END), 0.005),
    ]


def _door_frame() -> list[Mesh]:
    left, right, head = DOOR
    return [
        _slab((left - 0.075, 0, BACK - 0.02), (left, head + 0.075, BACK + 0.14), 0.006),
        _slab((right, 0, BACK - 0.02), (right + 0.075, head + 0.075, BACK + 0.14), 0.006),
        _slab((left - 0.075, head, BACK - 0.02), (right + 0.075, head + 0.075, BACK + 0.14), 0.006),
    ]


def _door_leaf(paint: Material) -> Parts:
    """Open panel door, hinged on the right and swung into the hall."""
    _, right, head = DOOR
    width = 0.76
    leaf = [box((width, head - 0.02, 0.035), 0.004).moved(x=-width / 2, y=head / 2)]
    for low, high in ((0.16, 0.84), (0.98, head - 0.14)):
        for y in (low, high):
            leaf.append(box((width - 0.22, 0.02, 0.05), 0.006).moved(x=-width / 2, y=y))
        for x in (-0.11, 0.11 - width):
            leaf.append(box((0.02, high - low, 0.05), 0.006).moved(x=x, y=(low + high) / 2))
    handle = tube([(0.07 - width, 0.92, -0.02), (0.07 - width, 0.92, -0.06), (0.18 - width, 0.92, -0.06)], 0.008)
    return placed([(joined(leaf), paint), (handle, fu.BRASS)], right - 0.01, 0.01, BACK + 0.14, 68)


def _window_frame() -> list[Mesh]:
    near, far, sill, head = WINDOW
    x = (LEFT - 0.11, LEFT - 0.05)
    bars = [_slab((x[0], sill, z - 0.03), (x[1], head, z + 0.03)) for z in (near, (near + far) / 2, far)]
    bars += [_slab((x[0], y - 0.03, near), (x[1], y + 0.03, far)) for y in (sill, 1.68, head)]
    return [*bars, _slab((LEFT - 0.1, sill - 0.04, near - 0.06), (LEFT + 0.10, sill, far + 0.06), 0.008)]


def _rug() -> Parts:
    half_x, half_z = 0.90, 0.52
    mat = box((2 * half_x, 0.012, 2 * half_z), 0.005).moved(y=0.006)
    return placed([(mat, matt("#c9a78c", tx.rug(half_x, half_z)))], 0.10, 0.0, 2.20, -3)


def _switch(paint: Material) -> Parts:
    plate = box((0.08, 0.08, 0.010), 0.004).moved(0.085, 1.08, BACK - 0.005)
    rocker = box((0.045, 0.055, 0.010), 0.003).moved(0.085, 1.08, BACK - 0.010)
    return [(joined([plate, rocker]), paint)]
