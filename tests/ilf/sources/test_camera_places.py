"""Depth of a camera beside that of colour is registered by the transforms that camera files state."""

import json
import warnings
from dataclasses import replace

import cv2
import numpy as np
import pytest
import yaml

import ilf
from ilf.cli import main
from ilf.sources.registration import register
from tests.ilf.image_files import write_rgbd
from tests.ilf.project_states import through_project
from tests.ilf.two_cameras import COLOUR, DEPTH, made_pair, motion

PLAIN_COLOUR, PLAIN_DEPTH = replace(COLOUR, distortion=()), replace(DEPTH, distortion=())
TO_COLOUR = motion(-0.075, 0.02)
LEFT_TO_RIGHT = motion(-0.03, -0.01)


def _matrix(camera):
    return camera.matrix.tolist()


def _oak(camera, other, move, unit=None):
    """An entry of cameraData: where the camera is, in centimetres or another unit, as seen from a socket."""
    metres, more = {None: 0.01, 0: 1.0, 2: 0.001}[unit], {} if unit is None else {"lengthUnit": unit}
    place = dict(zip("xyz", (move[:3, 3] / metres).tolist(), strict=True))
    return {
        "cameraType": 0,
        "distortionCoeff": [0.0] * 14,
        "extrinsics": more
        | {
            "rotationMatrix": move[:3, :3].tolist(),
            "specTranslation": {"x": -7.5, "y": 0.0, "z": 0.0},
            "toCameraSocket": other,
            "translation": place,
        },
        "width": camera.size[0],
        "height": camera.size[1],
        "intrinsicMatrix": _matrix(camera),
    }


def _eeprom(sockets, **more):
    return json.dumps({"boardName": "OAK-D", "cameraData": sockets, "version": 7} | more)


def _oak_chain(unit=None):
    """Colour is the end of the chain left, right, colour."""
    left = _oak(PLAIN_DEPTH, 2, np.linalg.inv(LEFT_TO_RIGHT), unit)
    right = _oak(PLAIN_DEPTH, 0, TO_COLOUR, unit)
    end = _oak(PLAIN_COLOUR, -1, np.zeros((4, 4)), unit)
    return _eeprom([[0, end], [1, left], [2, right]])


def _oak_from_colour():
    """Colour states its place as seen from depth, as in files where the left camera is the end."""
    end = _oak(PLAIN_DEPTH, -1, np.eye(4))
    return _eeprom([[0, _oak(PLAIN_COLOUR, 2, np.linalg.inv(TO_COLOUR))], [2, end]])


def _oak_rectified():
    """Depth by stereo matching has the axes of the rectified right camera; its own turn is taken back."""
    turn = np.eye(4)
    turn[:3, :3], _ = cv2.Rodrigues(np.array([0.01, 0.03, -0.02]))
    rectified = {"rightCameraSocket": 2, "rectifiedRotationRight": turn[:3, :3].tolist(), "leftCameraSocket": 1}
    end = _oak(PLAIN_COLOUR, -1, np.eye(4))
    return _eeprom([[0, end], [2, _oak(PLAIN_DEPTH, 0, TO_COLOUR @ turn)]], stereoRectificationData=rectified)


def _kalibr(camera, **places):
    return places | {
        "camera_model": "pinhole",
        "distortion_coeffs": [0.0, 0.0, 0.0, 0.0],
        "distortion_model": "radtan",
        "intrinsics": list(camera.numbers),
        "resolution": list(camera.size),
    }


def _camchain():
    """The transform of cam1 takes points of cam0, depth, to cam1, and so on."""
    cameras = {
        "cam0": _kalibr(PLAIN_DEPTH),
        "cam1": _kalibr(PLAIN_DEPTH, T_cn_cnm1=LEFT_TO_RIGHT.tolist()),
        "cam2": _kalibr(PLAIN_COLOUR, T_cn_cnm1=(TO_COLOUR @ np.linalg.inv(LEFT_TO_RIGHT)).tolist()),
    }
    return yaml.safe_dump(cameras)


def _of_imu(key):
    """Both cameras state the place of the inertial unit."""
    colour, depth = motion(0.02, 0.3), np.linalg.inv(TO_COLOUR) @ motion(0.02, 0.3)
    if key == "T_imu_cam":
        colour, depth = np.linalg.inv(colour), np.linalg.inv(depth)
    cameras = {"cam0": _kalibr(PLAIN_COLOUR, **{key: colour.tolist()})}
    return yaml.safe_dump(cameras | {"cam1": _kalibr(PLAIN_DEPTH, **{key: depth.tolist()})})


