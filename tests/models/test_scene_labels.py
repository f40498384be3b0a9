"""Labels of exact depth against scenes whose jumps and creases are known."""

import numpy as np
import pytest
from scenes.labels import label

K = (300.0, 300.0, 159.5, 127.5)
SHAPE = (256, 320)
ROWS, COLUMNS = np.indices(SHAPE)
RAYS = np.stack([(COLUMNS - K[2]) / K[0], (ROWS - K[3]) / K[1], np.ones(SHAPE)], axis=-1)


def plane(normal: tuple[float, ...], distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Depth of n . x = -distance, infinite where no ray meets it, and its normal everywhere."""
    unit = np.array(normal) / np.linalg.norm(normal)
    along = RAYS @ unit
    depth = np.divide(-distance, along, out=np.full(SHAPE, np.inf), where=along < 0)
    return depth, np.broadcast_to(unit, (*SHAPE, 3))


def nearest(*surfaces: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is seen of several surfaces: depth, normals and which one."""
    part = np.argmin([depth for depth, _ in surfaces], axis=0)
    depth = np.min([depth for depth, _ in surfaces], axis=0)
    normals = np.choose(part[..., None], [normals for _, normals in surfaces])
    return np.where(np.isfinite(depth), depth, np.nan), normals, part


def cylinder(x: float, z: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """An upright cylinder."""
    across = RAYS[..., 0]
    a, b, c = across**2 + 1, across * x + z, x**2 + z**2 - radius**2
    under = b**2 - a * c
    depth = np.where(under > 0, (b - np.sqrt(np.maximum(under, 0))) / a, np.inf)
    met = np.where(under > 0, depth, 1.0)
    normal = np.stack([met * across - x, np.zeros(SHAPE), met - z], axis=-1) / radius
    return depth, normal


@pytest.mark.parametrize("facing", [1, -1])
def test_a_floor_never_jumps_and_the_foot_of_a_wall_is_a_crease(facing):
    floor, wall = plane((0, -1, 0), 1.2), plane((0, 0, -1), 9.0)
    depth, normals, part = nearest(floor, wall)
    assert np.abs(np.diff(depth, axis=0)).max() > 0.2
    jump, crease = label(depth, facing * normals, part, K)
    assert not jump.any()
    foot = int(np.argmax(part[:, 0] == 0)) - 1
    assert crease[foot].all()
    assert crease.sum() == SHAPE[1]


def test_a_cylinder_jumps_at_its_rim_and_is_smooth_within():
    depth, normals, part = nearest(plane((0, 0, -1), 3.0), cylinder(0.1, 2.0, 0.4))
    jump, crease = label(depth, normals, part, K)
    rim = (part[:, :-1] != part[:, 1:]).nonzero()
    assert jump[rim].all()
    assert jump.sum() == rim[0].size == 2 * SHAPE[0]
    assert not crease.any()


@pytest.mark.parametrize(("gap", "jumps"), [(0.03, True), (0.012, False)])
def test_a_step_counts_from_two_centimetres_on(gap, jumps):
    depth = np.where(COLUMNS < 160, 0.8, 0.8 + gap)
    normals = np.broadcast_to([0.0, 0.0, -1.0], (*SHAPE, 3))
    jump, crease = label(depth, normals, (COLUMNS < 160).astype(np.int32), K)
    assert jump.sum() == SHAPE[0] * jumps
    assert jump[:, 159].all() == jumps
    assert not crease.any()
