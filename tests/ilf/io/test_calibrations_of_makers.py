"""The cameras of eight makers' files, each written as the maker does: numbers, size, lens and coefficients to 1e-6."""

import json
import struct

import cv2
import numpy as np
import pytest

from ilf.errors import FormatError, InputError
from ilf.io.cameras import frame_camera, lens_from

NUMBERS = [611.437256, 610.982117, 322.751648, 241.119385]
FX, FY, CX, CY = NUMBERS
K = [FX, 0.0, CX, 0.0, FY, CY, 0.0, 0.0, 1.0]
BROWN = [0.1234567, -0.2345678, 0.0012345, -0.0023456, 0.0345678]
RATIONAL = [*BROWN, 0.0456789, -0.0567891, 0.0067891]
FISH = [0.0312345, -0.0123456, 0.0034567, -0.0009876]
SIZE = (640, 480)

CALIBRATION = f"""image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: {K}
distortion_model: {{model}}
distortion_coefficients:
  rows: 1
  cols: {{count}}
  data: {{coefficients}}
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [600.5, 0, 320.25, 0, 0, 601.5, 240.25, 0, 0, 0, 1, 0]
"""
ECHO_1 = f"""header:
  seq: 12
  stamp:
    secs: 1600000000
    nsecs: 500
  frame_id: "camera_color_optical_frame"
height: 480
width: 640
distortion_model: "plumb_bob"
D: {BROWN}
K: {K}
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [600.5, 0.0, 320.25, 0.0, 0.0, 601.5, 240.25, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: False
---
"""


def _lines(values: list[float]) -> str:
    return "".join(f"- {value}\n" for value in values)


ECHO_2 = (
    "header:\n  stamp:\n    sec: 1600000000\n    nanosec: 500\n  frame_id: oak_rgb_camera_optical_frame\nheight: 480\n"
    f"width: 640\ndistortion_model: equidistant\nd:\n{_lines(FISH)}k:\n{_lines(K)}"
    f"r:\n{_lines([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])}"
    f"p:\n{_lines([600.5, 0.0, 320.25, 0.0, 0.0, 601.5, 240.25, 0.0, 0.0, 0.0, 1.0, 0.0])}"
    "binning_x: 0\nbinning_y: 0\nroi:\n  height: 0\n  width: 0\n  do_rectify: false\n---\n"
)
ORB_SLAM_2 = f"""%YAML:1.0

#--------------------------------------------------------------------------------------------
# Camera Parameters. Adjust them!
#--------------------------------------------------------------------------------------------
Camera.fx: {FX}
Camera.fy: {FY}
Camera.cx: {CX}
Camera.cy: {CY}

Camera.k1: {BROWN[0]}
Camera.k2: {BROWN[1]}
Camera.p1: {BROWN[2]}
Camera.p2: {BROWN[3]}
Camera.k3: {BROWN[4]}

Camera.width: 640
Camera.height: 480
Camera.fps: 30.0
Camera.bf: 40.0
Camera.RGB: 1
ThDepth: 40.0
DepthMapFactor: 5208.0
"""
ORB_SLAM_3 = f"""%YAML:1.0

File.version: "1.0"
Camera.type: "KannalaBrandt8"

# Left camera
Camera1.fx: {FX}
Camera1.fy: {FY}
Camera1.cx: {CX}
Camera1.cy: {CY}
Camera1.k1: {FISH[0]}
Camera1.k2: {FISH[1]}
Camera1.k3: {FISH[2]}
Camera1.k4: {FISH[3]}

# Right camera
Camera2.fx: 190.44
Camera2.fy: 190.43
Camera2.cx: 252.59
Camera2.cy: 254.92
Camera2.k1: 0.0034
Camera2.k2: 0.0007
Camera2.k3: -0.0020
Camera2.k4: 0.0002

Stereo.T_c1_c2: !!opencv-matrix
  rows: 4
  cols: 4
  dt: f
  data: [1.0, 0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
Camera.width: 640
Camera.height: 480
Camera.fps: 20
"""
KALIBR = f"""cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: {FISH}
  distortion_model: equidistant
  intrinsics: {NUMBERS}
  resolution: [640, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.9999, 0.0017, 0.0039, -0.1102]
  - [-0.0017, 0.9999, 0.0001, 0.0003]
  - [-0.0039, -0.0001, 0.9999, 0.0007]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: {BROWN[:4]}
  distortion_model: radtan
  intrinsics: {NUMBERS}
  resolution: [640, 480]
  rostopic: /cam1/image_raw
cam2:
  camera_model: omni
  distortion_coeffs: [-0.2, 0.1, 0.0, 0.0]
  distortion_model: radtan
  intrinsics: [1.5, 900.0, 900.0, 320.0, 240.0]
  resolution: [640, 480]
"""


