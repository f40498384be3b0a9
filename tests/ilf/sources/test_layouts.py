"""Layouts as data: every published one on files named and encoded as published, given ones, and what does not fit."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import cv2
import h5py
import numpy as np
import OpenEXR
import pytest

import ilf
from ilf.cli import main
from ilf.errors import DepthWarning, FormatError, InputError, ParameterError
from ilf.io.encodings import encoding_of
from ilf.sources.layout import layouts_from_file
from ilf.sources.layouts import all_layouts, built_in_layouts

H, W = 48, 64
METRES = (1.5 + 0.007 * np.arange(W)[None] + 0.02 * np.arange(H)[:, None]).astype(np.float32)
METRES[10:20, 30:40] = 0
TRUTH = np.where(METRES == 0, 2.25, METRES).astype(np.float32)
K = np.array([[60.0, 0, 31.5], [0, 60.0, 23.5], [0, 0, 1]])
POSE = np.array([[0, 0, 1, 1], [-1, 0, 0, 2], [0, -1, 0, 3], [0, 0, 0, 1]], float)
"""From the camera, y down, to the world."""
Y_UP = np.diag([1.0, -1, -1, 1])


@pytest.fixture(autouse=True)
def no_own_layouts(tmp_path, monkeypatch):
    monkeypatch.setenv("ILF_LAYOUTS", str(tmp_path / "own-layouts"))
    return tmp_path / "own-layouts"


def _write(path: Path, values: np.ndarray, units: float = 1.0, key: str = "dataset") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    stored = values * np.float32(units)
    if path.suffix == ".npy":
        np.save(path, stored[..., None])
    elif path.suffix == ".exr":
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        channel = stored.astype(np.float32)
        OpenEXR.File(header, {"RGB": np.repeat(channel[..., None], 3, axis=2)}).write(str(path))
    elif path.suffix == ".hdf5":
        with h5py.File(path, "w") as file:
            file[key] = stored.astype(np.float16)
    else:
        cv2.imwrite(str(path), np.rint(stored).astype(np.uint16))


def _colour(path: Path, shape: tuple[int, int] = (H, W)) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full((*shape, 3), 90, np.uint8))


def _text(path: Path, values: np.ndarray | str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(values) if isinstance(values, str) else np.savetxt(path, values)


def _frame(
    folder: Path, colour: str, depth: str, units: float = 1000, truth: str = "", pose: dict | None = None
) -> None:
    """Colour, depth, and if they have names, the ground truth and a file of the pose."""
    _colour(folder / colour)
    _write(folder / depth, METRES, units)
    if truth:
        _write(folder / truth, TRUTH, units)
    for name, matrix in (pose or {}).items():
        _text(folder / name, matrix)


def _square(matrix: np.ndarray) -> np.ndarray:
    return np.block([[matrix, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])


def _poses(count: int) -> list[np.ndarray]:
    return [POSE + number * np.eye(4, k=3) for number in range(count)]


# What the data sets publish. Each writes two frames; the second pose is one metre further in x.


def _scannet(root: Path) -> None:
    scene = root / "scans/scene0000_00"
    wide = np.array([[121.5, 0, 60.25], [0, 121.5, 47.75], [0, 0, 1]])
    for number, pose in enumerate(_poses(2)):
        _colour(scene / f"color/{number}.jpg", (96, 128))
        _write(scene / f"depth/{number}.png", METRES, 1000)
        _text(scene / f"pose/{number}.txt", pose)
    _text(scene / "intrinsic/intrinsic_color.txt", _square(wide))
    _text(scene / "intrinsic/intrinsic_depth.txt", _square(K))


def _kitti_selection(root: Path) -> None:
    for number in (5, 8):
        drive, end = "2011_09_26_drive_0002_sync", f"{number:010d}_image_02"
        truth = f"groundtruth_depth/{drive}_groundtruth_depth_{end}.png"
        _frame(root, f"image/{drive}_image_{end}.png", f"velodyne_raw/{drive}_velodyne_raw_{end}.png", 256, truth)
        _text(root / f"intrinsics/{drive}_image_{end}.txt", " ".join(map(str, K.ravel())))


def _kitti(root: Path) -> None:
    drive = "2011_09_26_drive_0001_sync"
    for number in (5, 6):
        for camera in ("02", "03"):
            _colour(root / f"2011_09_26/{drive}/image_{camera}/data/{number:010d}.png")
        _write(root / f"train/{drive}/proj_depth/velodyne_raw/image_02/{number:010d}.png", METRES, 256)
        _write(root / f"train/{drive}/proj_depth/groundtruth/image_02/{number:010d}.png", TRUTH, 256)
    projection = " ".join(f"{value:e}" for value in np.c_[K, [44.0, 0.2, 0.003]].ravel())
    _text(
        root / "2011_09_26/calib_cam_to_cam.txt",
        f"calib_time: 09-Jan-2012 13:57:47\nP_rect_00: {'1 ' * 12}\nP_rect_02: {projection}\n",
    )


def _void(root: Path) -> None:
    scene = root / "void_1500/data/classroom0"
    for time, pose in zip(("1552625028.2387", "1552625028.3387"), _poses(2), strict=True):
        colour, depth, truth = (f"{kind}/{time}.png" for kind in ("image", "sparse_depth", "ground_truth"))
        _frame(scene, colour, depth, 256, truth, {f"absolute_pose/{time}.txt": pose[:3]})
        _write(scene / f"validity_map/{time}.png", (METRES > 0).astype(np.float32))
    _text(scene / "K.txt", K)


_PANORAMA = "0b02e18654324edd8d74c078b66bfb20"


def _matterport(root: Path) -> None:
    house = root / "17DRP5sb8fy"
    for yaw, pose in enumerate(_poses(2)):
        colour, depth = (f"matterport_{kind}_images/{_PANORAMA}" for kind in ("color", "depth"))
        placed = {f"matterport_camera_poses/{_PANORAMA}_pose_1_{yaw}.txt": pose}
        _frame(house, f"{colour}_i1_{yaw}.jpg", f"{depth}_d1_{yaw}.png", 4000, pose=placed)
    _text(
        house / f"matterport_camera_intrinsics/{_PANORAMA}_intrinsics_1.txt",
        f"{W} {H} 60 60 31.5 23.5 0.04 -0.16 0.0006 -0.0005 0.0",
    )


def _matterport_undistorted(root: Path) -> None:
    folder = root / "17DRP5sb8fy"
    lines = ["dataset matterport", "n_images 2", "depth_directory undistorted_depth_images"]
    lines += ["color_directory undistorted_color_images", "intrinsics_matrix 1280 0 639.5  0 1280 511.5  0 0 1"]
    for yaw, pose in enumerate(_poses(2)):
        colour, depth = f"{_PANORAMA}_i0_{yaw}.jpg", f"{_PANORAMA}_d0_{yaw}.png"
        _colour(folder / "undistorted_color_images" / colour, (64, 80))
        _write(folder / "undistorted_depth_images" / depth, np.pad(METRES, ((0, 16), (0, 16))), 4000)
        lines.append(f"scan {depth} {colour} {' '.join(map(str, (pose @ Y_UP).ravel()))}")
    _text(folder / "undistorted_camera_parameters/17DRP5sb8fy.conf", "\n".join(lines))


def _rays() -> np.ndarray:
    fx = 886.8100134752653 * W / 1024
    x, y = (np.arange(W) - 31.5) / fx, (np.arange(H) - 23.5) / fx
    return np.sqrt(1 + x**2 + y[:, None] ** 2)


def _hypersim(root: Path) -> None:
    images = root / "ai_001_001/images"
    for number in range(2):
        _colour(images / f"scene_cam_00_final_preview/frame.{number:04d}.tonemap.jpg")
        _colour(images / f"scene_cam_00_final_preview/frame.{number:04d}.color.jpg")
        _write(images / f"scene_cam_00_geometry_hdf5/frame.{number:04d}.depth_meters.hdf5", METRES * _rays())
        _write(images / f"scene_cam_00_geometry_hdf5/frame.{number:04d}.semantic.hdf5", METRES)


def _dreds(root: Path) -> None:
    for number in range(2):
        at = root / f"DREDS-CatKnown/test/00000/{number:04d}"
        _colour(at.with_name(f"{at.name}_color.png"), (45, 80))
        padded = np.pad(METRES[:45], ((0, 0), (0, 16)), constant_values=1.5)
        _write(at.with_name(f"{at.name}_simDepthImage.exr"), padded)
        _write(at.with_name(f"{at.name}_depth_120.exr"), np.where(padded == 0, 2.25, padded))


def _diode(root: Path) -> None:
    for number in (10, 20):
        at = root / f"val/indoors/scene_00019/scan_00183/00019_00183_indoors_000_{number:03d}"
        _colour(at.with_name(f"{at.name}.png"))
        _write(at.with_name(f"{at.name}_depth.npy"), TRUTH)
        np.save(at.with_name(f"{at.name}_depth_mask.npy"), (METRES > 0).astype(np.float64))


def _transcg(root: Path) -> None:
    for number in range(2):
        folder = root / f"scene1/{number}"
        for camera, units in (("1", 1000), ("2", 4000)):
            _frame(folder, f"rgb{camera}.png", f"depth{camera}.png", units, f"depth{camera}-gt.png")
            _write(folder / f"depth{camera}-gt-mask.png", METRES)
    (root / "camera_intrinsics").mkdir()
    for name in ("D435", "L515"):
        np.save(root / f"camera_intrinsics/camIntrinsics-{name}.npy", K)


def _cleargrasp(root: Path) -> None:
    folder = root / "real-test/d435"
    for number in range(2):
        start = f"{number:09d}"
        _colour(folder / f"{start}-transparent-rgb-img.jpg")
        _colour(folder / f"{start}-opaque-rgb-img.jpg")
        _write(folder / f"{start}-transparent-depth-img.exr", METRES)
        _write(folder / f"{start}-opaque-depth-img.exr", TRUTH)
    _text(folder / "camera_intrinsics.yaml", f"# D435\nxres: {W}\nyres: {H}\nfx: 60.0\nfy: 60.0\ncx: 31.5\ncy: 23.5\n")


def _transforms(root: Path, depth: bool = True) -> None:
    frames = []
    for number, pose in enumerate(_poses(2)):
        _frame(root, f"images/{number:05d}.jpg", f"depth/{number:05d}.png")
        frame = {"file_path": f"./images/{number:05d}.jpg", "transform_matrix": (pose @ Y_UP).tolist()}
        frames.append(frame | ({"depth_file_path": f"depth/{number:05d}.png"} if depth else {}))
    camera = {"camera_model": "OPENCV", "fl_x": 60, "fl_y": 60, "cx": 32.0, "cy": 24.0, "w": W, "h": H}
    _text(root / "transforms.json", json.dumps(camera | {"frames": frames}))


def _replica(root: Path) -> None:
    for number in range(2):
        _frame(root / "room0/results", f"frame{number:06d}.jpg", f"depth{number:06d}.png", 6553.5)
    _text(root / "room0/traj.txt", np.array([pose.ravel() for pose in _poses(2)]))
    camera = {"w": W, "h": H, "fx": 60.0, "fy": 60.0, "cx": 31.5, "cy": 23.5, "scale": 6553.5}
    _text(root / "cam_params.json", json.dumps({"camera": camera}))


def _open3d(root: Path) -> None:
    log = ""
    for number, pose in enumerate(_poses(2)):
        _frame(root, f"color/{number:06d}.jpg", f"depth/{number:06d}.png")
        rows = "\n".join(" ".join(map(str, row)) for row in pose)
        log += f"{number} {number} {number + 1}\n{rows}\n"
    _text(root / "trajectory.log", log)
    camera = {"width": W, "height": H, "intrinsic_matrix": K.T.ravel().tolist()}
    _text(root / "camera.json", json.dumps(camera))


def _isaac(root: Path, camera: str = "", depth: str = "distance_to_image_plane") -> None:
    """As Replicator's BasicWriter writes it: one camera in a folder, or the kinds of images of several in folders."""
    at = {kind: root / camera / kind if camera else root for kind in ("rgb", depth, "camera_params")}
    lens = {"cameraAperture": [20.955, 15.7], "cameraFocalLength": 20.0, "renderProductResolution": [W, H]}
    fx = 20 / 20.955 * W
    x, y = (np.arange(W) - 31.5) / fx, (np.arange(H) - 23.5) / fx
    longer = np.sqrt(1 + x**2 + y[:, None] ** 2) if depth == "distance_to_camera" else 1
    for number in range(2):
        _colour(at["rgb"] / f"rgb_{number:04d}.png")
        _write(
            at[depth] / f"{depth}_{number:04d}.npy", np.where(METRES > 0, METRES * longer, np.inf).astype(np.float32)
        )
        _text(at["camera_params"] / f"camera_params_{number:04d}.json", json.dumps(lens))


