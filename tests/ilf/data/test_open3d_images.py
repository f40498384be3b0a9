"""Frames to Open3D and back."""

import sys

import numpy as np
import pytest

import ilf
from ilf.data.open3d_images import load_open3d
from ilf.errors import ExportError, InputError

CAMERA = ilf.Camera(50.0, 52.0, 9.5, 7.0)
RNG = np.random.default_rng(4)
DEPTH = RNG.uniform(0.4, 9.0, (15, 20)).astype(np.float32)
DEPTH[2:5, 3:9] = np.nan
FRAME = ilf.RGBDFrame(RNG.integers(0, 256, (15, 20, 3), dtype=np.uint8), DEPTH, CAMERA)


def test_a_frame_comes_back_from_open3d():
    again = ilf.RGBDFrame.from_open3d(FRAME.to_open3d(), FRAME.open3d_camera(), name="again")
    np.testing.assert_array_equal(again.rgb, FRAME.rgb)
    np.testing.assert_array_equal(again.depth, FRAME.depth)
    assert (again.intrinsics.fx, again.intrinsics.fy, again.intrinsics.cx, again.intrinsics.cy) == (50, 52, 9.5, 7)
    assert again.name == "again"


def test_a_cloud_and_a_mesh_are_given_to_open3d_with_colours_and_normals():
    normals = ilf.surface_normals(DEPTH, CAMERA)
    mesh = ilf.surface_mesh(DEPTH, FRAME.rgb, CAMERA, normals=normals)
    theirs, points = mesh.to_open3d(), mesh.vertices.to_open3d()
    np.testing.assert_array_equal(np.asarray(theirs.triangles), mesh.faces)
    for given in (np.asarray(theirs.vertices), np.asarray(points.points)):
        np.testing.assert_array_equal(given, mesh.vertices.points)
    for given in (np.asarray(theirs.vertex_colors), np.asarray(points.colors)):
        np.testing.assert_array_equal(np.rint(given * 255), mesh.vertices.colours)
    for given in (np.asarray(theirs.vertex_normals), np.asarray(points.normals)):
        np.testing.assert_array_equal(given, mesh.vertices.normals)
    assert not ilf.point_cloud(DEPTH, FRAME.rgb, CAMERA).to_open3d().has_normals()


def test_tensor_images_and_whole_numbers_are_read_with_their_units():
    o3d = load_open3d()
    raw = np.round(np.nan_to_num(DEPTH) * 5000).astype(np.uint16)
    image = o3d.t.geometry.RGBDImage(
        o3d.t.geometry.Image(o3d.core.Tensor(FRAME.rgb)), o3d.t.geometry.Image(o3d.core.Tensor(raw))
    )
    matrix = o3d.core.Tensor([[50.0, 0, 9.5], [0, 52.0, 7.0], [0, 0, 1]])
    frame = ilf.RGBDFrame.from_open3d(image, matrix, depth_units=5000)
    np.testing.assert_allclose(frame.depth, DEPTH, atol=0.00011)
    np.testing.assert_array_equal(frame.rgb, FRAME.rgb)
    assert frame.intrinsics.fy == 52
    assert ilf.RGBDFrame.from_open3d(image, CAMERA, depth_units=5000).intrinsics is CAMERA
    assert ilf.RGBDFrame.from_open3d(image, depth_units=5000).intrinsics is None
    with pytest.raises(InputError, match=r"depth is uint16: give depth_units"):
        ilf.RGBDFrame.from_open3d(image)


def test_grey_images_and_other_things_are_refused():
    o3d = load_open3d()
    grey = o3d.geometry.RGBDImage.create_from_color_and_depth(
        o3d.geometry.Image(np.array(FRAME.rgb)), o3d.geometry.Image(np.nan_to_num(DEPTH)), depth_scale=1.0
    )
    with pytest.raises(InputError, match="convert_rgb_to_intensity=False"):
        ilf.RGBDFrame.from_open3d(grey)
    with pytest.raises(InputError, match="RGBDImage of Open3D is needed, not ndarray"):
        ilf.RGBDFrame.from_open3d(DEPTH)
    with pytest.raises(InputError, match="intrinsics are unknown"):
        ilf.RGBDFrame(FRAME.rgb, DEPTH).open3d_camera()


@pytest.mark.parametrize(
    ("said", "remedy"),
    [
        ("libGL.so.1: cannot open shared object file: No such file or directory", "sudo apt install libgl1"),
        ("libX11.so.6: cannot open shared object file: No such file or directory", "sudo apt install libx11-6"),
        ("libodd.so.7: cannot open shared object file: No such file or directory", r"libodd\.so\.7"),
    ],
)
def test_open3d_that_cannot_be_loaded_names_library_and_package(said, remedy, monkeypatch):
    class Refusing:
        def find_spec(self, name, path=None, target=None):
            if name == "open3d":
                raise OSError(said)

    monkeypatch.delitem(sys.modules, "open3d", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(sys, "meta_path", [Refusing(), *sys.meta_path])
    with pytest.raises(ExportError, match=remedy):
        load_open3d()
