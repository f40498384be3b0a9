"""Poses on their way from sources into frames, records, clouds in the world, and data sets of other programs."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ilf
from ilf.data.points import in_world
from ilf.errors import ExportError, FormatError, InputError, ParameterError
from ilf.run.data_sets import depth_weight, write_data_set
from ilf.run.options import ExportOptions
from ilf.run.record import read_record
from ilf.run.writing import write
from ilf.sources.opening import close_all
from ilf.sources.trajectories import motion_between
from tests.ilf.phone_files import COLOUR_SIZE, FLIP, MM, SIZE, K, pose, write_record3d
from tests.ilf.small_frames import write_small_frame
from tests.ilf.small_sequences import pose_of, sequence, write_sequence

pytest.importorskip("lzfse")

CAMERA = (80, 76, 41.3, 27.8)


def matrix_file(path: Path, number: int = 0) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, pose(number))


@pytest.fixture
def framed(tmp_path):
    rgb, depth = write_small_frame(tmp_path / "frame")
    matrix_file(tmp_path / "frame" / "pose.txt")
    return ilf.load_frame(rgb, depth, intrinsics=CAMERA)


def written(folder: Path, frame: ilf.RGBDFrame, options: ExportOptions | None = None) -> Path:
    """A result without blocks: its depth is as it was read."""
    write(folder, ilf.complete(frame, np.zeros(frame.shape, np.int32)), options or ExportOptions(cloud=None))
    return folder


def test_a_frame_has_the_pose_that_files_beside_it_tell(framed, tmp_path):
    assert np.allclose(framed.pose, pose(0))
    assert not framed.pose.flags.writeable
    moved = replace(framed, pose=pose(1))
    assert np.allclose(motion_between(framed, moved), np.linalg.inv(pose(1)) @ pose(0))
    assert replace(framed, pose=None).with_invalid_mask(np.isnan(framed.depth)).pose is None
    for wrong, told in (([1, 2], "4 x 4"), (2 * np.eye(4), "0 0 0 1"), (np.diag([2, 2, 2, 1]), "without scale")):
        with pytest.raises(InputError, match=told):
            replace(framed, pose=wrong)


def test_records_replays_and_folders_keep_it(framed, tmp_path):
    folder = written(tmp_path / "out", framed)
    assert np.array_equal(read_record(folder / "run.json").pose, framed.pose)
    assert np.array_equal(ilf.load_frame(folder).pose, framed.pose)
    (tmp_path / "frame" / "pose.txt").unlink()
    assert np.array_equal(ilf.replay(folder / "run.json").run.frame.pose, framed.pose)
    record = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(record | {"pose": [[1]]}))
    with pytest.raises(FormatError, match="'pose' in the run record must be"):
        read_record(folder / "run.json")


def test_clouds_lie_in_the_world_where_that_is_asked_for(framed, tmp_path):
    cloud = ilf.point_cloud(framed.depth, framed.rgb, framed.intrinsics)
    expected = cloud.points @ pose(0)[:3, :3].T + pose(0)[:3, 3]
    assert np.allclose(in_world(cloud, pose(0)).points, expected, atol=1e-5)
    folder = written(tmp_path / "out", framed, ExportOptions(cloud="xyz", mesh="ply", normals=True, axes="world"))
    assert np.allclose(np.loadtxt(folder / "cloud.xyz")[:5], expected[:5], atol=1e-3)
    with pytest.raises(InputError, match="other than world"):
        written(tmp_path / "none", replace(framed, pose=None), ExportOptions(axes="world"))


def test_weights_fall_with_the_expected_error():
    depth, error = np.array([[2, 2, 2, 4, np.nan]]), np.array([[np.nan, 0.02, 0.02, 0.08, np.nan]])
    doubtful = np.array([[False, False, True, False, False]])
    assert np.allclose(depth_weight(depth, error, doubtful), [[1, 0.5, 0, 0.2, 0]])


def test_results_become_a_data_set_of_nerfstudio(framed, tmp_path, cli):
    written(tmp_path / "results" / "a", framed)
    written(tmp_path / "results" / "b", replace(framed, pose=pose(1)))
    written(tmp_path / "results" / "c", replace(framed, pose=None))
    told = cli("project", "export", tmp_path / "results", "--to", "nerfstudio", "--out", tmp_path / "data")
    assert "7 files" in told.out
    assert "Left out, without a known pose: 1 result (c)." in told.err
    data = json.loads((tmp_path / "data" / "transforms.json").read_text())
    assert data["depth_unit_scale_factor"] == 0.001
    first, second = data["frames"]
    assert np.allclose(np.array(second["transform_matrix"]) @ FLIP, pose(1))
    assert [first[name] for name in ("fl_x", "fl_y", "cx", "cy", "w", "h")] == pytest.approx(
        [80, 76, 41.8, 28.3, 80, 60]
    )
    depth = cv2.imread(str(tmp_path / "data" / first["depth_file_path"]), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(depth > 0, np.isfinite(framed.depth))
    assert np.allclose(depth / 1000, np.nan_to_num(framed.depth), atol=6e-4)
    weight = cv2.imread(str(tmp_path / "data" / first["depth_weight_file_path"]), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(weight == 255, np.isfinite(framed.depth))
    assert cv2.imread(str(tmp_path / "data" / first["file_path"])).shape == (60, 80, 3)


def test_a_phones_colour_comes_as_it_was_recorded(tmp_path):
    source = ilf.open_source(write_record3d(tmp_path / "a.r3d"))
    results = [written(tmp_path / "out" / key, source.read(key)) for key in source.keys]
    write_data_set(tmp_path / "data", results)
    close_all()
    frame = json.loads((tmp_path / "data" / "transforms.json").read_text())["frames"][1]
    assert (frame["w"], frame["h"], frame["fl_x"], frame["cx"]) == (*COLOUR_SIZE, K[0], K[2] + 0.5)
    assert np.allclose(np.array(frame["transform_matrix"]), pose(1) @ FLIP, atol=1e-6)
    assert cv2.imread(str(tmp_path / "data" / frame["file_path"])).shape[:2] == COLOUR_SIZE[::-1]
    depth = cv2.imread(str(tmp_path / "data" / frame["depth_file_path"]), cv2.IMREAD_UNCHANGED)
    assert depth.shape == SIZE[::-1]
    assert np.array_equal(depth, MM)


@pytest.fixture
def results(tmp_path):
    """Results of a camera that moves past a wavy wall, each with a hole."""
    source = ilf.open_source(write_sequence(tmp_path / "sequence"), intrinsics=CAMERA)
    return [written(tmp_path / "results" / key, source.read(key)) for key in source.keys]


@pytest.mark.parametrize("to", ["nerfstudio", "open3d"])
def test_data_sets_are_read_back_as_they_were_written(results, tmp_path, to):
    assert write_data_set(tmp_path / "data", results, to).notes == ()
    source = ilf.open_source(tmp_path / "data")
    assert source.layout.startswith(to)
    if to == "open3d":
        stated = json.loads((tmp_path / "data" / "camera_intrinsic.json").read_text())["intrinsic_matrix"]
        assert stated == [80, 0, 0, 0, 76, 0, 41.3, 27.8, 1], "by columns"
    for number, (frame, measured) in enumerate(zip(source, sequence(), strict=True)):
        np.testing.assert_allclose(frame.pose, pose_of(number), atol=1e-12)
        camera = frame.intrinsics
        assert (camera.fx, camera.fy, camera.cx, camera.cy) == CAMERA
        np.testing.assert_allclose(frame.depth, measured.depth, atol=1.01e-3)
        assert np.abs(frame.rgb.astype(int) - measured.rgb).mean() < 5


def test_gaussian_splatting_gets_inverse_depth_and_a_model(results, tmp_path):
    notes = write_data_set(tmp_path / "data", results, "3dgs").notes
    assert "The principal point lies 1.8 px from" in notes[1]
    assert notes[:1] == (
        "4.0% of the pixels have no depth: the published trainer takes them for infinitely far. Complete the frames "
        "with --extrapolate for depth everywhere.",
    )
    model = tmp_path / "data" / "sparse" / "0"
    assert (model / "cameras.txt").read_text() == "1 PINHOLE 80 60 80.0 76.0 41.8 28.3\n"
    parameters = json.loads((model / "depth_params.json").read_text())
    lines = (model / "images.txt").read_text().split("\n")
    assert lines[1::2] == [""] * 5, "no points are listed"
    for number, (line, measured) in enumerate(zip(lines[:10:2], sequence(), strict=True)):
        w, x, y, z, *position, camera, name = line.split()[1:]
        to_camera = np.linalg.inv(pose_of(number))
        np.testing.assert_allclose(np.array(position, float), to_camera[:3, 3], atol=1e-12)
        turn = Rotation.from_quat([x, y, z, w]).as_matrix()
        np.testing.assert_allclose(turn, to_camera[:3, :3], atol=1e-12)
        assert (camera, name) == ("1", f"{number + 1:05}.jpg")
        assert (tmp_path / "data" / "images" / name).is_file()
        stored = cv2.imread(str(tmp_path / "data" / "depths" / f"{name[:5]}.png"), cv2.IMREAD_UNCHANGED)
        inverse = stored / 65536 * parameters[name[:5]]["scale"] + parameters[name[:5]]["offset"]
        known = np.isfinite(measured.depth)
        assert not stored[~known].any()
        np.testing.assert_allclose(1 / inverse[known], measured.depth[known], atol=1.5e-3)
    points = np.loadtxt(model / "points3D.txt")
    assert len(points) == sum(np.isfinite(frame.depth).sum() for frame in sequence())
    x, y, z = points[:, 1:4].T
    np.testing.assert_allclose(z, 2 + 0.1 * np.sin(2 * x) * np.cos(3 * y), atol=3e-3)
    assert points[:, 4:7].max() <= 255


def test_what_gaussian_splatting_cannot_express_is_told(framed, tmp_path, monkeypatch):
    depth = np.where(np.arange(80) < 8, 0.05, 2.0) * np.ones((60, 1))
    error = np.full((60, 80), np.nan)
    error[:, 40:] = 0.03  # a weight below a half: no points of it
    odd = replace(framed, depth=depth, intrinsics=ilf.Camera(80.0, 80.0, 44.5, 29.5))
    folder = written(tmp_path / "odd", odd)
    np.save(folder / "expected_error.npy", error.astype(np.float32))
    monkeypatch.setattr("ilf.run.data_sets._POINTS", 50)
    assert write_data_set(tmp_path / "data", [folder], "3dgs").notes == (
        "Depth nearer than 0.1 m was clipped: 480 pixels.",
        "The principal point lies 5.0 px from the images' centre, where the published trainer takes it to be; others "
        "read it from cameras.txt.",
    )
    stored = cv2.imread(str(tmp_path / "data" / "depths" / "00001.png"), cv2.IMREAD_UNCHANGED)
    assert (stored[0, 0], stored[0, 79]) == (65535, round(65536 / 20))
    points = np.loadtxt(tmp_path / "data" / "sparse" / "0" / "points3D.txt")[:, 1:4] - framed.pose[:3, 3]
    assert len(points) == 50
    x, _, z = framed.pose[:3, :3].T @ points.T
    assert (x / z * 80 + 44.5).max() < 40.01


def test_what_cannot_become_one_is_told(framed, tmp_path):
    with pytest.raises(InputError, match="no results"):
        write_data_set(tmp_path / "data", [tmp_path / "frame"])
    without = written(tmp_path / "out", replace(framed, pose=None))
    with pytest.raises(InputError, match="None of the results has a pose"):
        write_data_set(tmp_path / "data", [without])
    blind = written(tmp_path / "blind", replace(framed, intrinsics=None))
    with pytest.raises(InputError, match="intrinsics are not known"):
        write_data_set(tmp_path / "data", [blind])
    with pytest.raises(ExportError, match="not an empty folder"):
        write_data_set(tmp_path / "out", [without])
    with pytest.raises(ParameterError, match=r"no data set 'colmap'\. Known: nerfstudio, 3dgs, open3d"):
        write_data_set(tmp_path / "data", [without], "colmap")
    assert not (tmp_path / "data").exists()


def test_open3d_has_one_camera(framed, tmp_path):
    other = replace(framed, intrinsics=ilf.Camera(81.0, 80.0, 39.5, 29.5))
    folders = [written(tmp_path / name, frame) for name, frame in (("a", framed), ("b", other))]
    with pytest.raises(InputError, match=r"b has another camera than the results before it; Open3D has one for all\."):
        write_data_set(tmp_path / "data", folders, "open3d")
