"""Clouds and meshes in files: every number comes back, here and in Open3D, under the names that programs show."""

import dataclasses
import re

import numpy as np
import pytest

import ilf
from ilf.data.points import PointCloud, in_world
from ilf.data.surface import Mesh
from ilf.errors import InputError

from ..space_formats import read_glb, read_mesh, read_points

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
SIGNS = np.array([1, -1, -1], np.float32)
SCALARS = ["scalar_expected_error", "scalar_filled", "scalar_block", "quality"]


def _assert_same(found: dict[str, np.ndarray], cloud: PointCloud, unit: float = 1.0, signs: object = 1) -> None:
    """Every number of the cloud, lengths in a unit [1/m], axes with these signs."""
    error = cloud.scalars["expected_error"] * np.float32(unit)
    assert found.keys() == {"positions", "colors", "normals", *SCALARS}
    np.testing.assert_array_equal(found["positions"], cloud.points * np.multiply(unit, signs, dtype=np.float32))
    np.testing.assert_array_equal(found["normals"], cloud.normals * np.float32(signs))
    np.testing.assert_array_equal(found["colors"], cloud.colours)
    np.testing.assert_array_equal(found["scalar_expected_error"], error)
    np.testing.assert_array_equal(found["quality"], error)
    np.testing.assert_array_equal(found["scalar_filled"], cloud.scalars["filled"])
    np.testing.assert_array_equal(found["scalar_block"], cloud.scalars["block"])


@pytest.mark.parametrize("suffix", [".ply", ".pcd"])
@pytest.mark.parametrize(("cloud", "ascii"), [(LARGE, False), (SMALL, True)])
def test_a_cloud_has_colours_before_scalars_and_every_number(suffix, cloud, ascii, tmp_path):
    path = tmp_path / f"c{suffix}"
    ilf.write_cloud(path, cloud, ascii=ascii)
    _assert_same(read_points(path), cloud)
    header = path.read_bytes().partition(b"DATA " if suffix == ".pcd" else b"end_header")[0].decode()
    fields = re.findall(r"FIELDS (.*)", header) or [" ".join(re.findall(r"property \w+ (\w+)", header))]
    named = "x y z rgb normal_x normal_y normal_z" if suffix == ".pcd" else "x y z nx ny nz red green blue"
    assert fields == [f"{named} {' '.join(SCALARS)}"]


@pytest.mark.parametrize("ascii", [False, True])
def test_a_pcd_of_every_pixel_is_organised(ascii, tmp_path):
    depth = RNG.uniform(1, 3, (3, 5)).astype(np.float32)
    colour = RNG.integers(0, 256, (3, 5, 3), dtype=np.uint8)
    camera = ilf.Camera(10.0, 10.0, 2.0, 1.0)
    moved = in_world(ilf.point_cloud(depth, colour, camera), np.diag([1.0, -1.0, -1.0, 1.0]))
    ilf.write_cloud(tmp_path / "c.pcd", moved, ascii=ascii)
    assert b"\nWIDTH 5\nHEIGHT 3\n" in (tmp_path / "c.pcd").read_bytes()
    found = read_points(tmp_path / "c.pcd")
    np.testing.assert_array_equal(found["positions"][:, 2].reshape(3, 5), -depth)
    np.testing.assert_array_equal(found["colors"].reshape(3, 5, 3), colour)
    depth[1, 2] = np.nan
    ilf.write_cloud(tmp_path / "c.pcd", ilf.point_cloud(depth, colour, camera), ascii=ascii)
    assert b"\nWIDTH 14\nHEIGHT 1\n" in (tmp_path / "c.pcd").read_bytes()
    assert len(read_points(tmp_path / "c.pcd")["positions"]) == 14
    with pytest.raises(InputError, match=r"shape \(2, 3\) does not have 300 pixels"):
        dataclasses.replace(SMALL, image_shape=(2, 3))


def test_lengths_and_directions_follow_unit_and_axes(tmp_path):
    ilf.write_cloud(tmp_path / "c.ply", SMALL, axes="y-up", unit="mm")
    _assert_same(read_points(tmp_path / "c.ply"), SMALL, 1000, SIGNS)


def test_a_ply_mesh_has_vertices_as_a_cloud_and_faces(tmp_path):
    path = tmp_path / "m.ply"
    ilf.write_mesh(path, MESH)
    _assert_same(read_points(path), SMALL)
    np.testing.assert_array_equal(read_mesh(path).triangles, MESH.faces)


def test_an_obj_mesh_comes_back(tmp_path):
    """Open3D may give every corner of a triangle a vertex of its own."""
    path = tmp_path / "m.obj"
    ilf.write_mesh(path, MESH, axes="y-up", unit="mm")
    found = read_mesh(path)
    corners, triangles = MESH.faces, np.asarray(found.triangles)
    points = np.asarray(found.vertices, np.float32)[triangles]
    np.testing.assert_array_equal(points, (SMALL.points * (1000 * SIGNS))[corners])
    np.testing.assert_array_equal(np.rint(np.asarray(found.vertex_colors)[triangles] * 255), SMALL.colours[corners])
    normals = np.asarray(found.vertex_normals)[triangles]
    np.testing.assert_allclose(normals, (SMALL.normals * SIGNS)[corners], atol=1e-6)


def test_a_glb_is_in_metres_with_y_up_and_linear_colours(tmp_path):
    path = tmp_path / "m.glb"
    ilf.write_mesh(path, MESH, axes="camera", unit="mm")
    told, attributes, faces = read_glb(path)
    assert list(attributes) == ["POSITION", "NORMAL", "COLOR_0", "_EXPECTED_ERROR", "_FILLED", "_BLOCK"]
    np.testing.assert_array_equal(attributes["POSITION"], SMALL.points * SIGNS)
    np.testing.assert_array_equal(attributes["NORMAL"], SMALL.normals * SIGNS)
    np.testing.assert_array_equal(faces, MESH.faces)
    np.testing.assert_array_equal(attributes["_EXPECTED_ERROR"], SMALL.scalars["expected_error"])
    np.testing.assert_array_equal(attributes["_BLOCK"], SMALL.scalars["block"])
    assert (attributes["COLOR_0"][:, 3] == 0xFFFF).all()
    np.testing.assert_array_equal(np.rint(_srgb(attributes["COLOR_0"][:, :3] / 0xFFFF) * 255), SMALL.colours)
    position = told["accessors"][told["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    np.testing.assert_array_equal(np.float32(position["min"]), attributes["POSITION"].min(0))
    np.testing.assert_array_equal(np.float32(position["max"]), attributes["POSITION"].max(0))
    assert told["materials"][0]["extensions"] == {"KHR_materials_unlit": {}}


def _srgb(light):
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
