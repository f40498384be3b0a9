"""Clouds and meshes in files: every number comes back, here and in Open3D, under the names that programs show."""

import dataclasses

import numpy as np
import pytest

import ilf
from ilf.data.open3d_images import load_open3d
from ilf.data.points import PointCloud, in_world
from ilf.data.surface import Mesh
from ilf.errors import InputError

from ..space_formats import read_glb, read_obj, read_pcd, read_ply

RNG = np.random.default_rng(5)
COUNT = 70_000  # more than are written at a time


def _unit(count: int) -> np.ndarray:
    vectors = RNG.normal(size=(count, 3)).astype(np.float32)
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _cloud(count: int) -> PointCloud:
    return PointCloud(
        RNG.uniform(-3, 3, (count, 3)).astype(np.float32),
        RNG.integers(0, 256, (count, 3), dtype=np.uint8),
        _unit(count),
        {
            "expected_error": RNG.random(count, np.float32),
            "filled": RNG.random(count) < 0.5,
            "block": RNG.integers(0, 40_000, count).astype(np.int32),
        },
    )


LARGE, SMALL = _cloud(COUNT), _cloud(300)
MESH = Mesh(SMALL, RNG.permuted(np.tile(np.arange(300, dtype=np.int32), (500, 1)), axis=1)[:, :3])
SCALARS = ["scalar_expected_error", "scalar_filled", "scalar_block", "quality"]


def _three(rows: np.ndarray, names: str) -> np.ndarray:
    return np.column_stack([rows[name] for name in names.split()])


def _assert_scalars(rows: np.ndarray, cloud: PointCloud, unit: float = 1.0) -> None:
    error = cloud.scalars["expected_error"] * np.float32(unit)
    np.testing.assert_array_equal(rows["scalar_expected_error"], error)
    np.testing.assert_array_equal(rows["quality"], error)
    np.testing.assert_array_equal(rows["scalar_filled"], cloud.scalars["filled"])
    np.testing.assert_array_equal(rows["scalar_block"], cloud.scalars["block"])


@pytest.mark.parametrize(("cloud", "ascii"), [(LARGE, False), (SMALL, True)])
def test_a_ply_has_colours_before_scalars_and_every_number(cloud, ascii, tmp_path):
    path = tmp_path / "c.ply"
    ilf.write_cloud(path, cloud, ascii=ascii)
    rows, faces = read_ply(path)
    assert faces is None
    assert list(rows.dtype.names) == ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", *SCALARS]
    assert {str(rows.dtype[name]) for name in rows.dtype.names} == {"float32", "uint8"}
    np.testing.assert_array_equal(_three(rows, "x y z"), cloud.points)
    np.testing.assert_array_equal(_three(rows, "nx ny nz"), cloud.normals)
    np.testing.assert_array_equal(_three(rows, "red green blue"), cloud.colours)
    _assert_scalars(rows, cloud)


@pytest.mark.parametrize(("cloud", "ascii"), [(LARGE, False), (SMALL, True)])
def test_a_pcd_has_the_same(cloud, ascii, tmp_path):
    path = tmp_path / "c.pcd"
    ilf.write_cloud(path, cloud, ascii=ascii)
    rows = read_pcd(path)
    assert list(rows.dtype.names) == ["x", "y", "z", "rgb", "normal_x", "normal_y", "normal_z", *SCALARS]
    np.testing.assert_array_equal(_three(rows, "x y z"), cloud.points)
    np.testing.assert_array_equal(_three(rows, "normal_x normal_y normal_z"), cloud.normals)
    red, green, blue = cloud.colours.T.astype(np.uint32)
    np.testing.assert_array_equal(rows["rgb"], red << 16 | green << 8 | blue)
    assert np.isfinite(rows["rgb"].astype("<u4").view("<f4")).all()
    _assert_scalars(rows, cloud)


@pytest.mark.parametrize("ascii", [False, True])
def test_a_pcd_of_every_pixel_is_organised(ascii, tmp_path):
    depth = RNG.uniform(1, 3, (3, 5)).astype(np.float32)
    colour = RNG.integers(0, 256, (3, 5, 3), dtype=np.uint8)
    camera = ilf.Camera(10.0, 10.0, 2.0, 1.0)
    moved = in_world(ilf.point_cloud(depth, colour, camera), np.diag([1.0, -1.0, -1.0, 1.0]))
    ilf.write_cloud(tmp_path / "c.pcd", moved, ascii=ascii)
    assert b"\nWIDTH 5\nHEIGHT 3\n" in (tmp_path / "c.pcd").read_bytes()
    rows = read_pcd(tmp_path / "c.pcd").reshape(3, 5)
    np.testing.assert_array_equal(rows["z"], -depth)
    np.testing.assert_array_equal(rows["rgb"] & 255, colour[..., 2])
    depth[1, 2] = np.nan
    ilf.write_cloud(tmp_path / "c.pcd", ilf.point_cloud(depth, colour, camera), ascii=ascii)
    assert b"\nWIDTH 14\nHEIGHT 1\n" in (tmp_path / "c.pcd").read_bytes()
    assert len(read_pcd(tmp_path / "c.pcd")) == 14
    with pytest.raises(InputError, match=r"shape \(2, 3\) does not have 300 pixels"):
        dataclasses.replace(SMALL, image_shape=(2, 3))