def _named(place):
    cameras = {"color": PLAIN_COLOUR.to_json(), "depth": PLAIN_DEPTH.to_json()}
    return json.dumps(cameras | place)


def _realsense():
    def lines(name, camera):
        (width, height), (fx, fy, cx, cy) = camera.size, camera.numbers
        return (
            f' Intrinsic of "{name}" / {width}x{height} / {{Z16}}\n  Width:  \t{width}\n  Height: \t{height}\n'
            f"  PPX:  \t{cx}\n  PPY:  \t{cy}\n  Fx:  \t{fx}\n  Fy:  \t{fy}\n  Distortion: \tBrown Conrady\n"
            "  Coeffs:  \t0  0  0  0  0\n\n"
        )

    def place(start, end, move):
        rows = "\n".join("   " + "  ".join(f"{value:.9f}" for value in row) for row in move[:3, :3])
        shift = "  ".join(f"{value:.9f}" for value in move[:3, 3])
        told = f'Extrinsic from "{start}"\t  To\t  "{end}" :\n Rotation Matrix:\n{rows}\n'
        return f"{told}\n Translation Vector: {shift}\n\n"

    places = place("Depth", "Infrared 1", np.eye(4)) + place("Depth", "Color", TO_COLOUR)
    return lines("Depth", PLAIN_DEPTH) + lines("Color", PLAIN_COLOUR) + "\nExtrinsic Parameters:\n" + places


ROWS, SHIFT = TO_COLOUR[:3, :3].tolist(), TO_COLOUR[:3, 3]
FLAT = np.ravel(ROWS).tolist()
FILES = {
    "DepthAI": ("oak.json", _oak_chain(), "CAM_A", "CAM_C"),
    "DepthAI in metres": ("oak.json", _oak_chain(0), "CAM_A", "CAM_C"),
    "DepthAI in millimetres": ("oak.json", _oak_chain(2), "CAM_A", "CAM_C"),
    "DepthAI, colour beside depth": ("oak.json", _oak_from_colour(), "CAM_A", "CAM_C"),
    "DepthAI, rectified": ("oak.json", _oak_rectified(), "CAM_A", "CAM_C"),
    "Kalibr": ("camchain.yaml", _camchain(), "cam2", "cam0"),
    "Kalibr with an inertial unit": ("camchain.yaml", _of_imu("T_cam_imu"), "cam0", "cam1"),
    "OpenVINS": ("kalibr_imucam_chain.yaml", _of_imu("T_imu_cam"), "cam0", "cam1"),
    "rs-enumerate-devices": ("d435.txt", _realsense(), "Color", "Depth"),
    "matrix": ("both.json", _named({"depth_to_color": TO_COLOUR.tolist()}), "color", "depth"),
    "nested rows": (
        "both.json", _named({"extrinsics": {"depth_to_color": {"R": ROWS, "t": SHIFT.tolist()}}}), "color", "depth"
    ),
    "Orbbec, millimetres": (
        "both.json",
        _named({"depth_to_color": {"rotation_row_major": FLAT, "translation_mm": (1000 * SHIFT).tolist()}}),
        "color", "depth",
    ),
    "stated unit": (
        "both.json",
        _named({"depth_to_color": {"rotation": ROWS, "translation_unit": "cm", "translation": (100 * SHIFT).tolist()}}),
        "color", "depth",
    ),
    "no unit": (
        "both.json", _named({"depthToColor": {"rotation": ROWS, "translation": (1000 * SHIFT).tolist()}}),
        "color", "depth",
    ),
}  # fmt: skip


def _pair(folder, colour=PLAIN_COLOUR, depth=PLAIN_DEPTH):
    pair = made_pair(colour, depth, TO_COLOUR)
    files = write_rgbd(folder, 10000 * pair.depth, colour=pair.rgb[..., ::-1])
    return replace(pair, depth=np.rint(10000 * pair.depth) / 10000), [str(path) for path in files]


def _cameras(folder, name):
    file, content, colour, depth = FILES[name]
    (folder / file).write_text(content)
    return {"intrinsics": f"{folder / file}#{colour}", "depth_intrinsics": f"{folder / file}#{depth}"}


