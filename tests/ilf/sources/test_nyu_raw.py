"""Raw folders of NYU Depth V2: a wall with a board before it, as the data set's two cameras would have it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf.errors import InputError
from ilf.sources.nyu import NYU_CAMERAS

from ..two_cameras import made_pair, rays, seen

TIMES = (1294886362.793814, 1294886362.826)
NUMBER = 1516003249


def write_folder(folder):
    """Two frames and a colour file to which there is no depth. Depth was taken 5 ms after colour."""
    cameras = NYU_CAMERAS
    pair = made_pair(cameras.colour, cameras.depth, cameras.depth_to_colour)
    disparity = np.rint(1092.5 - 351.3 / pair.depth).astype(np.uint16)
    disparity[:, :12] = 2047
    for time in (*TIMES, TIMES[1] + 0.5):
        cv2.imwrite(str(folder / f"r-{time:.6f}-{NUMBER}.ppm"), pair.rgb[..., ::-1])
    for time in TIMES:
        cv2.imwrite(str(folder / f"d-{time + 0.005:.6f}-{NUMBER + 7}.pgm"), disparity.byteswap())
    (folder / f"a-{TIMES[0]:.6f}-{NUMBER}.dump").write_bytes(b"acceleration")
    return pair


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("basement_0001a")


@pytest.fixture(scope="module")
def pair(folder):
    return write_folder(folder)


@pytest.fixture(scope="module")
def source(folder, pair):
    return ilf.open_source(folder)


def test_frames_are_paired_by_the_times_in_their_names(source):
    assert source.keys == tuple(f"r-{time:.6f}-{NUMBER}" for time in TIMES)
    assert source.timestamps == pytest.approx(TIMES)
    assert source.notes == ("1 colour image left out: there is no depth image within 0.02 s.",)
    assert not source.is_registered
    assert source.calibration(source.keys[0]).depth.fx == pytest.approx(582.6245, abs=1e-4)


def test_depth_is_registered_by_the_data_sets_own_cameras(source):
    frame = source.read(source.keys[0])
    ground_truth = seen(rays(replace(frame.intrinsics, size=(640, 480))), np.eye(4)).reshape(frame.shape)
    off = np.abs(frame.depth - ground_truth)[frame.known]
    assert frame.known.mean() > 0.75
    # a step of disparity is 11 mm at 2 m
    assert np.median(off) < 0.004
    assert np.quantile(off, 0.95) < 0.02
    # the toolbox cuts its pictures off to columns 41-601 and rows 45-471, since depth goes a little farther than that
    own, published = frame.intrinsics, NYU_CAMERAS.colour
    left, right = (round((column - published.cx) / published.fx * own.fx + own.cx) for column in (40, 600))
    top, bottom = (round((row - published.cy) / published.fy * own.fy + own.cy) for row in (44, 470))
    assert frame.missing[top:bottom, left + 15 : right].mean() < 0.05, "a shadow, and columns without disparity"
    assert not frame.outside_view[top:bottom, left:right].any()
    assert frame.outside_view[:, :20].all()
    assert frame.outside_view[240, 625:].all()
    assert frame.inputs.frame == source.keys[0]
    assert frame.inputs.encoding == "nyu-raw"


def test_files_that_lie_too_far_apart_are_told_of(tmp_path):
    for name in ("r-1294886362.000000-1.ppm", "d-1294886363.500000-2.pgm"):
        (tmp_path / name).touch()
    with pytest.raises(InputError, match="--max-gap"):
        ilf.open_source(tmp_path)
    assert len(ilf.open_source(tmp_path, max_gap=2.0)) == 1


def test_a_completed_frame_lies_with_its_straight_colour(source, tmp_path):
    frame = source.read(source.keys[0])
    run = ilf.Run(frame, np.ones(frame.shape, np.int32), ilf.preset("paper", max_iterations=1))
    written = run.complete().save(tmp_path / "out", cloud=None, expected_error=False)
    assert {"rgb.png", "outside_view.png"} < {path.name for path in written.files}
    again = ilf.load_frame(tmp_path / "out")
    np.testing.assert_array_equal(again.rgb, frame.rgb)
    assert np.isnan(again.depth[frame.outside_view]).all()