def _realsense_lines(numbers: list[float], model: str, coefficients: list[float], size: tuple[int, int]) -> str:
    fx, fy, cx, cy = numbers
    return (
        f"  Width:      \t{size[0]}\n  Height:     \t{size[1]}\n  PPX:        \t{cx}\n  PPY:        \t{cy}\n"
        f"  Fx:         \t{fx}\n  Fy:         \t{fy}\n  Distortion: \t{model}\n"
        f"  Coeffs:     \t{''.join(f'{value}  	' for value in coefficients)}\n  FOV (deg):  \t55.2 x 42.8\n\n"
    )


REALSENSE = (
    "Device info: \n    Name                          : \tIntel RealSense D455\n    Serial Number : \t0123\n\n"
    "Stream Profiles supported by Stereo Module\n Supported modes:\n    stream       resolution      fps\n"
    "    Depth\t  640x480\t@ 30Hz\t   Z16\n\nIntrinsic Parameters:\n\n"
    + ' Intrinsic of "Depth" / 640x480 / {Z16}\n'
    + _realsense_lines([385.13, 385.13, 321.63, 241.61], "Brown Conrady", [0] * 5, SIZE)
    + ' Intrinsic of "Infrared 1" / 640x480 / {Y8}\n'
    + _realsense_lines([385.13, 385.13, 321.63, 241.61], "Brown Conrady", [0] * 5, SIZE)
    + ' Intrinsic of "Color" / 640x480 / {YUYV/RGB8/BGR8/RGBA8/BGRA8/Y16}\n'
    + _realsense_lines(NUMBERS, "Inverse Brown Conrady", BROWN, SIZE)
    + ' Intrinsic of "Color" / 1280x720 / {YUYV/RGB8/BGR8/RGBA8/BGRA8/Y16}\n'
    + _realsense_lines([2 * FX, 2 * FY, 645.5, 361.25], "Inverse Brown Conrady", BROWN, (1280, 720))
    + ' Intrinsic of "Fisheye 1" / 848x800 / {Y8}\n'
    + _realsense_lines(NUMBERS, "Kannala Brandt4", [*FISH, 0.0], SIZE)
    + '\nExtrinsic Parameters:\nExtrinsic from "Depth"\t  To\t  "Color" :\n Rotation Matrix:\n'
    + "   0.99999\t 0.0\t 0.0 \n   0.0\t 0.99999\t 0.0\n   0.0\t 0.0\t 0.99999\n\n Translation Vector: -0.059  0  0\n"
)
INTRINSICS = {"width": 640, "height": 480, "fx": FX, "fy": FY, "ppx": CX, "ppy": CY}
PYREALSENSE = {
    "depth": {"intrinsics": INTRINSICS | {"fx": 385.1, "model": "distortion.brown_conrady", "coeffs": [0.0] * 5}},
    "color": {"intrinsics": INTRINSICS | {"model": "distortion.inverse_brown_conrady", "coeffs": BROWN}},
}


def _socket(kind: int, coefficients: list[float]) -> dict[str, object]:
    place = {"x": -7.5, "y": 0.0, "z": 0.0}
    turn = {"rotationMatrix": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "toCameraSocket": 2}
    return {
        "cameraType": kind,
        "distortionCoeff": coefficients + [0.0] * (14 - len(coefficients)),
        "extrinsics": turn | {"specTranslation": place, "translation": place},
        "height": 480,
        "intrinsicMatrix": [K[:3], K[3:6], K[6:]],
        "lensPosition": 135,
        "specHfovDeg": 68.7938003540039,
        "width": 640,
    }


