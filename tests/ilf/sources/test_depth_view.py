"""The depth camera's view: colour is brought to depth as exact geometry says, and what it does not see is no edge."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import InputError, ParameterError
from ilf.run.record import read_record
from ilf.sources.registration import RawPair, aligned, register, smoothly_filled

from ..image_files import write_rgbd
from ..two_cameras import BOARD_M, COLOUR, DEPTH, made_pair, motion, rays, seen, write_pair

H, W, FOCAL = 48, 96, 60.0
CAMERA = ilf.Camera(FOCAL, FOCAL, 47.5, 23.5, size=(W, H))
SHADES = np.broadcast_to((2 * np.arange(W) + 30).astype(np.uint8)[None, :, None], (H, W, 3))
"""Colour that says its column."""


def beside(shift: float) -> np.ndarray:
    """From the depth camera to a colour camera on its right, by a shift [m]."""
    found = np.eye(4)
    found[0, 3] = -shift
    return found


def pair_of(depth: np.ndarray, shift: float, rgb: np.ndarray = SHADES, **more: object) -> RawPair:
    return RawPair(rgb, depth, CAMERA, CAMERA, beside(shift), **more)


@pytest.mark.parametrize("shift", [0.1, -0.1, 0.0, 0.05])
def test_a_plane_has_the_colour_of_its_disparity_and_depth_as_measured(shift):
    pair = pair_of(np.full((H, W), 2.0), shift)
    frame = register(pair, "depth")
    np.testing.assert_array_equal(frame.depth, pair.depth)
    assert frame.intrinsics == CAMERA.pinhole
    assert frame.outside_view is None
    columns = np.arange(W) - FOCAL * shift / 2.0  # focal length times distance of the cameras / depth
    inside = (columns >= -0.5) & (columns < W - 0.5)
    np.testing.assert_array_equal(frame.brought.seen, np.broadcast_to(inside, (H, W)))
    wanted = np.where(inside, 2 * np.clip(columns, 0, W - 1) + 30, 0)
    assert np.abs(frame.rgb[..., 0] - wanted).max() <= 1


def test_missing_depth_has_the_colour_of_the_plane_around_it_and_stays_missing():
    columns = np.arange(W)
    plane = np.broadcast_to(1 / (0.4 + 0.004 * columns), (H, W))
    holed = plane.copy()
    holed[14:34, 30:60] = np.nan
    frame = register(pair_of(holed, 0.2), "depth")
    np.testing.assert_array_equal(frame.depth, holed.astype(np.float32))
    off = frame.rgb[24, 30:60, 0] - (2 * (columns - FOCAL * 0.2 / plane[24])[30:60] + 30)
    assert np.abs(off).max() <= 2, "within a pixel, by 1 / depth, which is linear along a plane"


@pytest.mark.parametrize("colour", [COLOUR, replace(COLOUR, distortion=())], ids=["bent", "straight"])
@pytest.mark.parametrize("depth", [DEPTH, replace(DEPTH, distortion=())], ids=["bent", "straight"])
def test_of_bent_lenses_depth_and_colour_are_where_exact_geometry_has_them(colour, depth):
    pair = made_pair(colour, depth)
    frame = register(pair, "depth")
    assert frame.shape == pair.depth.shape
    assert frame.known.mean() > 0.99
    views = rays(replace(frame.intrinsics, size=depth.size))
    exact = seen(views, pair.depth_to_colour)
    points = views * exact[:, None] @ pair.depth_to_colour[:3, :3].T + pair.depth_to_colour[:3, 3]
    places, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), colour.matrix, colour.coefficients)
    first = seen(points / points[:, 2:], np.eye(4))
    exact, visible = exact.reshape(frame.shape), (points[:, 2] - first < 0.01).reshape(frame.shape)
    flat = cv2.erode(exact, np.ones((5, 5))) / cv2.dilate(exact, np.ones((5, 5))) > 0.8
    assert np.abs(frame.depth - exact)[flat].max() < 0.02, "half a pixel on the leaning wall"
    evaluated = flat & visible & frame.brought.seen
    assert evaluated.mean() > 0.5
    shades = 255 * places[:, 0, 0].reshape(frame.shape) / colour.size[0]
    assert np.abs(frame.rgb[..., 0] - shades)[evaluated].max() < 5, "within two pixels of colour"
    hidden = flat & (first - points[:, 2] < -0.5).reshape(frame.shape)
    assert not frame.brought.seen[hidden & flat].any()


def test_colour_of_twice_the_resolution_is_averaged():
    fine = ilf.Camera(2 * FOCAL, 2 * FOCAL, 95, 47, size=(2 * W, 2 * H))  # pixels of depth are in bright stripes
    stripes = np.zeros((2 * H, 2 * W, 3), np.uint8)
    stripes[:, ::2] = 200
    frame = register(RawPair(stripes, np.full((H, W), 2.0), fine, CAMERA, np.eye(4)), "depth")
    assert np.abs(frame.rgb[4:-4, 4:-4].astype(int) - 100).max() < 30


def test_where_colour_sees_nothing_there_is_no_edge_and_no_border_of_blocks():
    grey = np.full((120, 160, 3), 170, np.uint8)
    wide, narrow = ilf.Camera(100, 100, 79.5, 59.5, size=(160, 120)), ilf.Camera(160, 160, 79.5, 59.5, size=(160, 120))
    depth = np.full((120, 160), 2.0, np.float32)
    depth[50:70, 70:90] = np.nan
    frame = register(RawPair(grey, depth, narrow, wide, np.eye(4)), "depth")
    assert 0.3 < frame.brought.seen.mean() < 0.5
    black = ilf.RGBDFrame(frame.rgb, frame.depth, frame.intrinsics)
    for detector in ("canny", "hed", "rgbd", "combined"):
        assert ilf.edge_strength(black, detector).max() > 0.5, "the outline of black is an edge"
        assert ilf.edge_strength(frame, detector).max() < 0.2
    blocks = ilf.extract_blocks(frame)
    assert set(np.unique(blocks[blocks > 0])) == {1}
    assert (blocks[30:90, 40:120] == 1).all()
    completion = ilf.complete(frame)
    assert np.abs(completion.depth - 2.0).max() < 0.01


def test_a_smooth_fill_keeps_what_is_known_and_stays_between():
    rng = np.random.default_rng(3)
    values, known = rng.random((37, 53, 3), np.float32), rng.random((37, 53)) < 0.02
    filled = smoothly_filled(values, known)
    np.testing.assert_array_equal(filled[known], values[known])
    assert values[known].min() <= filled.min()
    assert filled.max() <= values[known].max()
    assert smoothly_filled(values, np.zeros((37, 53), bool)) is values


def test_what_is_aligned_after_completion_is_what_registration_gives():
    pair = made_pair(replace(COLOUR, distortion=()), replace(DEPTH, distortion=()))
    in_depth, in_colour = register(pair, "depth"), register(pair)
    np.testing.assert_array_equal(aligned(in_depth.depth, in_depth), in_colour.depth)
    with pytest.raises(InputError, match="with view='depth'"):
        aligned(in_colour.depth, in_colour)


def test_pixels_in_which_the_depth_camera_cannot_measure_are_outside_its_view():
    lit = np.ones((H, W), bool)
    lit[:, :20] = False
    pair = pair_of(np.where(lit, 2.0, np.nan), 0.0, depth_view=lit)
    for view in ("depth", "colour"):
        np.testing.assert_array_equal(register(pair, view).outside_view, ~lit)


def test_a_run_in_the_depth_view_is_written_aligned_too_and_made_again(tmp_path, capsys, cli):
    pair = write_pair(tmp_path / "desk")
    out, how = tmp_path / "out", [str(tmp_path / "desk"), "--frame", "1"]
    assert main(["complete", *how, "--view", "depth", "--out", str(out), "--max-iterations", "5"]) == 0
    depth, in_colour = np.load(out / "depth.npy"), np.load(out / "depth_aligned.npy")
    assert depth.shape == pair.depth.shape
    assert in_colour.shape == pair.rgb.shape[:2]
    assert np.nanmin(in_colour) == pytest.approx(BOARD_M, abs=0.02)
    millimetres = cv2.imread(str(out / "depth_aligned.png"), cv2.IMREAD_UNCHANGED)
    assert np.abs(millimetres / 1000 - np.nan_to_num(in_colour)).max() < 1e-3
    assert read_record(out / "run.json").inputs.view == "depth"
    replayed = ilf.replay(out / "run.json")
    assert replayed.differences == ()
    frame = replayed.run.frame
    assert replayed.verdict(replayed.run.complete()) == ()
    assert np.array_equal(frame.rgb, ilf.open_source(tmp_path / "desk", view="depth").read("1").rgb)
    again = ilf.load_frame(out)
    assert again.shape == frame.shape
    assert np.array_equal(again.rgb, frame.rgb)
    assert again.intrinsics.numbers == pytest.approx(frame.intrinsics.numbers)
    capsys.readouterr()
    facts = json.loads(cli("info", *how, "--view", "depth", "--json").out)["frame"]
    assert facts["view"] == "depth"
    assert facts["colour_share"] == pytest.approx(frame.brought.seen.mean())
    assert "of the depth camera" in cli("info", out / "run.json").out


def write_files(folder: Path) -> dict[str, object]:
    """Two files that are registered by both intrinsics: the arguments of `load_frame`."""
    rgb, depth = write_rgbd(folder, np.full((36, 48), 2.0, np.float32), "depth.npy", SHADES[..., ::-1])
    cameras = {"intrinsics": CAMERA.numbers, "depth_intrinsics": (40.0, 40.0, 23.5, 17.5)}
    return {"rgb": str(rgb), "depth": str(depth), **cameras, "view": "depth"}


def test_the_pose_is_that_of_the_depth_camera(tmp_path):
    write_pair(tmp_path / "desk")
    pose = motion(0.3, 0.4)
    frames = [ilf.load_frame(tmp_path / "desk", frame="1", pose=pose, view=view) for view in ("colour", "depth")]
    np.testing.assert_allclose(frames[0].pose, pose)
    np.testing.assert_allclose(frames[1].pose, pose @ motion())


def test_what_is_registered_already_or_has_no_other_camera_is_refused(tmp_path):
    files = write_files(tmp_path)
    np.save(tmp_path / "depth.npy", np.full((H, W), 2.0, np.float32))
    with pytest.raises(InputError, match="the same pixels already"):
        ilf.load_frame(files["rgb"], files["depth"], view="depth")
    ilf.load_frame(files["rgb"], files["depth"], view="colour")
    with pytest.raises(ParameterError, match="colour or depth, not 'both'"):
        ilf.load_frame(files["rgb"], files["depth"], view="both")
    with pytest.raises(ParameterError, match="colour or depth, not 'both'"):
        ilf.open_source(tmp_path, view="both")


def test_two_cameras_of_the_same_size_are_registered_where_the_view_is_given(tmp_path, cli):
    given = write_files(tmp_path / "files") | {"depth_intrinsics": (60.0, 60.0, 31.5, 27.5)}
    np.save(str(given["depth"]), np.full((H, W), 2.0, np.float32))
    del given["view"]
    with pytest.warns(ilf.DepthWarning, match="count as registered.*--view colour"):
        doubted = ilf.load_frame(**given)
    assert doubted.known.all()
    assert "--view colour" in doubted.notes[0]
    frame = ilf.load_frame(**given, view="colour")
    assert frame.intrinsics.numbers == pytest.approx(CAMERA.numbers)
    assert frame.outside_view is not None or not frame.known.all()
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)
    seen = ilf.load_frame(**given, view="depth")
    assert seen.intrinsics.numbers == pytest.approx((60, 60, 31.5, 27.5))
    assert seen.brought is not None
    files = [str(given["rgb"]), str(given["depth"]), "--out", str(tmp_path / "out"), "--quiet", "--max-iterations", "5"]
    cameras = [
        f"--{name}=" + ",".join(map(str, given[name.replace("-", "_")])) for name in ("intrinsics", "depth-intrinsics")
    ]
    cli("complete", *files, *cameras, "--view", "colour")
    assert "differ" not in cli("complete", "--replay", tmp_path / "out/run.json", "--out", tmp_path / "again").err