def _polycam(root: Path, corrected: str = "corrected_") -> None:
    for number, pose in enumerate(_poses(2)):
        folder, name = root / "keyframes", f"{144200852560 + number}"
        _colour(folder / f"{corrected}images/{name}.jpg")
        _write(folder / f"depth/{name}.png", METRES, 1000)
        _write(folder / f"confidence/{name}.png", np.full((H, W), 255))
        lens = {"fx": 60.0, "fy": 60.0, "cx": 31.5, "cy": 23.5, "width": W, "height": H, "blur_score": 80.1}
        rows = {f"t_{row}{column}": (pose @ Y_UP)[row, column] for row in range(3) for column in range(4)}
        _text(folder / f"{corrected}cameras/{name}.json", json.dumps(lens | rows))


def _info(root: Path, at: str = "", name: str = "_info.txt") -> None:
    """Frames with the two cameras in a file of the scene, beside them or above their folder."""
    scene = root / "scan"
    for number, pose in enumerate(_poses(2)):
        start = f"{at}frame-{number:06d}"
        _frame(scene, f"{start}.color.jpg", f"{start}.depth.{'png' if at else 'pgm'}", pose={f"{start}.pose.txt": pose})
    rows = " ".join(map(str, _square(K).ravel()))
    kinds = "".join(f"m_calibration{kind}Intrinsic = {rows} \n" for kind in ("Color", "Depth"))
    _text(scene / name, f"m_versionNumber = 4\nm_colorWidth = {W}\nm_depthShift = 1000\n{kinds}m_frames.size = 2\n")