EEPROM = {
    "batchName": "",
    "boardName": "OAK-D",
    "cameraData": [[0, _socket(0, RATIONAL)], [1, _socket(1, FISH)], [2, _socket(3, FISH)]],
    "imuExtrinsics": {"rotationMatrix": [[0.0] * 3] * 3, "toCameraSocket": -1, "translation": {"x": 0.0}},
    "stereoRectificationData": {"leftCameraSocket": 1, "rectifiedRotationLeft": [K[:3], K[3:6], [0.0, 0.0, 1.0]]},
    "version": 7,
}
NERF = {"fl_x": FX, "fl_y": FY, "cx": CX + 0.5, "cy": CY + 0.5, "w": 640, "h": 480}
FRAMES = {"frames": [{"file_path": "images/0.png", "transform_matrix": np.eye(4).tolist()}]}
COLMAP = f"""# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 5
1 OPENCV_FISHEYE 640 480 {FX} {FY} {CX + 0.5} {CY + 0.5} {" ".join(map(str, FISH))}
2 FULL_OPENCV 640 480 {FX} {FY} {CX + 0.5} {CY + 0.5} {" ".join(map(str, RATIONAL))}
3 SIMPLE_RADIAL 640 480 {FX} {CX + 0.5} {CY + 0.5} {BROWN[0]}
4 RADIAL_FISHEYE 640 480 {FX} {CX + 0.5} {CY + 0.5} {FISH[0]} {FISH[1]}
5 FOV 640 480 {FX} {FY} {CX + 0.5} {CY + 0.5} 0.9
"""
_MODELS = {"OPENCV_FISHEYE": 5, "FULL_OPENCV": 6, "SIMPLE_RADIAL": 2, "RADIAL_FISHEYE": 9, "FOV": 7}


def _binary(text: str) -> bytes:
    lines = [line.split() for line in text.splitlines() if not line.startswith("#")]
    written = [struct.pack("<Q", len(lines))]
    for number, model, width, height, *parameters in lines:
        written.append(struct.pack("<iiQQ", int(number), _MODELS[model], int(width), int(height)))
        written.append(struct.pack(f"<{len(parameters)}d", *map(float, parameters)))
    return b"".join(written)


COLUMNS = [FX, 0.0, 0.0, 0.0, FY, 0.0, CX, CY, 1.0]
RECORD3D = {
    "K": COLUMNS, "w": 640, "h": 480, "dw": 192, "dh": 256, "fps": 60, "cameraType": 1, "frameTimestamps": [0.0],
    "perFrameIntrinsicCoeffs": [[FX + 0.5, FY, CX, CY]], "poses": [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]],
}  # fmt: skip
POLYCAM = {
    "fx": FX, "fy": FY, "cx": CX, "cy": CY, "width": 640, "height": 480, "blur_score": 91.2, "timestamp": 123456,
    "angular_velocity": 0.1, "center_depth": 1.5, "manual_keyframe": False, "neighbors": [1, 2, 3],
    **{f"t_{row}{column}": float(row == column) for row in range(3) for column in range(4)},
}  # fmt: skip
SCANNER_APP = {
    "intrinsics": K, "frame_index": 0, "time": 9.5, "averageAngularVelocity": 0.1, "exposureDuration": 0.01,
    "projectionMatrix": [1.6, 0, -0.003, 0, 0, 2.2, -0.002, 0, 0, 0, -1.0, -0.001, 0, 0, -1, 0],
    "cameraPoseARFrame": [0.0, 1, 0, 0.2, -1, 0, 0, 0.4, 0, 0, 1, -0.1, 0, 0, 0, 1],
}  # fmt: skip
STRAY = "".join(", ".join(map(str, K[3 * row : 3 * row + 3])) + "\n" for row in range(3))

VINS = f"""%YAML:1.0
---
model_type: KANNALA_BRANDT
camera_name: camera
image_width: 640
image_height: 480
projection_parameters:
   k2: {FISH[0]}
   k3: {FISH[1]}
   k4: {FISH[2]}
   k5: {FISH[3]}
   mu: {FX}
   mv: {FY}
   u0: {CX}
   v0: {CY}
"""
MEI = """%YAML:1.0
---
model_type: MEI
camera_name: camera
mirror_parameters:
   xi: 1.89
projection_parameters:
   gamma1: 893.0
   gamma2: 894.0
   u0: 320.5
   v0: 241.5
"""

