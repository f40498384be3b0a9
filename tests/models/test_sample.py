"""The bundled sample: its files fit together, and are what its script makes."""

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


@pytest.fixture(scope="module")
def files():
    meta = json.loads((ROOM / "meta.json").read_text(encoding="utf-8"))
    depth, gt = (cv2.imread(str(ROOM / name), cv2.IMREAD_UNCHANGED) for name in ("depth.png", "gt.png"))
    return meta, cv2.imread(str(ROOM / "rgb.jpg")), depth, gt


@pytest.fixture(scope="module")
def scene():
    return make_room.furnished(7)


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


def test_committed_depth_is_what_the_script_makes(files, scene):
    """Exact and measured depth, and which pixels have none. Libraries of other versions may round a ray at an outline
    to the other side."""
    _, _, depth, gt = files
    capture = make_room.capture(scene, (640, 480), 7)
    missing = np.any(list(capture.holes.values()), axis=0)
    same = {
        "holes": missing == (depth == 0),
        "exact": (np.abs(capture.exact * 1000 - gt) <= 1) | (gt == 0),
        "measured": (np.abs(capture.measured * 1000 - depth) <= 1) | (depth == 0),
        "left out": capture.holes["out of range"] == (gt == 0),
    }
    assert {name: one.mean() for name, one in same.items() if one.mean() < 0.9995} == {}
    assert all(hole.any() for hole in capture.holes.values())


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