def _three_d_match(root: Path) -> None:
    for number, pose in enumerate(_poses(2)):
        start = f"seq-01/frame-{number:06d}"
        _frame(root / "scene", f"{start}.color.png", f"{start}.depth.png", pose={f"{start}.pose.txt": pose})
    _text(root / "scene/camera-intrinsics.txt", K)


def _nyu_sync(root: Path) -> None:
    for number in (45, 46):
        _frame(root / "bathroom", f"rgb_{number:05d}.jpg", f"sync_depth_{number:05d}.png")


def _ycb_video(root: Path) -> None:
    for number in (1, 2):
        _frame(root / "data/0000", f"{number:06d}-color.png", f"{number:06d}-depth.png", 10000)
        _write(root / f"data/0000/{number:06d}-label.png", METRES)
        _text(root / f"data/0000/{number:06d}-meta.mat", "MATLAB 5.0 MAT-file")


def _virtual_kitti(root: Path) -> None:
    """Centimetres; the sky is 655.35 m."""
    far = np.pad(np.where(METRES > 0, METRES, 655.35), ((0, 0), (0, 95)), constant_values=30).astype(np.float32)
    for number in range(2):
        _colour(root / f"Scene01/clone/frames/rgb/Camera_0/rgb_{number:05d}.jpg", far.shape)
        _write(root / f"Scene01/clone/frames/depth/Camera_0/depth_{number:05d}.png", far * 100)


def _tartanair(root: Path) -> None:
    for number in range(2):
        _frame(root / "P000", f"image_left/{number:06d}_left.png", f"depth_left/{number:06d}_left_depth.npy", 1)


def _virtual_kitti_1(root: Path) -> None:
    far = np.where(METRES > 0, METRES, 655.35)
    for number in range(2):
        name = f"0001/clone/{number:05d}.png"
        _frame(root, f"vkitti_1.3.1_rgb/{name}", f"vkitti_1.3.1_depthgt/{name}")
        _write(root / f"vkitti_1.3.1_depthgt/{name}", np.pad(far, ((0, 0), (0, 95)), constant_values=30), 100)
        _colour(root / f"vkitti_1.3.1_rgb/{name}", (H, W + 95))


def _tartanair_v2(root: Path) -> None:
    """The four bytes of a float32, as blue, green, red and opacity."""
    for number in range(2):
        name = f"{number:06d}_lcam_front"
        square = np.vstack((METRES, METRES[:16]))
        _colour(root / f"Data_easy/P000/image_lcam_front/{name}.png", square.shape)
        path = root / f"Data_easy/P000/depth_lcam_front/{name}_depth.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(path), square.astype("<f4").view(np.uint8).reshape(*square.shape, 4))


def _longer(fx: float, fy: float, cx: float, cy: float) -> np.ndarray:
    """Lengths of rays to the plane at 1 m."""
    x, y = (np.arange(W) - cx) / fx, (np.arange(H) - cy) / fy
    return np.sqrt(1 + x**2 + y[:, None] ** 2).astype(np.float32)


