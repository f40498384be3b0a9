"""The splat against a loop over points, and the orbit camera."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ilf.drawing.clouds import NEAR, OrbitCamera, Sight, splat

WIDTH, HEIGHT = 24, 18
BACKGROUND = (7, 8, 9)


def draw(points, colours, *look, **named):
    return splat(points, colours, Sight(*look, **named)).picture


def brute_force(points, colours, camera, size):
    """Every point fills its square; a nearer one replaces a farther one."""
    picture = np.full((HEIGHT, WIDTH, 3), BACKGROUND, np.uint8)
    depth = np.full((HEIGHT, WIDTH), np.inf, np.float32)
    matrix = camera.view_matrix().astype(np.float32)
    eyes = points @ matrix[:3, :3].T + matrix[:3, 3]
    for (x, y, z), colour in zip(eyes, colours, strict=True):
        if not z > NEAR:
            continue
        column = math.floor(x * camera.focal(HEIGHT) / z + WIDTH / 2)
        row = math.floor(y * camera.focal(HEIGHT) / z + HEIGHT / 2)
        for v in range(row - (size - 1) // 2, row + size // 2 + 1):
            for u in range(column - (size - 1) // 2, column + size // 2 + 1):
                if 0 <= v < HEIGHT and 0 <= u < WIDTH and z < depth[v, u]:
                    picture[v, u], depth[v, u] = colour, z
    return picture


@given(seed=st.integers(0, 2**32 - 1), size=st.integers(1, 4))
def test_equals_a_loop_over_points(seed, size):
    rng = np.random.default_rng(seed)
    points = rng.uniform((-1, -1, -1), (1, 1, 3), (60, 3)).astype(np.float32)
    colours = rng.integers(0, 256, (60, 3), dtype=np.uint8)
    camera = OrbitCamera((0.1, -0.2, 1.0), 2.0, rng.uniform(-3, 3), rng.uniform(-1.5, 1.5))
    picture = draw(points, colours, camera, WIDTH, HEIGHT, BACKGROUND, size, shaded=False)
    # a product of matrices may round a point across the border of a pixel
    different = (picture != brute_force(points, colours, camera, size)).any(axis=2)
    assert np.count_nonzero(different) <= 2 * size


@pytest.mark.parametrize("size", [1, 3, None])
@pytest.mark.parametrize("order", [1, -1])
def test_the_nearest_point_wins(size, order):
    points = np.array([[0, 0, 1], [0, 0, 2]], np.float32)[::order]
    colours = np.array([[255, 0, 0], [0, 255, 0]], np.uint8)[::order]
    picture = draw(points, colours, OrbitCamera((0, 0, 1.5), 1.5), WIDTH, HEIGHT, BACKGROUND, size, shaded=False)
    assert tuple(picture[HEIGHT // 2, WIDTH // 2]) == (255, 0, 0)


def test_points_that_cannot_be_seen_leave_the_background():
    points = np.array([[0, 0, -5], [np.nan, 0, 1], [0, np.inf, 1], [0, 0, np.nan], [1e9, 0, 1]], np.float32)
    picture = draw(points, np.full((5, 3), 255, np.uint8), OrbitCamera(), WIDTH, HEIGHT, BACKGROUND)
    assert (picture == BACKGROUND).all()
    nothing = draw(points[:0], np.empty((0, 3), np.uint8), OrbitCamera(), WIDTH, HEIGHT, BACKGROUND)
    assert (nothing == BACKGROUND).all()


def wall(step=0.01, depth=2.0):
    x, y = np.meshgrid(np.arange(-1, 1, step, np.float32), np.arange(-1, 1, step, np.float32))
    return np.stack([x, y, np.full_like(x, depth)], axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("distance", [2.0, 1.0, 0.5])
def test_automatic_size_closes_a_surface_seen_from_near(distance):
    points = wall()
    picture = draw(points, np.full(points.shape, 200, np.uint8), OrbitCamera((0, 0, 2), distance), 320, 240, BACKGROUND)
    assert (picture[20:-20, 60:-60] != BACKGROUND).all()


def test_single_gaps_of_a_surface_are_closed_and_its_outline_stays():
    camera = OrbitCamera((0, 0, 2), 2.0)
    points = wall(0.02)
    points = points[(np.abs(points[:, :2]) < 0.4).all(axis=1)]
    look = Sight(camera, 60, 60)
    whole = splat(points, np.full(points.shape, 200, np.uint8), look, spacing=1e-6).nearest >= 0
    assert whole[20:40, 20:40].all()
    some = points[np.hypot(points[:, 0], points[:, 1]) > 0.03]
    closed = splat(some, np.full(some.shape, 200, np.uint8), look, spacing=1e-6).nearest
    gaping = splat(some, np.full(some.shape, 200, np.uint8), replace(look, point_size=1)).nearest
    assert (gaping[20:40, 20:40] < 0).any()
    assert (closed[20:40, 20:40] >= 0).all()
    changed = closed != gaping
    assert (np.abs(np.argwhere(changed) - 30) < 3).all(), "nothing but the gap in the middle"
    assert (np.abs(some[closed[changed], :2]) < 0.1).all(), "by points beside it"


def test_automatic_size_keeps_near_and_far_points_in_the_right_order():
    back, front = wall(depth=3.0), wall(depth=2.0)[::7] * np.float32(0.3)
    points = np.concatenate([back, front])
    colours = np.repeat(np.array([[0, 0, 250], [250, 0, 0]], np.uint8), [len(back), len(front)], axis=0)
    picture = draw(points, colours, OrbitCamera((0, 0, 2.0), 2.0), 320, 240, BACKGROUND, shaded=False)
    assert set(np.unique(picture[80:160, 120:200].reshape(-1, 3), axis=0)[:, 0]) == {0, 250}
    only_front = draw(points[-len(front) :], colours[-len(front) :], OrbitCamera((0, 0, 2.0), 2.0), 320, 240)
    assert (picture[..., 0] > 0).sum() > 0
    assert only_front[..., 2].max() == 0


def test_shading_darkens_behind_an_edge_and_nothing_on_a_wall():
    points = wall()
    colours = np.full(points.shape, 200, np.uint8)
    camera = OrbitCamera((0, 0, 2), 2.0)
    assert (draw(points, colours, camera, 200, 200, (200, 200, 200)) == 200).all()
    stepped = points.copy()
    stepped[:, 2] += np.where(points[:, 0] > 0, np.float32(0.5), np.float32(0))
    picture = draw(stepped, colours, camera, 200, 200, BACKGROUND)
    assert picture[100, 40, 0] == 200
    assert picture[100, 90:110, 0].min() < 150


def test_the_point_at_each_pixel_is_told_and_depths_clip():
    points = np.array([[0, 0, 1], [0, 0, 2]], np.float32)
    colours = np.array([[255, 0, 0], [0, 255, 0]], np.uint8)
    look = Sight(OrbitCamera((0, 0, 1.5), 1.5), WIDTH, HEIGHT, BACKGROUND, 3, shaded=False)
    drawn = splat(points, colours, look)
    assert drawn.nearest[HEIGHT // 2, WIDTH // 2] == 0
    assert ((drawn.nearest == -1) == (drawn.picture == BACKGROUND).all(axis=2)).all()
    assert np.count_nonzero(drawn.nearest == 0) == 9
    behind = splat(points, colours, replace(look, depths=(1.5, 3)))
    assert behind.nearest[HEIGHT // 2, WIDTH // 2] == 1
    assert tuple(behind.picture[HEIGHT // 2, WIDTH // 2]) == (0, 255, 0)
    assert (splat(points, colours, replace(look, depths=(3, 4))).nearest == -1).all()


def test_projected_points_lie_where_they_are_drawn():
    points = np.random.default_rng(2).uniform((-1, -1, 1), (1, 1, 3), (40, 3)).astype(np.float32)
    camera = OrbitCamera((0.1, -0.2, 2.0), 3.0, 0.5, 0.3)
    nearest = splat(points, np.zeros((40, 3), np.uint8), Sight(camera, 200, 150, point_size=1, shaded=False)).nearest
    places = camera.project(points, 200, 150)
    rows, columns = np.nonzero(nearest >= 0)
    np.testing.assert_allclose(places[nearest[rows, columns], :2], np.column_stack([columns, rows]) + 0.5, atol=0.51)
    beside = camera.project(np.array([camera.target, camera.target + camera.rotation()[0]]), 200, 150)
    np.testing.assert_allclose(beside[1, 0] - beside[0, 0], 1 / camera.metres_per_pixel(150))
