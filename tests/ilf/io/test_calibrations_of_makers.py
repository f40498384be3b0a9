"""The cameras of eight makers' files, each written as the maker does: numbers, size, lens and coefficients to 1e-6."""

import shutil
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

from ilf.errors import FormatError, InputError
from ilf.io.cameras import frame_camera, lens_from

CAMERAS = Path(__file__).with_name("cameras")

NUMBERS = [611.437256, 610.982117, 322.751648, 241.119385]
FX, FY, CX, CY = NUMBERS
K = [FX, 0.0, CX, 0.0, FY, CY, 0.0, 0.0, 1.0]
BROWN = [0.1234567, -0.2345678, 0.0012345, -0.0023456, 0.0345678]
RATIONAL = [*BROWN, 0.0456789, -0.0567891, 0.0067891]
FISH = [0.0312345, -0.0123456, 0.0034567, -0.0009876]
SIZE = (640, 480)

PLAIN, ONE_FOCAL = [], [FX, FX, CX, CY]
MADE = {
    "ROS calibration": ("ros/ost.yaml", "", BROWN),
    "ROS rational": ("ros-rational/ost.yaml", "", RATIONAL),
    "ROS fisheye": ("ros-fisheye/ost.yaml", "", FISH),
    "rostopic echo": ("rostopic/info.yaml", "", BROWN),
    "ros2 topic echo": ("ros2-topic/info.txt", "", FISH),
    "ORB-SLAM2": ("orb-slam2/TUM1.yaml", "", BROWN),
    "ORB-SLAM3": ("orb-slam3/TUM-VI.yaml", "Camera1", FISH),
    "Kalibr fisheye": ("kalibr/camchain.yaml", "cam0", FISH),
    "Kalibr": ("kalibr/camchain.yaml", "cam1", BROWN[:4]),
    "VINS fisheye": ("vins/cam0.yaml", "", FISH),
    "RealSense text": ("realsense/d455.txt", "color_640x480", BROWN),
    "RealSense text, blank": ("realsense/d455.txt", "Fisheye 1", FISH),
    "RealSense": ("realsense/d455.json", "color", BROWN),
    "OAK": ("oak/oak.json", "CAM_A", RATIONAL),
    "OAK fisheye": ("oak/oak.json", "cam_b", FISH),
    "nerfstudio": ("nerfstudio/transforms.json", "", BROWN[:4]),
    "nerfstudio fisheye": ("nerfstudio-fisheye/transforms.json", "", FISH),
    "COLMAP fisheye": ("colmap/cameras.txt", "1", FISH),
    "COLMAP rational": ("colmap/cameras.txt", "2", RATIONAL),
    "COLMAP radial": ("colmap/cameras.txt", "3", BROWN[:1], ONE_FOCAL),
    "COLMAP radial fisheye": ("colmap/cameras.txt", "4", FISH[:2], ONE_FOCAL),
    "COLMAP binary fisheye": ("colmap/cameras.bin", "1", FISH),
    "COLMAP binary rational": ("colmap/cameras.bin", "2", RATIONAL),
    "COLMAP binary radial": ("colmap/cameras.bin", "3", BROWN[:1], ONE_FOCAL),
    "Record3D": ("record3d/metadata", "", PLAIN),
    "Polycam": ("polycam/1234.json", "", PLAIN),
    "3D Scanner App": ("3d-scanner-app/frame_00000.json", "", PLAIN),
    "Stray Scanner": ("stray-scanner/camera_matrix.csv", "", PLAIN),
}
"""File in `cameras`, the camera in it, its coefficients, and its numbers if they are others than `NUMBERS`."""
RENAMED = {"RealSense text, blank": "d455.csv"}


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
    file, entry, coefficients, numbers = (*MADE[maker], NUMBERS)[:4]
    path = shutil.copy(CAMERAS / file, tmp_path / RENAMED.get(maker, Path(file).name))
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
    file = CAMERAS / MADE[maker][0]
    path = shutil.copy(file, tmp_path / f"a#{file.name}")
    with pytest.raises(InputError) as caught:
        frame_camera(str(path), SIZE[::-1])
    assert f"{names}" in str(caught.value)
    assert str(caught.value).endswith(f"{path}#{example}.")
    assert frame_camera(f"{path}#{example}", SIZE[::-1])[1] is not None


@pytest.mark.parametrize(
    ("maker", "entry", "lens"),
    [("Kalibr", "cam2", "omni"), ("OAK", "CAM_C", "radial division"), ("COLMAP binary radial", "5", "FOV")],
)
def test_other_lenses_are_refused_by_name(maker, entry, lens):
    with pytest.raises(InputError, match=f"lens model '{lens}.*is not supported"):
        lens_from(f"{CAMERAS / MADE[maker][0]}#{entry}", SIZE[::-1])


def test_a_lens_without_a_focal_length_is_refused_by_its_name():
    with pytest.raises(InputError, match="lens model 'MEI' is not supported"):
        lens_from(str(CAMERAS / "vins/mei.yaml"), SIZE[::-1])
    camera, notes = frame_camera(str(CAMERAS / "vins/mei.yaml"), SIZE[::-1])
    assert camera is None
    assert "'MEI' is not supported" in notes[0]


def test_a_camera_of_another_size_is_scaled_with_its_lens_or_refused():
    spec = f"{CAMERAS / 'realsense/d455.txt'}#color_1280x720"
    camera, notes = lens_from(spec, (360, 640))
    assert camera.numbers == pytest.approx((FX, FY, 322.5, 180.375), abs=1e-6)
    assert camera.distortion == pytest.approx(BROWN, abs=1e-6)
    assert "1280 x 720 pixels, and are scaled" in notes[0]
    with pytest.raises(InputError, match="another aspect ratio"):
        lens_from(spec, (480, 640))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        (CAMERAS / "colmap/cameras.bin").read_bytes()[:-9],
        struct.pack("<Q", 2**60),
        struct.pack("<QiiQQ", 1, 1, 99, 2, 2),
    ],
)
def test_a_damaged_binary_is_one_sentence(tmp_path, content):
    (tmp_path / "cameras.bin").write_bytes(content)
    with pytest.raises(FormatError, match=r"cameras\.bin"):
        lens_from(str(tmp_path / "cameras.bin"), SIZE[::-1])