def _scenenet(root: Path) -> None:
    scale = W / 320
    camera = 277.12813 * scale, 289.70563 * scale, 160.5 * scale - 0.5, 120.5 * scale - 0.5
    for number in (0, 25):
        _colour(root / f"0/223/photo/{number}.jpg")
        _write(root / f"0/223/depth/{number}.png", METRES * _longer(*camera), 1000)
        _write(root / f"0/223/instance/{number}.png", METRES)


def _kubric(root: Path) -> None:
    """Kubric's file states a camera matrix in shares of the image and OpenGL's axes."""
    for number in range(2):
        _colour(root / f"rgba_{number:05d}.png")
        distance = METRES * _longer(W * 35 / 32, W * 35 / 32, (W - 1) / 2, (H - 1) / 2)
        _write(root / f"depth_{number:05d}.npy", distance)
        (root / f"depth_{number:05d}.npy").unlink()
        cv2.imwrite(str(root / f"depth_{number:05d}.tiff"), distance)
    matrix = [[35 / 32, 0, -0.5], [0, -35 / 24, -0.5], [0, 0, -1]]
    camera = {"focal_length": 35.0, "sensor_width": 32.0, "field_of_view": 0.857, "K": matrix, "R": np.eye(4).tolist()}
    _text(root / "metadata.json", json.dumps({"camera": camera, "metadata": {"width": W, "height": H}}))


def _taskonomy(root: Path, folder: str = "depth", end: str = "depth") -> None:
    for number in range(2):
        name = f"camera_0d60_conferenceRoom_1_frame_{number}_domain_"
        _frame(root, f"area_3/data/rgb/{name}rgb.png", f"area_3/data/{folder}/{name}{end}.png", 512)
        _write(root / f"area_3/data/{folder}/{name}{end}.png", np.where(METRES > 0, METRES, 65535 / 512), 512)
        pose = {"camera_k_matrix": K.tolist(), "camera_rt_matrix": POSE[:3].tolist(), "field_of_view_rads": 1.0}
        _text(root / f"area_3/data/pose/{name}pose.json", json.dumps(pose))


def _ibims(root: Path) -> None:
    for name in ("corridor_01", "corridor_02"):
        _frame(root, f"rgb/{name}.png", f"depth/{name}.png", 65535 / 50)
        _colour(root / f"mask_invalid/{name}.png")
        _colour(root / f"mask_transp/{name}.png")


def _bop_imagewise(root: Path) -> None:
    for number in range(2):
        _frame(root, f"000001_{number:06d}.rgb.jpg", f"000001_{number:06d}.depth.png", 10_000)
        camera = {"cam_K": K.ravel().tolist(), "depth_scale": 0.1}
        _text(root / f"000001_{number:06d}.camera.json", json.dumps(camera))


def _ho3d(root: Path) -> None:
    values = np.rint(METRES / 0.00012498664727900177).astype(np.uint16)
    for number in range(2):
        _frame(root, f"train/ABF10/rgb/{number:04d}.jpg", f"train/ABF10/depth/{number:04d}.png")
        channels = np.stack((0 * values, values >> 8, values & 255), axis=-1)  # blue, green, red
        cv2.imwrite(str(root / f"train/ABF10/depth/{number:04d}.png"), channels.astype(np.uint8))
        _text(root / f"train/ABF10/meta/{number:04d}.pkl", "a pickle")


def _co3d(root: Path) -> None:
    for number in (1, 2):
        place = root / "apple/110_13051_23361"
        _frame(place, f"images/frame{number:06d}.jpg", f"depths/frame{number:06d}.jpg.geometric.png")
        halves = METRES.astype(np.float16).view(np.uint16)
        cv2.imwrite(str(place / f"depths/frame{number:06d}.jpg.geometric.png"), halves)


def _point_odyssey(root: Path) -> None:
    for number in range(2):
        _frame(root, f"ani/rgbs/rgb_{number:05d}.jpg", f"ani/depths/depth_{number:05d}.png", 65.535)
    np.savez(root / "ani/anno.npz", intrinsics=K)


_WIDE = np.array([[120.0, 0, 63.5], [0, 120.0, 47.5], [0, 0, 1]])
"""The camera of colour of twice the size of depth."""


def _record3d_exr(root: Path) -> None:
    """The camera matrix is column by column, of the images of colour."""
    for number in range(2):
        _frame(root, f"EXR_RGBD/rgb/{number}.jpg", f"EXR_RGBD/depth/{number}.exr", 1)
    camera = {"K": K.T.ravel().tolist(), "w": W, "h": H, "fps": 30}
    _text(root / "EXR_RGBD/metadata.json", json.dumps(camera))


def _scannetpp(root: Path) -> None:
    stated = {}
    for number, pose in enumerate(_poses(2)):
        _colour(root / f"iphone/rgb/frame_{10 * number:06d}.jpg")
        _write(root / f"iphone/depth/frame_{10 * number:06d}.png", METRES, 1000)
        facts = {"timestamp": 0.1, "pose": np.eye(4).tolist(), "imu": {}, "aligned_pose": pose.tolist()}
        stated[f"frame_{10 * number:06d}"] = facts | {"intrinsic": K.tolist()}
    _text(root / "iphone/pose_intrinsic_imu.json", json.dumps(stated))


def _driving_stereo(root: Path, colour: str, depth: str) -> None:
    for number in (1, 2):
        _frame(root, f"{colour}/2018-07-11-14-48-5{number}.jpg", f"{depth}/2018-07-11-14-48-5{number}.png", 256)


def _scanner_app(root: Path) -> None:
    for number in range(2):
        _frame(root, f"frame_{number:05d}.jpg", f"depth_{number:05d}.png")
        _write(root / f"conf_{number:05d}.png", np.full((H, W), 2))
        _text(root / f"frame_{number:05d}.json", json.dumps({"intrinsics": K.ravel().tolist(), "frame_index": number}))


