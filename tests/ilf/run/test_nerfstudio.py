"""Poses on their way from sources into frames, records, clouds in the world, and data sets of nerfstudio."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.data.points import in_world, point_cloud
from ilf.errors import ExportError, FormatError, InputError
from ilf.project.sources import load_inputs
from ilf.run.nerfstudio import depth_weight, write_nerfstudio
from ilf.run.options import ExportOptions
from ilf.run.record_file import read_record
from ilf.run.run import Run
from ilf.run.writing import write
from ilf.sources.frames import load_frame
from ilf.sources.opening import close_all
from ilf.sources.poses import motion_between
from tests.ilf.phone_files import COLOUR_SIZE, FLIP, MM, SIZE, K, pose, write_record3d
from tests.ilf.small_frames import write_small_frame

pytest.importorskip("lzfse")

CAMERA = (80, 80, 39.5, 29.5)


def matrix_file(path: Path, number: int = 0) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, pose(number))


@pytest.fixture
def framed(tmp_path: Path) -> ilf.RGBDFrame:
    rgb, depth = write_small_frame(tmp_path / "frame")
    matrix_file(tmp_path / "frame" / "pose.txt")
    return load_frame(rgb, depth, intrinsics=CAMERA)


def written(folder: Path, frame: ilf.RGBDFrame, options: ExportOptions | None = None) -> Path:
    """A result without blocks: its depth is as it was read."""
    run = Run(frame, np.zeros(frame.shape, np.int32))
    completion = run.complete()
    write(folder, run, completion, options or ExportOptions(cloud=None))
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
    assert np.array_equal(load_frame(folder).pose, framed.pose)
    (tmp_path / "frame" / "pose.txt").unlink()
    assert np.array_equal(ilf.replay(folder / "run.json").run.frame.pose, framed.pose)
    record = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(record | {"pose": [[1]]}))
    with pytest.raises(FormatError, match="'pose' in the run record must be"):
        read_record(folder / "run.json")


def test_frames_of_projects_have_it_from_files_beside_them(framed):
    assert np.array_equal(load_inputs(framed.inputs, framed.name, framed.intrinsics).pose, framed.pose)


def test_records_of_frames_without_a_pose_have_none(tmp_path):
    rgb, depth = write_small_frame(tmp_path / "frame")
    folder = written(tmp_path / "out", load_frame(rgb, depth, intrinsics=CAMERA))
    assert json.loads((folder / "run.json").read_text())["pose"] is None
    assert "pose" not in json.loads((folder / "meta.json").read_text())


def test_clouds_lie_in_the_world_where_that_is_asked_for(framed, tmp_path):
    cloud = point_cloud(framed.depth, framed.rgb, framed.intrinsics)
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


def test_results_become_a_data_set_of_nerfstudio(framed, tmp_path, capsys):
    written(tmp_path / "results" / "a", framed)
    written(tmp_path / "results" / "b", replace(framed, pose=pose(1)))
    written(tmp_path / "results" / "c", replace(framed, pose=None))
    assert main(["nerfstudio", str(tmp_path / "results"), "--out", str(tmp_path / "data")]) == 0
    told = capsys.readouterr()
    assert "transforms.json and the 6 files" in told.out
    assert "Left out, without a known pose: 1 result (c)." in told.err
    data = json.loads((tmp_path / "data" / "transforms.json").read_text())
    assert data["depth_unit_scale_factor"] == 0.001
    first, second = data["frames"]
    assert np.allclose(np.array(second["transform_matrix"]) @ FLIP, pose(1))
    assert (first["fl_x"], first["cx"], first["w"], first["h"]) == (80, 40, 80, 60)
    depth = cv2.imread(str(tmp_path / "data" / first["depth_file_path"]), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(depth > 0, np.isfinite(framed.depth))
    assert np.allclose(depth / 1000, np.nan_to_num(framed.depth), atol=6e-4)
    weight = cv2.imread(str(tmp_path / "data" / first["depth_weight_file_path"]), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(weight == 255, np.isfinite(framed.depth))
    assert cv2.imread(str(tmp_path / "data" / first["file_path"])).shape == (60, 80, 3)


def test_a_phones_colour_comes_as_it_was_recorded(tmp_path):
    source = ilf.open_source(write_record3d(tmp_path / "a.r3d"))
    results = [written(tmp_path / "out" / key, source.read(key)) for key in source.keys]
    write_nerfstudio(tmp_path / "data", results)
    close_all()
    frame = json.loads((tmp_path / "data" / "transforms.json").read_text())["frames"][1]
    assert (frame["w"], frame["h"], frame["fl_x"], frame["cx"]) == (*COLOUR_SIZE, K[0], K[2] + 0.5)
    assert np.allclose(np.array(frame["transform_matrix"]), pose(1) @ FLIP, atol=1e-6)
    assert cv2.imread(str(tmp_path / "data" / frame["file_path"])).shape[:2] == COLOUR_SIZE[::-1]
    depth = cv2.imread(str(tmp_path / "data" / frame["depth_file_path"]), cv2.IMREAD_UNCHANGED)
    assert depth.shape == SIZE[::-1]
    assert np.array_equal(depth, MM)


def test_what_cannot_become_one_is_told(framed, tmp_path):
    with pytest.raises(InputError, match="no results"):
        write_nerfstudio(tmp_path / "data", [tmp_path / "frame"])
    without = written(tmp_path / "out", replace(framed, pose=None))
    with pytest.raises(InputError, match="none of the 1 results has one"):
        write_nerfstudio(tmp_path / "data", [without])
    blind = written(tmp_path / "blind", replace(framed, intrinsics=None))
    with pytest.raises(InputError, match="intrinsics are not known"):
        write_nerfstudio(tmp_path / "data", [blind])
    with pytest.raises(ExportError, match="not an empty folder"):
        write_nerfstudio(tmp_path / "out", [without])
    assert not (tmp_path / "data").exists()
