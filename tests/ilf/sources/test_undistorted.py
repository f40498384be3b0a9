"""Pairs of files that are undistorted on reading: the right pixels, the right camera, and the same frame again."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.data.lenses import places_in_image, rays_of, seen_at, undistorted_view
from ilf.errors import InputError
from tests.ilf.image_files import write_rgbd

H, W = 60, 80
LENS = (-0.32, 0.11, 0.001, -0.0008, -0.01)
LENSES = {
    "Brown": LENS,
    "rational": (*LENS, 0.02, -0.01, 0.003),
    "thin prism": (*LENS, 0.02, -0.01, 0.003, 0.001, 0.0, -0.001, 0.0),
    "tilted": (*LENS, 0.02, -0.01, 0.003, 0.001, 0.0, -0.001, 0.0, 0.004, -0.003),
    "fisheye": (0.05, -0.01, 0.004, -0.001),
}
K = np.array([[75.0, 0, 40.6], [0, 71.0, 28.1], [0, 0, 1]])


def _camera(
    path: Path, coefficients: tuple[float, ...] = LENS, matrix: np.ndarray = K, model: str = "plumb_bob"
) -> Path:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", W)
    storage.write("image_height", H)
    storage.write("camera_matrix", matrix)
    storage.write("distortion_model", model)
    storage.write("distortion_coefficients", np.array([coefficients]))
    storage.release()
    return path


def _slanted_plane(kind: str) -> np.ndarray:
    """Depth [m] of a slanted plane as a camera with this lens sees it: inverse depth is linear in undistorted rays."""
    columns, rows = np.meshgrid(np.arange(W, dtype=float), np.arange(H, dtype=float))
    seen = np.stack([columns.ravel(), rows.ravel()], axis=1)[:, None]
    undistort = cv2.fisheye.undistortPoints if kind == "fisheye" else cv2.undistortPoints
    x, y = undistort(seen, K, np.array(LENSES[kind]))[:, 0].T
    return (1 / (0.5 + 0.1 * x + 0.2 * y)).reshape(H, W)


def _plane(camera: ilf.Camera) -> np.ndarray:
    """The same plane as a camera without distortion sees it."""
    x, y = (np.arange(W) - camera.cx) / camera.fx, (np.arange(H)[:, None] - camera.cy) / camera.fy
    return 1 / (0.5 + 0.1 * x + 0.2 * y)


@pytest.fixture
def files(tmp_path):
    shades = np.repeat(np.linspace(20, 230, W)[None], H, axis=0).astype(np.uint8)
    plane = _slanted_plane("Brown").astype(np.float32)
    return write_rgbd(tmp_path, plane, "depth.npy", np.dstack((shades, shades, 255 - shades)))


@pytest.mark.parametrize("kind", LENSES)
def test_a_plane_is_plane_again_by_any_lens_of_opencv(kind, files, tmp_path):
    np.save(files[1], _slanted_plane(kind).astype(np.float32))
    lens = _camera(tmp_path / "lens.yaml", LENSES[kind], model="equidistant" if kind == "fisheye" else "plumb_bob")
    frame = ilf.load_frame(*files, intrinsics=lens, undistort=True)
    assert ilf.load_frame(**json.loads(json.dumps(frame.sources))).inputs == frame.inputs
    plane = _plane(frame.intrinsics)
    assert frame.known.mean() > 0.99, "no empty pixels"
    half_a_pixel = 0.5 / 75 * 0.35 * plane**2  # depth is moved to the nearest pixel, not interpolated
    assert (np.abs(frame.depth - plane)[frame.known] < half_a_pixel[frame.known] + 0.01).all()


@pytest.mark.parametrize("kind", LENSES)
def test_points_and_images_are_where_opencv_puts_them(kind):
    model, coefficients = ("fisheye" if kind == "fisheye" else "pinhole"), np.array(LENSES[kind])
    camera = ilf.Camera(75.0, 71.0, 40.6, 28.1, size=(W, H), distortion=LENSES[kind], model=model)
    pixels = np.random.default_rng(0).uniform((0, 0), (W - 1, H - 1), (200, 2))
    rays = rays_of(camera, pixels)
    if kind == "fisheye":
        seen = cv2.fisheye.distortPoints(rays[:, None], K, coefficients)[:, 0]
    else:
        seen = cv2.projectPoints(np.c_[rays, np.ones(200)], np.zeros(3), np.zeros(3), K, coefficients)[0][:, 0]
    assert np.abs(seen - pixels).max() < 0.01
    assert np.abs(seen_at(camera, rays) - pixels).max() < 0.01
    new, columns, rows = undistorted_view(camera)
    of_model = cv2.fisheye if kind == "fisheye" else cv2
    wanted = of_model.initUndistortRectifyMap(K, coefficients, np.eye(3), new.matrix, (W, H), cv2.CV_32FC1)
    for ours, theirs, last in zip((columns, rows), wanted, (W - 1, H - 1), strict=True):
        assert np.abs(ours - np.clip(theirs, 0, last)).max() < 0.01
        assert (theirs > -0.01).all()
        assert (theirs < last + 0.01).all(), "no empty pixels"
    places = np.stack(places_in_image(camera, new.matrix, (W, H)), axis=-1).reshape(-1, 2)
    across = np.stack(np.meshgrid(np.arange(W), np.arange(H)), axis=-1).reshape(-1, 2)
    assert np.abs(seen_at(camera, (across - (new.cx, new.cy)) / (new.fx, new.fy)) - places).max() < 0.01


@pytest.mark.parametrize(("focal", "told"), [(35.0, ""), (25.0, ""), (25.0, "cannot be inverted")])
def test_a_fisheye_too_wide_for_a_plane_keeps_its_middle(focal, told):
    folds = (-0.4, 0.0, 0.0, 0.0) if told else LENSES["fisheye"]
    camera = ilf.Camera(focal, focal, 39.5, 29.5, size=(W, H), distortion=folds, model="fisheye")
    if told:
        with pytest.raises(InputError, match=told):
            undistorted_view(camera)
        return
    new, columns, rows = undistorted_view(camera)
    assert np.hypot(39.5 / new.fx, 29.5 / new.fy) <= 3
    assert (np.diff(columns, axis=1) > 0).all()
    assert (np.diff(rows, axis=0) > 0).all()


def test_colour_is_where_opencv_puts_it(files, tmp_path):
    frame = ilf.load_frame(*files, intrinsics=_camera(tmp_path / "lens.yaml"), undistort=True)
    stored = cv2.cvtColor(cv2.imread(str(files[0])), cv2.COLOR_BGR2RGB)
    wanted = cv2.undistort(stored, K, np.array(LENS), None, frame.intrinsics.matrix)
    assert np.abs(wanted[1:-1, 1:-1].astype(int) - frame.rgb[1:-1, 1:-1]).max() <= 2
    shift = 0.01 * (230 - 20) / W  # of 0.01 px, in shades
    assert np.abs(wanted[5:-5, 5:-5].astype(float) - frame.rgb[5:-5, 5:-5]).mean() < max(shift, 0.5)


def test_a_camera_that_its_file_has_not_is_an_error_of_info(files, tmp_path, cli):
    lens = _camera(tmp_path / "lens.yaml")
    for more in [], ["--undistort"], ["--depth-intrinsics", str(lens), "--view", "depth"]:
        assert "left" in cli("info", *files, "--intrinsics", f"{lens}#left", *more, status=1).err


def test_what_cannot_be_undistorted_is_refused(files, tmp_path):
    for camera, told in (
        (None, "give a file of intrinsics"),
        ("75,75,39.5,29.5", "no lens distortion"),
        (_camera(tmp_path / "wild.yaml", (-3.0, 0.0, 0.0, 0.0)), "cannot be inverted"),
        ({"fx": 75, "fy": 75, "cx": 39.5, "cy": 29.5, "camera_model": "omni"}, "'omni' is not supported"),
        ({"fx": 75, "fy": 75, "cx": 39.5, "cy": 29.5, "D": [0.1] * 6}, "coefficients"),
        ({"fx": 75, "fy": 75, "cx": 39.5, "cy": 29.5, "k1": 0.1, "k4": 0.01}, "four terms"),
    ):
        with pytest.raises(InputError, match=told):
            ilf.load_frame(*files, intrinsics=camera, undistort=True)