PUBLISHED: dict[str, tuple[Callable[[Path], None], float | None, bool, bool]] = {
    # writer, focal length in the frame, whether there is ground truth, and whether there are poses
    "kitti-selection": (_kitti_selection, 60.0, True, False),
    "kitti": (_kitti, 60.0, True, False),
    "void": (_void, 60.0, True, True),
    "matterport3d": (_matterport, 60.0, False, True),
    "matterport3d-undistorted": (_matterport_undistorted, 80.0, False, True),
    "hypersim": (_hypersim, 886.81 * W / 1024, False, False),
    "dreds": (_dreds, 446.31 * 80 / 640, True, False),
    "diode": (_diode, 886.81 * W / 1024, False, False),
    "transcg": (_transcg, 60.0, True, False),
    "cleargrasp": (_cleargrasp, 60.0, True, False),
    "isaac-sim": (_isaac, 20 / 20.955 * W, False, False),
    "isaac-sim-rays": (lambda root: _isaac(root, depth="distance_to_camera"), 20 / 20.955 * W, False, False),
    "isaac-sim-cameras": (lambda root: _isaac(root, "Replicator"), 20 / 20.955 * W, False, False),
    "isaac-sim-cameras-rays": (
        lambda root: _isaac(root, "Replicator", "distance_to_camera"),
        20 / 20.955 * W,
        False,
        False,
    ),
    "polycam": (_polycam, 60.0, False, True),
    "polycam-uncorrected": (lambda root: _polycam(root, ""), 60.0, False, True),
    "nerfstudio": (_transforms, 60.0, False, True),
    "replica": (_replica, 60.0, False, True),
    "open3d": (_open3d, 60.0, False, True),
    "bundlefusion": (_info, 60.0, False, True),
    "bundlefusion, above": (lambda root: _info(root, "data/", "info.txt"), 60.0, False, True),
    "nyu-sync": (_nyu_sync, 518.8579 * W / 640, False, False),
    "ycb-video": (_ycb_video, None, False, False),
    "virtual-kitti": (_virtual_kitti, 725.0087 * (W + 95) / 1242, False, False),
    "tartanair": (_tartanair, 320 * W / 640, False, False),
    "tartanair-v2": (_tartanair_v2, 320 * W / 640, False, False),
    "virtual-kitti-1": (_virtual_kitti_1, 725 * (W + 95) / 1242, False, False),
    "scenenet-rgbd": (_scenenet, 277.12813 * W / 320, False, False),
    "kubric": (_kubric, W * 35 / 32, False, False),
    "taskonomy": (_taskonomy, 60.0, False, False),
    "taskonomy, z-buffer": (lambda root: _taskonomy(root, "depth_zbuffer", "depth_zbuffer"), 60.0, False, False),
    "ibims-1": (_ibims, None, False, False),
    "bop-imagewise": (_bop_imagewise, 60.0, False, False),
    "ho-3d": (_ho3d, None, False, False),
    "co3d": (_co3d, None, False, False),
    "record3d-exr": (_record3d_exr, 60.0, False, False),
    "3d-scanner-app": (_scanner_app, 60.0, False, False),
    "scannetpp-iphone": (_scannetpp, 60.0, False, True),
    "driving-stereo": (
        lambda root: _driving_stereo(root, "left-image-half-size", "depth-map-half-size"),
        None,
        False,
        False,
    ),
    "driving-stereo, test": (
        lambda root: _driving_stereo(
            root, "test-left-image/left-image-full-size", "test-depth-map/depth-map-full-size"
        ),
        None,
        False,
        False,
    ),
    "driving-stereo-train": (
        lambda root: _driving_stereo(root, "train-left-image/2018-07-11", "train-depth-map/2018-07-11"),
        None,
        False,
        False,
    ),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_layouts_are_read_right_at_once(tmp_path, name):
    write, focal, has_truth, has_pose = PUBLISHED[name]
    write(tmp_path / "data")
    source = ilf.open_source(tmp_path / "data")
    assert (source.layout.partition(" ")[0], len(source)) == (name.partition(",")[0], 2), source.notes
    frame = source[1]
    height, width = min(H, frame.shape[0]), min(W, frame.shape[1])
    wanted = np.where(METRES == 0, np.nan, METRES)[:height, :width]
    assert np.allclose(frame.depth[:height, :width], wanted, atol=5e-3, equal_nan=True)
    assert (frame.intrinsics and frame.intrinsics.fx) == (focal and pytest.approx(focal, rel=1e-4))
    assert frame.plausibility_warnings == ()
    assert (frame.ground_truth is not None) == has_truth
    if has_truth:
        assert frame.ground_truth[15, 35] == pytest.approx(2.25, abs=2e-3)
    if has_pose:
        assert np.allclose(source.pose(source.keys[1]), _poses(2)[1])
        assert np.allclose(frame.pose, _poses(2)[1])
    else:
        assert frame.pose is None
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth if frame.invalid_mask is None else frame.measured, equal_nan=True)


@pytest.mark.parametrize("below", ["", "scene", "scene/seq-01"])
def test_frames_that_are_named_as_in_seven_scenes_have_their_own_camera(tmp_path, below):
    _three_d_match(tmp_path)
    source = ilf.open_source(tmp_path / below)
    assert (len(source), source[0].intrinsics.fx) == (2, 60.0)
    (tmp_path / "scene/camera-intrinsics.txt").unlink()
    assert ilf.open_source(tmp_path / below)[0].intrinsics.fx == pytest.approx(585 * W / 640)


@pytest.mark.parametrize(
    ("name", "scale", "units"),
    [("intrinsics.json", 0.0001, 10000), ("intrinsic.json", 4000.0, 4000), ("camera.json", None, 1000)],
)
def test_depth_has_the_scale_that_its_camera_states(tmp_path, name, scale, units):
    """librealsense states metres per unit, Open3D units per metre."""
    _frame(tmp_path, "color/000000.png", "depth/000000.png", units)
    stated = {} if scale is None else {"depth_scale": scale}
    _text(tmp_path / name, json.dumps({"fx": 60, "fy": 60, "ppx": 31.5, "ppy": 23.5} | stated))
    frame = ilf.open_source(tmp_path)[0]
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=1e-3, equal_nan=True)
    assert frame.intrinsics.fx == 60


