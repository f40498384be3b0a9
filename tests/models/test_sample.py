"""The bundled sample: its files fit together, its holes are real, and its script can be trusted."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import make_room
import numpy as np
import pytest

SAMPLES = Path(__file__).parents[2] / "assets" / "samples"
ROOM = SAMPLES / "room"
LEAST_SHARE = {
    "black surface": 0.02,
    "halogen light": 0.005,
    "glossy floor": 0.005,
    "glossy thing": 0.0005,
    "glass": 0.002,
    "out of range": 0.01,
    "stereo shadow": 0.01,
    "steep surface": 0.002,
    "thin thing": 0.001,
    "depth edge": 0.02,
    "drop-out": 0.002,
}


@pytest.fixture(scope="module")
def files():
    meta = json.loads((ROOM / "meta.json").read_text(encoding="utf-8"))
    depth, gt = (cv2.imread(str(ROOM / name), cv2.IMREAD_UNCHANGED) for name in ("depth.png", "gt.png"))
    return meta, cv2.imread(str(ROOM / "rgb.jpg")), depth, gt


@pytest.fixture(scope="module")
def scene():
    return make_room.furnished(7)


@pytest.fixture(scope="module")
def capture(scene):
    return make_room.capture(scene, (640, 480), 7)


def test_files_fit_together(files):
    meta, rgb, depth, gt = files
    assert set(meta) == {
        *("name", "size", "depth_units_per_m", "gt_units_per_m", "gt", "hole_fraction"),
        *("hole_with_gt_fraction", "gt_left_out", "K", "sensor", "source", "licence", "note"),
    }
    assert rgb.shape == (480, 640, 3)
    assert rgb.dtype == np.uint8
    assert depth.shape == gt.shape == tuple(meta["size"][::-1])
    assert depth.dtype == gt.dtype == np.uint16
    assert meta["hole_fraction"] == pytest.approx(np.mean(depth == 0))
    assert meta["hole_with_gt_fraction"] == pytest.approx(np.mean((depth == 0) & (gt > 0)))
    assert 0.15 < meta["hole_fraction"] < 0.25
    assert sum(path.stat().st_size for path in ROOM.iterdir()) < 1_000_000


def test_picture_is_well_exposed_and_colourful(files):
    rgb = files[1].astype(float)
    assert 90 < rgb.mean() < 165
    assert np.mean(rgb.max(axis=2) >= 254) < 0.06
    assert np.mean(rgb.max(axis=2) <= 8) < 0.02
    assert np.median(np.ptp(rgb, axis=2)) > 20


def test_committed_depth_is_what_the_script_makes(files, capture):
    _, _, depth, gt = files
    missing = np.any(list(capture.holes.values()), axis=0)
    # Libraries of other versions may round a ray at an outline to the other side.
    assert np.mean((np.abs(capture.exact * 1000 - gt) <= 1) | (gt == 0)) > 0.999
    assert np.mean(missing == (depth == 0)) > 0.99


def test_every_kind_of_hole_is_there(files, capture):
    assert set(capture.holes) == set(LEAST_SHARE)
    _, _, depth, _ = files
    for name, least in LEAST_SHARE.items():
        assert np.mean(capture.holes[name] & (depth == 0)) > least, name


def test_truth_is_left_out_beyond_the_range_in_the_door_and_nowhere_else(files, capture):
    _, _, depth, gt = files
    assert np.mean((gt == 0) == capture.holes["out of range"]) > 0.999
    assert np.all(depth[gt == 0] == 0)
    assert capture.exact[gt == 0].min() > 4
    rows, columns = np.nonzero(gt == 0)
    assert rows.max() < 320
    assert columns.min() > 350
    assert columns.max() < 470


def test_glass_is_a_surface_through_which_the_camera_measures_what_is_behind(capture):
    behind = capture.measured - capture.exact
    table = (slice(320, 390), slice(270, 340))
    through = (behind > 0.03) & ~np.any(list(capture.holes.values()), axis=0)
    assert through[table].sum() > 100
    assert capture.holes["glass"][table].sum() > 500


def test_stereo_shadows_lie_left_of_something_nearer(capture):
    rows, columns = np.nonzero(capture.holes["stereo shadow"][:, :-40])
    right = np.stack([capture.exact[rows, columns + step] for step in range(1, 40)]).min(axis=0)
    left = np.stack([capture.exact[rows, np.maximum(columns - s, 0)] for s in range(1, 40)]).min(axis=0)
    gap = 0.02 * capture.exact[rows, columns]
    assert np.mean(capture.exact[rows, columns] - right > gap) > 0.9
    assert np.mean(capture.exact[rows, columns] - left > gap) < 0.8


def test_noise_grows_with_the_square_of_the_range(files):
    _, _, depth, gt = files
    error, metres = np.abs(depth.astype(float) - gt), gt / 1000
    spread = {}
    for low in (2.0, 2.5, 3.0, 3.5):
        here = (depth > 0) & (metres >= low) & (metres < low + 0.5)
        spread[low] = 1.4826 * np.median(error[here]) / np.median(metres[here]) ** 2
        assert 1.0 < spread[low] < 3.0
    assert max(spread.values()) < 1.5 * min(spread.values())


def test_measured_depth_has_disparity_steps(files):
    meta, _, depth, _ = files
    known = depth[depth > 0] / 1000
    scale = 8 * meta["K"][0] * 0.075
    nearest = scale / np.round(scale / known)
    assert np.max(np.abs(nearest - known)) < 0.00051
    assert len(np.unique(known)) < 200


def test_script_is_deterministic(scene, tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    make_room.main(["--size", "16x12", "--out", str(here)])
    command = [sys.executable, str(SAMPLES / "make_room.py"), "--size", "16x12", "--out", str(there)]
    subprocess.run(command, check=True, capture_output=True, timeout=100)
    assert [path.read_bytes() for path in sorted(there.iterdir())] == [
        path.read_bytes() for path in sorted(here.iterdir())
    ]
    depth = cv2.imread(str(here / "depth.png"), cv2.IMREAD_UNCHANGED)
    other = make_room.capture(scene, (16, 12), 8)
    assert np.any((np.round(other.measured * 1000) != depth)[depth > 0])


def test_exact_depth_agrees_with_the_planes_of_floor_and_wall(scene):
    """Camera 1.5 m above the floor, 3.7 m before the wall, tilted down by 12 and turned left by 2 degrees."""
    exact = make_room.capture(scene, (80, 60), 7).exact
    fx, fy, cx, cy = make_room.intrinsics_at((80, 60))
    tilt, turn = np.radians(12), np.radians(2)

    def ray(column: int, row: int) -> tuple[float, float]:
        """Vertical and outward part of the ray that gains depth 1."""
        x, y = (column - cx) / fx, (row - cy) / fy
        level = np.cos(tilt) - y * np.sin(tilt)
        return -np.sin(tilt) - y * np.cos(tilt), level * np.cos(turn) + x * np.sin(turn)

    for column, row in ((3, 58), (10, 55), (14, 50)):
        assert exact[row, column] == pytest.approx(1.5 / -ray(column, row)[0], abs=0.002)
    for column, row in ((20, 4), (36, 10), (40, 26), (70, 5)):
        assert exact[row, column] == pytest.approx(3.7 / ray(column, row)[1], abs=0.002)