@pytest.mark.parametrize("name", FILES)
def test_depth_is_registered_by_the_stated_transform(tmp_path, name):
    pair, files = _pair(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ilf.DepthWarning)
        frame = ilf.load_frame(*files, depth_units=10000, **_cameras(tmp_path, name))
    expected = register(pair)
    same = np.isclose(frame.depth, expected.depth, atol=1e-4, equal_nan=True)
    assert same.mean() > 0.995  # the rest is at rounding of the file's numbers beside an edge
    beside = ilf.load_frame(*files, depth_units=10000, intrinsics=PLAIN_COLOUR, depth_intrinsics=PLAIN_DEPTH)
    assert np.isclose(beside.depth, expected.depth, atol=1e-4, equal_nan=True).mean() < 0.9


def test_rectified_depth_is_not_undistorted_by_the_lens_that_took_it(tmp_path):
    """Stereo matching has removed the distortion; that of colour is corrected."""
    pair, files = _pair(tmp_path, COLOUR, PLAIN_DEPTH)
    content = json.loads(_oak_rectified())
    for (_, camera), lens in zip(content["cameraData"], (COLOUR, DEPTH), strict=True):
        camera["distortionCoeff"] = [*lens.distortion, *[0.0] * (14 - len(lens.distortion))]
    path = tmp_path / "oak.json"
    path.write_text(json.dumps(content))
    cameras = {"intrinsics": f"{path}#CAM_A", "depth_intrinsics": f"{path}#CAM_C"}
    frame = ilf.load_frame(*files, depth_units=10000, undistort=True, **cameras)
    expected = register(pair)
    assert np.isclose(frame.depth, expected.depth, atol=1e-4, equal_nan=True).mean() > 0.995
    again = ilf.load_frame(**frame.inputs.arguments)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)


def test_the_transform_is_told_recorded_and_replayed(tmp_path, cli):
    _, files = _pair(tmp_path)
    cameras = _cameras(tmp_path, "DepthAI")
    flags = ["--intrinsics", cameras["intrinsics"], "--depth-intrinsics", cameras["depth_intrinsics"]]
    assert "76 mm apart" in cli("info", *files, *flags, "--depth-units", "10000").out
    out = tmp_path / "out"
    settings = ["--blocks-detector", "canny", "--preset", "paper", "--max-iterations", "3"]
    assert main(["complete", *files, *flags, "--depth-units", "10000", "--out", str(out), *settings]) == 0
    (tmp_path / "oak.json").unlink()
    assert main(["complete", "--replay", str(out / "run.json"), "--out", str(tmp_path / "again")]) == 0
    for one in ("depth.png", "depth.npy"):
        if (out / one).exists():
            assert (out / one).read_bytes() == (tmp_path / "again" / one).read_bytes()


def test_the_same_frame_comes_back_from_arguments_and_projects(tmp_path):
    _, files = _pair(tmp_path)
    frame = ilf.load_frame(*files, depth_units=10000, **_cameras(tmp_path, "DepthAI"))
    (tmp_path / "oak.json").unlink()
    again = ilf.load_frame(**json.loads(json.dumps(frame.inputs.arguments)))
    for other in (again, through_project(frame, tmp_path / "room.ilf")):
        assert other.inputs == frame.inputs
        assert np.array_equal(other.depth, frame.depth, equal_nan=True)


@pytest.mark.parametrize(
    "place",
    [
        {"depth_to_color": {"rotation": FLAT, "translation": SHIFT.tolist()}},  # by rows or by columns?
        {"depth_to_color": {"rotation": ROWS[:2], "translation": SHIFT.tolist()}},
        {"depth_to_color": {"rotation": [[0.0] * 3] * 3, "translation": SHIFT.tolist()}},
    ],
)
def test_a_transform_that_is_not_clear_is_not_used_and_said(tmp_path, place):
    _, files = _pair(tmp_path)
    (tmp_path / "both.json").write_text(_named(place))
    path = tmp_path / "both.json"
    with pytest.warns(ilf.DepthWarning, match="states where the cameras are"):
        ilf.load_frame(*files, depth_units=10000, intrinsics=f"{path}#color", depth_intrinsics=f"{path}#depth")


def test_a_camera_of_another_file_has_no_place_in_this_one(tmp_path):
    _, files = _pair(tmp_path)
    own = _cameras(tmp_path, "Kalibr")
    with pytest.warns(ilf.DepthWarning, match="name both cameras in that file"):
        frame = ilf.load_frame(
            *files,
            depth_units=10000,
            intrinsics=ilf.Camera(*PLAIN_COLOUR.numbers),
            depth_intrinsics=own["depth_intrinsics"],
        )
    assert frame.inputs.depth_to_colour is None