@pytest.mark.parametrize("file", ["camK.npy", "metadata"])
def test_the_camera_beside_folders_of_colour_and_depth_is_read(tmp_path, file):
    """GraspNet and WildRGB-D."""
    _frame(tmp_path, "rgb/0000.png", "depth/0000.png")
    if file == "camK.npy":
        np.save(tmp_path / file, K)
    else:
        _text(tmp_path / file, json.dumps({"w": W, "h": H, "fps": 30, "K": K.T.ravel().tolist()}))
    assert ilf.open_source(tmp_path)[0].intrinsics.numbers == (60, 60, 31.5, 23.5)


def test_depth_of_instant_ngp_has_its_own_names_and_scale(tmp_path):
    _transforms(tmp_path, depth=False)
    data = json.loads((tmp_path / "transforms.json").read_text())
    for number, frame in enumerate(data["frames"]):
        _write(tmp_path / f"deep/{number:04d}_z.png", METRES, 2000)
        frame["depth_path"] = f"deep/{number:04d}_z.png"
    _text(tmp_path / "transforms.json", json.dumps(data | {"integer_depth_scale": 1 / 2000}))
    frame = ilf.open_source(tmp_path)[1]
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=1e-3, equal_nan=True)


def test_depth_of_a_phone_is_registered_to_its_larger_colour(tmp_path):
    _polycam(tmp_path)
    for number in range(2):
        _colour(tmp_path / f"keyframes/corrected_images/{144200852560 + number}.jpg", (2 * H, 2 * W))
        path = tmp_path / f"keyframes/corrected_cameras/{144200852560 + number}.json"
        wide = {"fx": 120.0, "fy": 120.0, "cx": 63.5, "cy": 47.5, "width": 2 * W, "height": 2 * H}
        path.write_text(json.dumps(json.loads(path.read_text()) | wide))
    frame = ilf.open_source(tmp_path)[0]
    assert (frame.shape, frame.intrinsics.fx) == ((2 * H, 2 * W), 120.0)
    assert np.nanmedian(frame.depth) == pytest.approx(np.median(METRES[METRES > 0]), abs=0.02)
    with pytest.raises(InputError, match=r"confidence map must have the same pixels.* \(--view depth\)"):
        ilf.open_source(tmp_path, min_confidence=255)[0]
    own = ilf.open_source(tmp_path / "keyframes", min_confidence=255, view="depth")  # a folder in the data set
    assert own.layout.startswith("polycam ")
    assert (own[0].shape, own[0].intrinsics.fx) == ((H, W), 60.0)
    assert np.allclose(own.pose(own.keys[1]), _poses(2)[1])


@pytest.mark.parametrize("write", [_scanner_app, _record3d_exr, _transforms])
def test_one_camera_is_that_of_colour_and_of_its_smaller_depth(tmp_path, write):
    """Phones give depth of the view of colour in fewer pixels, and programs state the camera of colour alone."""
    write(tmp_path)
    for path in [*tmp_path.rglob("*.jpg")]:
        _colour(path, (2 * H, 2 * W))
    for path in tmp_path.rglob("*.json"):
        stated = json.loads(path.read_text())
        wide = {"fl_x": 120.0, "fl_y": 120.0, "cx": 64.0, "cy": 48.0, "w": 2 * W, "h": 2 * H}
        wide = {"K": _WIDE.T.ravel().tolist(), "w": 2 * W, "h": 2 * H} if "K" in stated else wide
        path.write_text(json.dumps(stated | ({"intrinsics": _WIDE.tolist()} if "intrinsics" in stated else wide)))
    source = ilf.open_source(tmp_path)
    frame = source[0]
    assert (frame.shape, frame.intrinsics.numbers) == ((2 * H, 2 * W), (120.0, 120.0, 63.5, 47.5))
    assert np.nanmedian(frame.depth) == pytest.approx(np.median(METRES[METRES > 0]), abs=0.02)
    assert np.array_equal(ilf.load_frame(**frame.sources).depth, frame.depth, equal_nan=True)
    given = ilf.open_source(tmp_path, intrinsics=(130.0, 130.0, 63.5, 47.5))[0]
    assert given.intrinsics.fx == 130


def test_shares_of_a_kilometre_have_coarse_steps(tmp_path):
    _point_odyssey(tmp_path)
    frame = ilf.open_source(tmp_path)[1]
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=0.008, equal_nan=True)


def test_a_file_named_distance_to_camera_is_along_rays_if_the_camera_is_known(tmp_path):
    _isaac(tmp_path, depth="distance_to_camera")
    files = tmp_path / "rgb_0001.png", tmp_path / "distance_to_camera_0001.npy"
    frame = ilf.load_frame(*files, intrinsics=str(tmp_path / "camera_params_0001.json"))
    assert np.allclose(frame.depth, np.where(METRES == 0, np.nan, METRES), atol=1e-5, equal_nan=True)
    assert frame.inputs.encoding.startswith("ray:1.0,")
    with pytest.warns(DepthWarning, match="distances along the rays"):
        ilf.load_frame(*files)


def test_frames_of_scannet_are_registered_by_the_two_cameras(tmp_path):
    _scannet(tmp_path / "data")
    source = ilf.open_source(tmp_path / "data/scans/scene0000_00")
    assert (source.keys, source.is_registered) == (("color/0", "color/1"), False)
    frame = source[1]
    assert frame.shape == (96, 128)
    assert frame.intrinsics.fx == pytest.approx(121.5)
    # the pixel of colour sees the same direction as a pixel of depth
    column, row = (
        round((value - centre) / 60 * 121.5 + middle)
        for value, centre, middle in ((10, 31.5, 60.25), (30, 23.5, 47.75))
    )
    assert frame.depth[row, column] == pytest.approx(METRES[30, 10], abs=0.02)
    assert np.allclose(frame.pose, _poses(2)[1])
    pair = source.read_pair("color/1")
    assert (pair.rgb.shape[:2], pair.depth.shape, pair.depth_camera.fx) == ((96, 128), (H, W), 60.0)
    calibration = source.calibration("color/1")
    assert (calibration.colour.fx, calibration.depth.fx) == (121.5, 60.0)
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)
    every = ilf.open_source(tmp_path / "data")
    assert every.keys == ("scans/scene0000_00/color/0", "scans/scene0000_00/color/1")


