"""What depth says of the surface: where it goes on, its triangles and normals, and what hangs in mid-air."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ilf.data import surface
from ilf.data.camera import Camera
from ilf.data.flying_points import flying_points
from ilf.data.points import PointCloud, point_cloud
from ilf.data.surface import surface_links, surface_mesh, surface_normals
from ilf.errors import InputError

CAMERA = Camera(fx=500.0, fy=480.0, cx=30.0, cy=20.0)
SHAPE = (40, 60)
ROWS, COLUMNS = np.indices(SHAPE)


def plane(normal, distance, shape=SHAPE, camera=CAMERA):
    """Depth of the plane normal . P = distance."""
    rows, columns = np.indices(shape)
    sight = np.stack([(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones(shape)], -1)
    return (distance / (sight @ np.asarray(normal, float))).astype(np.float32)


def grey(shape=SHAPE):
    return np.full((*shape, 3), 128, np.uint8)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0, 0.8), (0, -0.95, 0.31), (0.5, 0.5, 0.7)])
def test_a_plane_is_one_surface_with_one_normal_towards_the_camera(normal):
    normal = np.asarray(normal) / np.linalg.norm(normal)
    depth = plane(normal, 2.0)
    assert all(links.all() for links in surface_links(depth, CAMERA))
    found = surface_normals(depth, CAMERA)
    np.testing.assert_allclose(found, np.broadcast_to(-normal, found.shape), atol=2e-3)
    assert not flying_points(depth, CAMERA).any()
    mesh = surface_mesh(depth, grey(), CAMERA)
    assert len(mesh) == 2 * (SHAPE[0] - 1) * (SHAPE[1] - 1)
    assert len(mesh.vertices) == depth.size


def test_a_floor_far_away_goes_on_though_it_is_seen_at_a_grazing_angle():
    camera = Camera(500.0, 500.0, 30.0, -10.0)
    depth = plane((0, 1, 0), 1.0, camera=camera)  # 1 m below the camera
    steepest = np.arctan(depth[0, 0] / 1.0)
    assert np.degrees(steepest) > 88
    assert surface_links(depth, camera)[1][2:].all()


def test_the_surface_is_cut_at_a_jump_and_nowhere_else():
    depth = np.where(COLUMNS < 25, 1.0, 1.5).astype(np.float32)
    depth[10, 10] = np.nan
    right, _ = surface_links(depth, CAMERA)
    assert not right[:, 24].any()
    assert np.delete(right, 24, axis=1).sum() == SHAPE[0] * (SHAPE[1] - 2) - 2
    mesh = surface_mesh(depth, grey(), CAMERA)
    z = mesh.vertices.points[mesh.faces][:, :, 2]
    assert (np.ptp(z, axis=1) == 0).all()
    assert len(mesh) == 2 * 39 * (24 + 34) - 4  # each of the four squares around the hole has one triangle left
    normals = surface_normals(depth, CAMERA)
    np.testing.assert_allclose(normals, np.broadcast_to((0, 0, -1), normals.shape), atol=1e-6)


def test_small_steps_within_noise_are_no_jump_and_the_same_step_nearer_is_one():
    for away, linked in ((4.0, True), (0.5, False)):
        depth = np.where(COLUMNS % 2 == 0, away, away + 0.06).astype(np.float32)
        assert surface_links(depth, CAMERA)[0].all() == linked


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.1, 0.5]), st.sampled_from([0.002, 0.05, 1.0]))
def test_whatever_the_depth_the_mesh_is_sound(seed, missing, noise):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(1, 12, 2))
    depth = (2 + noise * rng.random(shape)).astype(np.float32)
    depth[rng.random(shape) < missing] = rng.choice([np.nan, np.inf, 0.0, -1.0, 1e-40, 3e38])
    mesh = surface_mesh(depth, grey(shape), CAMERA)
    points, faces = mesh.vertices.points.astype(float), mesh.faces
    assert np.array_equal(np.unique(faces), np.arange(len(points)))  # no vertex without a triangle
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", across, corners[:, 0]) < 0).all()  # all face the camera
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(sides, axis=0)) == len(sides)  # none overlap: a side is gone along once in each direction
    normals = surface_normals(depth, CAMERA)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1, atol=1e-5)
    cloud = point_cloud(depth, grey(shape), CAMERA, normals=normals)
    assert (np.einsum("ij,ij->i", cloud.normals, cloud.points) < 0).all()
    assert not flying_points(depth, CAMERA)[~np.isfinite(depth)].any()


def test_noise_is_averaged_on_the_surface_and_not_across_its_jumps():
    rng = np.random.default_rng(2)
    left, right = plane((0.5, 0, 0.87), 1.0), plane((-0.5, 0, 0.87), 2.0)
    depth = np.where(COLUMNS < 30, left, right) + rng.normal(0, 0.0005, SHAPE).astype(np.float32)
    assert not surface_links(depth, CAMERA)[0][:, 29].any()
    found = surface_normals(depth, CAMERA)
    angle = [
        np.degrees(np.arccos(np.clip(found[:, part] @ (-x, 0, -0.867), -1, 1)))
        for part, x in ((slice(0, 30), 0.498), (slice(30, 60), -0.498))
    ]
    assert max(a.mean() for a in angle) < 4
    assert max(angle[0][:, -1].mean(), angle[1][:, 0].mean()) < 8


def test_points_in_mid_air_are_found_and_thin_things_are_not():
    depth = np.full(SHAPE, 2.0, np.float32)
    depth[:, 20:30] = 1.0
    depth[:, 19], depth[:, 30] = 1.4, np.linspace(1.2, 1.8, SHAPE[0])  # between the two, left and right
    depth[:, 45] = 1.5  # a pole in front of the wall
    depth[8:10, 52:54] = 1.0  # a speck
    expected = np.zeros(SHAPE, bool)
    expected[:, [19, 30]] = True
    expected[8:10, 52:54] = True
    np.testing.assert_array_equal(flying_points(depth, CAMERA), expected)
    assert flying_points(depth[:, ::-1], CAMERA).sum() == expected.sum()
    np.testing.assert_array_equal(flying_points(depth.T, CAMERA), expected.T)


def test_sparse_depth_does_not_fly():
    depth = np.full(SHAPE, np.nan, np.float32)
    depth[::3, ::3] = np.random.default_rng(0).uniform(1, 4, depth[::3, ::3].shape)
    assert not flying_points(depth, CAMERA).any()


def test_what_is_known_of_pixels_goes_with_their_points():
    depth = np.array([[1.0, np.nan, 1.0], [1.0, 1.0, 1.0]], np.float32)
    numbers, only = np.arange(6).reshape(2, 3), np.array([[1, 1, 0], [1, 1, 1]], bool)
    cloud = point_cloud(depth, grey((2, 3)), CAMERA, only=only, scalars={"block": numbers})
    assert cloud.scalars["block"].tolist() == [0, 3, 4, 5]
    mesh = surface_mesh(depth, grey((2, 3)), CAMERA, only=only, scalars={"block": numbers})
    assert mesh.vertices.scalars["block"].tolist() == [0, 3, 4]
    assert mesh.faces.tolist() == [[1, 2, 0]]


def test_the_expected_error_of_measured_depth_is_0():
    error = np.array([[0.1, np.nan], [0.3, np.nan]], np.float32)
    cloud = point_cloud(np.ones((2, 2)), grey((2, 2)), CAMERA, scalars={"expected_error": error})
    np.testing.assert_array_equal(cloud.scalars["expected_error"], np.float32([0.1, 0, 0.3, 0]))
    assert np.isnan(error[0, 1])
    with pytest.raises(InputError, match="other of a cloud must be finite"):
        point_cloud(np.ones((2, 2)), grey((2, 2)), CAMERA, scalars={"other": error})


def test_clouds_hold_nothing_that_is_not_finite_or_does_not_fit():
    points, colours = np.ones((2, 3), np.float32), np.zeros((2, 3), np.uint8)
    bad = points.copy()
    bad[1, 2] = np.nan
    for arguments, message in (
        ((bad, colours), "points of a cloud must be finite"),
        ((points, colours, bad), "normals of a cloud must be finite"),
        ((points, colours, points[:1]), "normals must have shape"),
        ((points, colours, None, {"error": bad[:, 2]}), "error of a cloud must be finite"),
        ((points, colours, None, {"error": np.ones(3)}), r"error must have shape \(2,\)"),
        ((points, colours, None, {"an error": np.ones(2)}), "letters, digits and underscores"),
    ):
        with pytest.raises(InputError, match=message):
            PointCloud(*arguments)
    with pytest.raises(InputError, match="normals must have shape"):
        point_cloud(np.ones((2, 2)), grey((2, 2)), CAMERA, normals=np.ones((2, 2), np.float32))
    with pytest.raises(InputError, match="scalar block must have shape"):
        point_cloud(np.ones((2, 2)), grey((2, 2)), CAMERA, scalars={"block": np.ones(4)})
    with pytest.raises(InputError, match="intrinsics"):
        surface_mesh(np.ones((2, 2)), grey((2, 2)), None)
    with pytest.raises(InputError, match=r"normals need .* intrinsics"):
        surface_normals(np.ones((2, 2)), None)


def test_normals_do_not_depend_on_how_rows_are_shared_out(monkeypatch):
    rng = np.random.default_rng(1)
    depth = plane((0.3, 0.2, 0.9), 2.0) + rng.normal(0, 0.003, SHAPE).astype(np.float32)
    whole, triangles = surface_normals(depth, CAMERA), surface_mesh(depth, grey(), CAMERA).faces
    for rows in ("_BAND", "_NORMALS_BAND"):
        monkeypatch.setattr(surface, rows, 7)
    monkeypatch.setattr(surface, "_AT_ONCE", 100)
    np.testing.assert_allclose(surface_normals(depth, CAMERA), whole, atol=1e-6)
    banded = surface_mesh(depth, grey(), CAMERA).faces
    np.testing.assert_array_equal(np.unique(banded, axis=0), np.unique(triangles, axis=0))