PLAIN, ONE_FOCAL = [], [FX, FX, CX, CY]
MADE = {
    "ROS calibration": ("ost.yaml", CALIBRATION.format(model="plumb_bob", count=5, coefficients=BROWN), "", BROWN),
    "ROS rational": (
        "ost.yaml", CALIBRATION.format(model="rational_polynomial", count=8, coefficients=RATIONAL), "", RATIONAL
    ),
    "ROS fisheye": ("ost.yaml", CALIBRATION.format(model="equidistant", count=4, coefficients=FISH), "", FISH),
    "rostopic echo": ("info.yaml", ECHO_1 * 2, "", BROWN),
    "ros2 topic echo": ("info.txt", ECHO_2 * 2, "", FISH),
    "ORB-SLAM2": ("TUM1.yaml", ORB_SLAM_2, "", BROWN),
    "ORB-SLAM3": ("TUM-VI.yaml", ORB_SLAM_3, "Camera1", FISH),
    "Kalibr fisheye": ("camchain.yaml", KALIBR, "cam0", FISH),
    "Kalibr": ("camchain.yaml", KALIBR, "cam1", BROWN[:4]),
    "VINS fisheye": ("cam0.yaml", VINS, "", FISH),
    "RealSense text": ("d455.txt", REALSENSE, "color_640x480", BROWN),
    "RealSense text, blank": ("d455.csv", REALSENSE, "Fisheye 1", FISH),
    "RealSense": ("d455.json", json.dumps(PYREALSENSE), "color", BROWN),
    "OAK": ("oak.json", json.dumps(EEPROM), "CAM_A", RATIONAL),
    "OAK fisheye": ("oak.json", json.dumps(EEPROM), "cam_b", FISH),
    "nerfstudio": (
        "transforms.json", json.dumps({**NERF, "camera_model": "OPENCV", "k1": BROWN[0], "k2": BROWN[1],
                                       "p1": BROWN[2], "p2": BROWN[3], **FRAMES}), "", BROWN[:4]
    ),
    "nerfstudio fisheye": (
        "transforms.json", json.dumps({**NERF, "camera_model": "OPENCV_FISHEYE", "k1": FISH[0], "k2": FISH[1],
                                       "k3": FISH[2], "k4": FISH[3], **FRAMES}), "", FISH
    ),
    "COLMAP fisheye": ("cameras.txt", COLMAP, "1", FISH),
    "COLMAP rational": ("cameras.txt", COLMAP, "2", RATIONAL),
    "COLMAP radial": ("cameras.txt", COLMAP, "3", BROWN[:1], ONE_FOCAL),
    "COLMAP radial fisheye": ("cameras.txt", COLMAP, "4", FISH[:2], ONE_FOCAL),
    "COLMAP binary fisheye": ("cameras.bin", _binary(COLMAP), "1", FISH),
    "COLMAP binary rational": ("cameras.bin", _binary(COLMAP), "2", RATIONAL),
    "COLMAP binary radial": ("cameras.bin", _binary(COLMAP), "3", BROWN[:1], ONE_FOCAL),
    "Record3D": ("metadata", json.dumps(RECORD3D), "", PLAIN),
    "Polycam": ("1234.json", json.dumps(POLYCAM), "", PLAIN),
    "3D Scanner App": ("frame_00000.json", json.dumps(SCANNER_APP), "", PLAIN),
    "Stray Scanner": ("camera_matrix.csv", STRAY, "", PLAIN),
}  # fmt: skip


def _checked(spec: str, coefficients: list[float], numbers: list[float], is_fisheye: bool) -> None:
    camera, notes = lens_from(spec, SIZE[::-1])
    assert notes == ()
    assert camera.numbers == pytest.approx(numbers, abs=1e-6)
    assert camera.model == ("fisheye" if is_fisheye else "pinhole")
    found = np.zeros(14)
    found[: len(camera.distortion)] = camera.distortion
    assert found == pytest.approx(np.pad(coefficients, (0, 14 - len(coefficients))), abs=1e-6)


@pytest.mark.parametrize("maker", MADE)
def test_a_makers_camera_is_read_with_its_lens(tmp_path, maker):
    name, content, entry, coefficients, numbers = (*MADE[maker], NUMBERS)[:5]
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    spec, is_fisheye = f"{path}#{entry}" if entry else str(path), coefficients[:1] == FISH[:1]
    _checked(spec, coefficients, numbers, is_fisheye)
    camera, notes = frame_camera(spec, SIZE[::-1])
    assert (camera is None) == is_fisheye
    assert "Undistort the frame on reading" in notes[0] if coefficients else notes == ()