def test_two_files_of_different_sizes_are_registered_or_refused_with_the_cure(tmp_path, cli):
    _colour(tmp_path / "rgb.png", (96, 128))
    _write(tmp_path / "depth.png", METRES, 1000)
    files = [str(tmp_path / name) for name in ("rgb.png", "depth.png")]
    assert "--intrinsics and --depth-intrinsics" in cli("complete", *files, "--out", tmp_path / "out", status=1).err
    with pytest.raises(InputError, match="also give the intrinsics of colour"):
        ilf.load_frame(*files, depth_intrinsics=(60, 60, 31.5, 23.5))
    cameras = ["--intrinsics", "120,120,63.5,47.5", "--depth-intrinsics", "60,60,31.5,23.5"]
    assert re.search("registered: +on reading", cli("info", *files, *cameras).out)
    how = ["--out", str(tmp_path / "out"), "--max-iterations", "5", "--no-cloud", "--quiet"]
    assert main(["complete", *files, *cameras, *how]) == 0
    again = ["complete", "--replay", str(tmp_path / "out/run.json"), "--out", str(tmp_path / "again"), "--quiet"]
    assert main(again) == 0
    assert (tmp_path / "again/depth.npy").read_bytes() == (tmp_path / "out/depth.npy").read_bytes()


def test_replica_is_named_and_found_one_folder_up(tmp_path, cli):
    _replica(tmp_path)
    told = cli("info", tmp_path / "room0").out
    assert "layout:        replica (Replica, as rendered for NICE-SLAM)" in told
    assert "depth camera:  fx 60" in told, "cam_params.json lies above"
    listed = json.loads(cli("info", "--layouts", "--json").out)["layouts"]
    assert [layout["name"] for layout in listed] == [layout.name for layout in built_in_layouts()]


def test_other_layouts_that_fit_are_named(tmp_path):
    _transcg(tmp_path)
    source = ilf.open_source(tmp_path / "scene1")
    assert "transcg-l515" in source.notes[-1]
    other = ilf.open_source(tmp_path / "scene1", layout="transcg-l515")
    assert other.keys == ("0/rgb2", "1/rgb2")
    assert other[0].inputs.depth_units == 4000
    assert other[0].ground_truth[15, 35] == pytest.approx(2.25, abs=1e-3)


def test_depth_beside_the_images_of_a_transforms_json(tmp_path):
    _transforms(tmp_path, depth=False)
    source = ilf.open_source(tmp_path)
    assert source.layout.startswith("nerfstudio")
    assert source.is_registered  # one camera is stated for both
    assert np.allclose(source[1].pose, _poses(2)[1])
    assert source[1].intrinsics.cx == 31.5, "its pixels are counted from a corner"
    data = json.loads((tmp_path / "transforms.json").read_text()) | {"depth_unit_scale_factor": 0.0005}
    (tmp_path / "transforms.json").write_text(json.dumps(data))
    assert ilf.open_source(tmp_path)[1].inputs.depth_units == 2000
    assert set(ilf.open_source(tmp_path).ref("images/00001").options.intrinsics) == {
        *("fx", "fy", "cx", "cy", "width", "height", "lens", "name")
    }
    (tmp_path / "transforms.json").write_text('{"frames": [{"file_path": 3}]}')
    with pytest.raises(FormatError, match=r"transforms\.json contains no camera poses"):
        ilf.open_source(tmp_path)


def test_images_of_one_name_in_two_folders_keep_their_own_depth_and_pose(tmp_path):
    frames = []
    for camera, pose in zip("ab", _poses(2), strict=True):
        _colour(tmp_path / f"{camera}/0001.jpg")
        _write(tmp_path / f"depth_{camera}/0001.png", METRES * (1 if camera == "a" else 2), 1000)
        names = {"file_path": f"{camera}/0001.jpg", "depth_file_path": f"depth_{camera}/0001.png"}
        frames.append(names | {"transform_matrix": (pose @ Y_UP).tolist(), "fl_x": 60.0, "cx": 32, "cy": 24})
    _text(tmp_path / "transforms.json", json.dumps({"frames": frames}))
    source = ilf.open_source(tmp_path)
    assert source.keys == ("a/0001", "b/0001")
    assert [round(float(frame.depth[0, 0]), 3) for frame in source] == [1.5, 3.0]
    assert np.allclose(source[1].pose, _poses(2)[1])
    assert source[1].intrinsics.fy == 60


def test_images_of_a_layout_without_depth_are_told(tmp_path):
    _kitti(tmp_path)
    notes = ("2 colour images left out: there is no depth image of that name.",)
    assert ilf.open_source(tmp_path).notes == notes


def test_a_layout_is_given_as_text(tmp_path):
    _void(tmp_path)
    text = "rgb={}/image/*.png depth={}/ground_truth/*.png units=256 K=K.txt pose=absolute_pose/*.txt"
    source = ilf.open_source(tmp_path / "void_1500", layout=text)
    assert source.keys[0] == "data/classroom0/image/1552625028.2387"
    assert source.timestamps == (1552625028.2387, 1552625028.3387)
    frame = source[0]
    assert not np.isnan(frame.depth).any()
    assert frame.intrinsics.fx == 60
    assert np.allclose(frame.pose, POSE)
    assert source.notes == ()
    told = ilf.open_source(tmp_path / "void_1500", layout=f"{text} truth=gt/*.png").notes
    assert told == ("There is no file truth=gt/*.png: frames are read without.",)
    mine = ilf.open_source(tmp_path / "void_1500", layout=text, depth_units=512, intrinsics="50,50,32,24")
    assert (mine[0].inputs.depth_units, mine[0].intrinsics.fx) == (512, 50), "what the user states precedes the layout"