def test_lengths_and_directions_follow_unit_and_axes(tmp_path):
    ilf.write_cloud(tmp_path / "c.ply", SMALL, axes="y-up", unit="mm")
    rows, _ = read_ply(tmp_path / "c.ply")
    np.testing.assert_array_equal(_three(rows, "x y z"), SMALL.points * np.array([1000, -1000, -1000], np.float32))
    np.testing.assert_array_equal(_three(rows, "nx ny nz"), SMALL.normals * np.array([1, -1, -1], np.float32))
    _assert_scalars(rows, SMALL, unit=1000)


@pytest.mark.parametrize("suffix", [".ply", ".pcd"])
def test_open3d_reads_points_colours_normals_and_scalars(suffix, tmp_path):
    path = tmp_path / f"c{suffix}"
    ilf.write_cloud(path, SMALL)
    found = load_open3d().t.io.read_point_cloud(str(path))
    np.testing.assert_array_equal(found.point.positions.numpy(), SMALL.points)
    np.testing.assert_array_equal(found.point.colors.numpy(), SMALL.colours)
    np.testing.assert_array_equal(found.point.normals.numpy(), SMALL.normals)
    for name in SCALARS:
        kept = SMALL.scalars["expected_error" if name == "quality" else name.removeprefix("scalar_")]
        np.testing.assert_array_equal(found.point[name].numpy()[:, 0], kept)


def test_a_ply_mesh_has_vertices_as_a_cloud_and_faces(tmp_path):
    path = tmp_path / "m.ply"
    ilf.write_mesh(path, MESH)
    rows, faces = read_ply(path)
    np.testing.assert_array_equal(faces, MESH.faces)
    np.testing.assert_array_equal(_three(rows, "x y z"), SMALL.points)
    _assert_scalars(rows, SMALL)
    colours = _assert_corners(load_open3d().io.read_triangle_mesh(str(path)), SMALL.points)
    np.testing.assert_array_equal(np.rint(colours * 255), SMALL.colours[MESH.faces])


def test_an_obj_mesh_comes_back(tmp_path):
    path = tmp_path / "m.obj"
    ilf.write_mesh(path, MESH, axes="y-up", unit="mm")
    signs = np.array([1, -1, -1], np.float32)
    vertices, colours, normals, faces = read_obj(path)
    np.testing.assert_array_equal(vertices.astype(np.float32), SMALL.points * (1000 * signs))
    np.testing.assert_array_equal(np.rint(colours * 255), SMALL.colours)
    np.testing.assert_allclose(normals, SMALL.normals * signs, atol=1e-6)
    np.testing.assert_array_equal(faces, MESH.faces)
    colours = _assert_corners(load_open3d().io.read_triangle_mesh(str(path)), SMALL.points * (1000 * signs))
    np.testing.assert_array_equal(np.rint(colours * 255), SMALL.colours[MESH.faces])


def test_a_glb_is_in_metres_with_y_up_and_linear_colours(tmp_path):
    path = tmp_path / "m.glb"
    ilf.write_mesh(path, MESH, axes="camera", unit="mm")
    told, attributes, faces = read_glb(path)
    signs = np.array([1, -1, -1], np.float32)
    assert list(attributes) == ["POSITION", "NORMAL", "COLOR_0", "_EXPECTED_ERROR", "_FILLED", "_BLOCK"]
    np.testing.assert_array_equal(attributes["POSITION"], SMALL.points * signs)
    np.testing.assert_array_equal(attributes["NORMAL"], SMALL.normals * signs)
    np.testing.assert_array_equal(faces, MESH.faces)
    np.testing.assert_array_equal(attributes["_EXPECTED_ERROR"], SMALL.scalars["expected_error"])
    np.testing.assert_array_equal(attributes["_BLOCK"], SMALL.scalars["block"])
    assert (attributes["COLOR_0"][:, 3] == 0xFFFF).all()
    np.testing.assert_array_equal(np.rint(_srgb(attributes["COLOR_0"][:, :3] / 0xFFFF) * 255), SMALL.colours)
    position = told["accessors"][told["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    np.testing.assert_array_equal(np.float32(position["min"]), attributes["POSITION"].min(0))
    np.testing.assert_array_equal(np.float32(position["max"]), attributes["POSITION"].max(0))
    assert told["materials"][0]["extensions"] == {"KHR_materials_unlit": {}}


def _assert_corners(found, points):
    """Every corner of every triangle lies where it should (Open3D may give each a vertex of its own).

    Returns the corners' colours.
    """
    triangles = np.asarray(found.triangles)
    np.testing.assert_array_equal(np.asarray(found.vertices)[triangles].astype(np.float32), points[MESH.faces])
    return np.asarray(found.vertex_colors)[triangles]


def _srgb(light):
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