@pytest.mark.parametrize("suffix", ["yaml", "xml", "json"])
@pytest.mark.parametrize("coefficients", [BROWN, RATIONAL, FISH], ids=["Brown", "rational", "fisheye"])
def test_what_opencv_writes_is_read(tmp_path, suffix, coefficients):
    path = tmp_path / f"camera.{suffix}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in (("image_width", 640), ("image_height", 480), ("fisheye_model", int(coefficients is FISH))):
        storage.write(name, value)
    storage.write("camera_matrix", np.reshape(K, (3, 3)))
    storage.write("distortion_coefficients", np.array(coefficients)[:, None])
    storage.write("avg_reprojection_error", 0.25)
    storage.release()
    _checked(str(path), coefficients, NUMBERS, coefficients is FISH)


@pytest.mark.parametrize(
    ("maker", "names", "example"),
    [
        ("ORB-SLAM3", "Camera1 or Camera2", "Camera1"),
        ("Kalibr", "cam0 or cam1 or cam2", "cam0"),
        ("RealSense text", "Depth/640x480 or Infrared_1/640x480 or Color/640x480 or Color/1280x720", "Depth/640x480"),
        ("RealSense", "depth/intrinsics or color/intrinsics", "depth/intrinsics"),
        ("OAK", "cameraData/CAM_A or cameraData/CAM_B or cameraData/CAM_C", "cameraData/CAM_A"),
        ("COLMAP binary radial", "1 or 2 or 3 or 4 or 5", "1"),
    ],
)
def test_several_cameras_are_named_with_what_to_write(tmp_path, maker, names, example):
    name, content, *_ = MADE[maker]
    path = tmp_path / f"a#{name}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as caught:
        frame_camera(str(path), SIZE[::-1])
    assert f"{names}" in str(caught.value)
    assert str(caught.value).endswith(f"{path}#{example}.")
    assert frame_camera(f"{path}#{example}", SIZE[::-1])[1] is not None


@pytest.mark.parametrize(
    ("maker", "entry", "lens"),
    [("Kalibr", "cam2", "omni"), ("OAK", "CAM_C", "radial division"), ("COLMAP binary radial", "5", "FOV")],
)
def test_other_lenses_are_refused_by_name(tmp_path, maker, entry, lens):
    name, content, *_ = MADE[maker]
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=f"lens model '{lens}.*is not supported"):
        lens_from(f"{tmp_path / name}#{entry}", SIZE[::-1])


def test_a_lens_without_a_focal_length_is_refused_by_its_name(tmp_path):
    (tmp_path / "mei.yaml").write_text(MEI)
    with pytest.raises(InputError, match="lens model 'MEI' is not supported"):
        lens_from(str(tmp_path / "mei.yaml"), SIZE[::-1])
    camera, notes = frame_camera(str(tmp_path / "mei.yaml"), SIZE[::-1])
    assert camera is None
    assert "'MEI' is not supported" in notes[0]


def test_a_camera_of_another_size_is_scaled_with_its_lens_or_refused(tmp_path):
    (tmp_path / "d455.txt").write_text(REALSENSE)
    camera, notes = lens_from(f"{tmp_path / 'd455.txt'}#color_1280x720", (360, 640))
    assert camera.numbers == pytest.approx((FX, FY, 322.5, 180.375), abs=1e-6)
    assert camera.distortion == pytest.approx(BROWN, abs=1e-6)
    assert "1280 x 720 pixels, and are scaled" in notes[0]
    with pytest.raises(InputError, match="another aspect ratio"):
        lens_from(f"{tmp_path / 'd455.txt'}#color_1280x720", (480, 640))


@pytest.mark.parametrize(
    "content", [b"", _binary(COLMAP)[:-9], struct.pack("<Q", 2**60), struct.pack("<QiiQQ", 1, 1, 99, 2, 2)]
)
def test_a_damaged_binary_is_one_sentence(tmp_path, content):
    (tmp_path / "cameras.bin").write_bytes(content)
    with pytest.raises(FormatError, match=r"cameras\.bin"):
        lens_from(str(tmp_path / "cameras.bin"), SIZE[::-1])