def test_poses_from_the_world_and_with_y_up_are_turned(tmp_path):
    for number, pose in enumerate(_poses(2)):
        seen_from = {f"w2c/{number}.txt": np.linalg.inv(pose @ Y_UP)}
        _frame(tmp_path, f"rgb/{number}.png", f"depth/{number}.png", pose=seen_from)
    text = "rgb=rgb/*.png depth=depth/*.png pose=w2c/*.txt pose_maps=world-to-camera pose_axes=y-up"
    assert np.allclose(ilf.open_source(tmp_path, layout=text)[1].pose, _poses(2)[1])


def test_own_layouts_precede_the_table(tmp_path, no_own_layouts):
    _void(tmp_path)
    no_own_layouts.mkdir()
    own = no_own_layouts / "lab.toml"
    own.write_text(
        '[lab]\ntitle = "Our lab"\nrgb = "{}/image/*.png"\ndepth = "{}/ground_truth/*.png"\nunits = 256\n'
        '[void]\nrgb = "{}/image/*.jpg"\ndepth = "{}/sparse_depth/*.png"\n'
    )
    source = ilf.open_source(tmp_path / "void_1500")
    assert source.layout == "lab (Our lab)"
    assert [layout.name for layout in all_layouts()].count("void") == 1
    alone = tmp_path / "own.toml"
    alone.write_text('rgb = "image/*.png"\ndepth = "sparse_depth/*.png"\nunits = 256\n')
    assert ilf.open_source(tmp_path / "void_1500/data/classroom0", layout=alone).layout == "own"
    own.write_text('[lab]\nrgb = "a/*.png"\n')
    with pytest.raises(FormatError, match=r"lab\.toml: The layout 'lab' has no 'depth'"):
        ilf.open_source(tmp_path / "void_1500")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rgb=a.png", "has no 'depth'"),
        ("rgb=a.png depth=b.png", "no placeholder in common"),
        ("rgb=*.png depth={x}.png", "no placeholder in common"),
        ("rgb=*.png depth=d/*.png K={camera}.txt", r"has \{camera\}"),
        ("rgb=*.png depth=d/*.png colour=1", "unknown field"),
        ("rgb=*.png depth=d/*.png units=mm", "units"),
        ("rgb=*.png depth=d/*.png units=0", "'units' in the layout"),
        ("rgb=*.png depth=d/*.png units=5 encoding=mm", "only one of them"),
        ("rgb=*.png depth=d/*.png distance=ray", "needs K"),
        ("rgb=*.png depth=d/*.png pose_axes=left", "pose_axes"),
        ("rgb=*.png rgb=d/*.png", "given twice"),
        ("rgb='*.png depth=d/*.png", "quotation"),
        ("rgb={*.png,x/*_*.png} depth=*.png", "same placeholders"),
        ("rgb=*_*_*_*_*.png depth=d/*.png", "placeholders in a name"),
        ("rgb=/*.png depth=d/*.png", "path in the data set"),
        ("rgb=a/{}/*.png depth=d/*.png", "path in the data set"),
        ("nothing", "There is no layout 'nothing'"),
    ],
)
def test_layouts_that_are_not_valid_say_why(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        ilf.open_source(tmp_path, layout=text)


def test_what_does_not_fit_names_the_layout_and_the_nearest(tmp_path):
    _void(tmp_path)
    scene = tmp_path / "void_1500/data/classroom0"
    with pytest.raises(InputError, match=r"scannet \(.*color.* matches 0 files.*It fits the layout void"):
        ilf.open_source(scene, layout="scannet")
    (scene / "sparse_depth").rename(scene / "sparse")
    with pytest.raises(
        InputError, match=r"The nearest layout is void \(VOID\): it finds .*K\.txt.*, but lacks .*sparse_depth"
    ):
        ilf.open_source(scene)
    for text in ("rgb = ", "rgb = " + "9" * 5000):
        with pytest.raises(FormatError, match="not valid TOML"):
            layouts_from_file(_wrong(tmp_path / "a.toml", text))
    with pytest.raises(FormatError, match="more than 64 KiB"):  # whose name takes a minute
        layouts_from_file(_wrong(tmp_path / "a.toml", f"{'a.' * 200_000}a = 1"))
    with pytest.raises(FormatError, match=r"must contain a table"):
        layouts_from_file(_wrong(tmp_path / "a.toml", "a = 1"))
    (scene / "sparse").rename(scene / "sparse_depth")
    (scene / "K.txt").write_text("1 2 3")
    with pytest.raises(FormatError, match=r"K\.txt must contain a camera matrix"):
        ilf.open_source(scene)


def _wrong(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_distance_along_the_ray_becomes_depth():
    encoding = encoding_of("ray:1000,60,60,31.5,23.5")
    x, y = (np.arange(W) - 31.5) / 60, (np.arange(H) - 23.5) / 60
    values = np.rint(METRES * 1000 * np.sqrt(1 + x**2 + y[:, None] ** 2)).astype(np.uint16)
    assert np.allclose(np.nan_to_num(encoding.metres(values)), METRES, atol=1e-3)
    assert encoding_of(encoding.name) == encoding
    for wrong in ("ray:1000,60", "ray:0,1,1,1,1", "ray:1,0,1,1,1", "ray:1,1,1,1,1,inf,5", "ray:x"):
        with pytest.raises(ParameterError):
            encoding_of(wrong)
    with pytest.raises(FormatError, match="aspect ratio"):
        encoding_of("ray:1,60,60,31.5,23.5,64,64").metres(values)
