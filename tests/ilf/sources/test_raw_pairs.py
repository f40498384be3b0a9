"""Folders of raw pairs with a calibration of one's own: registered by it, in the library and on the command line."""

import json

import cv2
import numpy as np
import pytest

import ilf
from ilf.batch.frame_record import LoadedFrame
from ilf.batch.static_camera import with_temporal_median
from ilf.errors import FormatError, InputError
from ilf.sources.opening import is_recording
from ilf.sources.registration import register

from ..two_cameras import calibration, write_pair


@pytest.mark.parametrize("colour", ["colour.png", "color.png", "rgb.png"])
def test_a_pair_is_registered_by_its_calibration(tmp_path, colour):
    pair = write_pair(tmp_path / "desk", colour, "depth.png")
    source = ilf.open_source(tmp_path / "desk")
    assert source.keys == ("1",)
    assert not source.is_registered
    frame, wanted = source.read("1"), register(pair)
    np.testing.assert_array_equal(frame.rgb, wanted.rgb)
    np.testing.assert_allclose(frame.depth, wanted.depth, atol=6e-5)
    assert frame.intrinsics == wanted.intrinsics
    as_it_is = source.read_pair("1")
    assert as_it_is.depth_camera == pair.depth_camera
    assert as_it_is.colour_camera == pair.colour_camera


@pytest.mark.parametrize("name", ["depth.png", "depth.npy"])
def test_depth_of_8_bits_is_refused(tmp_path, name):
    write_pair(tmp_path, "rgb.png", "depth.png")
    values = cv2.imread(str(tmp_path / "depth.png"), cv2.IMREAD_UNCHANGED).astype(np.uint8)
    (tmp_path / "depth.png").unlink()
    np.save(tmp_path / name, values) if name.endswith(".npy") else cv2.imwrite(str(tmp_path / name), values)
    with pytest.raises(FormatError, match="this is an 8-bit image, not depth"):
        ilf.open_source(tmp_path).read("1")


def test_two_depth_files_of_one_name_are_named(tmp_path):
    write_pair(tmp_path, "rgb.png", "depth.png")
    np.save(tmp_path / "depth.npy", np.ones((24, 32), np.float32))
    with pytest.raises(InputError, match=r"depth\.npy and depth\.png have the same name"):
        ilf.open_source(tmp_path)


def test_folders_of_pairs_go_by_their_names(tmp_path, cli):
    for name in ("a", "b"):
        write_pair(tmp_path, f"colour/{name}.png", f"depth/{name}.png")
    (tmp_path / "depth" / "a.png").replace(tmp_path / "depth" / "c.png")
    source = ilf.open_source(tmp_path)
    assert source.keys == ("b",)
    assert source.notes == ("2 images left out: no matching image of the same name.",)
    with pytest.raises(InputError, match="no frame 'a'"):
        source.read("a")
    assert "10000" in cli("info", tmp_path, "--frame", "b").out


def test_a_run_is_replayed_as_long_as_the_calibration_is_the_same(tmp_path):
    write_pair(tmp_path / "desk", "colour.png", "depth.png")
    frame = ilf.load_frame(tmp_path / "desk", frame="1")
    run = ilf.Run(frame, np.zeros(frame.shape, np.int32))
    run.complete().save(tmp_path / "done")
    assert ilf.replay(tmp_path / "done" / "run.json").differences == ()
    stated = json.loads((tmp_path / "desk" / "calibration.json").read_text())
    stated["depth_to_colour"][0][3] += 0.01
    (tmp_path / "desk" / "calibration.json").write_text(json.dumps(stated))
    with pytest.raises(InputError, match="differs"):
        ilf.replay(tmp_path / "done" / "run.json")


def test_a_still_camera_gives_steady_depth_of_pairs(tmp_path):
    for name in ("a", "b"):
        write_pair(tmp_path / "desk", f"colour/{name}.png", f"depth/{name}.png")
    frame, other = (ilf.load_frame(tmp_path / "desk", frame=name) for name in ("a", "b"))
    known = frame.outside_view.copy()
    known[:36] = False  # a neighbour knows what lies in the lower half
    knowing = ilf.RGBDFrame(other.rgb, np.where(known, 1.5, other.depth))
    steady = with_temporal_median(LoadedFrame(frame, (knowing,), "", {}), tmp_path / "out")
    np.testing.assert_array_equal(steady.outside_view, frame.outside_view & ~known)
    run = ilf.Run(steady, np.zeros(frame.shape, np.int32))
    run.complete().save(tmp_path / "out")
    again = ilf.replay(tmp_path / "out" / "run.json").run.frame
    np.testing.assert_array_equal(again.outside_view, steady.outside_view)
    np.testing.assert_array_equal(again.depth, steady.depth)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda c: c.pop("colour"), "has no 'colour'"),
        (lambda c: c["depth"].update(size=[64]), "size"),
        (lambda c: c["depth"].update(size=[64, "56"]), r"'depth.size\[1\]' in .* must be an integer, not text"),
        (lambda c: c["colour"].update(K=[1, 2]), "calibration.json"),
        (lambda c: c["colour"].update(distortion=[0.1]), "coefficients"),
        (lambda c: c["depth"].update(model="fisheye"), "k1 k2 k3 k4 of a fisheye, not 8"),
        (lambda c: c["colour"].update(model="omni"), "'omni' is not supported"),
        (lambda c: c.update(depth_to_colour=[[1]]), "'depth_to_colour' must be a 4 x 4 matrix"),
        (lambda c: c.update(depth_to_colour=[[10**400] * 4] * 4), "'depth_to_colour' must be a 4 x 4 matrix"),
        (lambda c: c.update(depth_encoding="yards", depth_units_per_m=None), "calibration.json"),
        (lambda c: c.update(depth_encoding="mm"), "Both a depth encoding"),
    ],
)
def test_a_calibration_that_is_none_is_told(tmp_path, change, told):
    stated = calibration(write_pair(tmp_path, "colour.png", "depth.png"))
    change(stated)
    (tmp_path / "calibration.json").write_text(json.dumps(stated))
    with pytest.raises(FormatError, match=told):
        ilf.open_source(tmp_path)


def test_cameras_that_are_too_far_apart_are_told(tmp_path):
    stated = calibration(write_pair(tmp_path, "colour.png", "depth.png"))
    stated["depth_to_colour"][0][3] = -1e200
    (tmp_path / "calibration.json").write_text(json.dumps(stated))
    with pytest.raises(InputError, match=r"cannot be 1e\+200 m apart"):
        ilf.load_frame(tmp_path, frame="1")


def test_without_a_pair_it_says_what_to_put_there(tmp_path):
    write_pair(tmp_path, "colour.png", "depth.png")
    (tmp_path / "depth.png").unlink()
    with pytest.raises(InputError, match=r"put colour\.\* and depth\.\*"):
        ilf.open_source(tmp_path)


def test_frame_folders_and_calibrations_of_others_are_what_they_were(tmp_path):
    write_pair(tmp_path / "frame", "rgb.png", "depth.png")
    (tmp_path / "frame" / "meta.json").write_text("{}")
    assert not is_recording(tmp_path / "frame")
    write_pair(tmp_path / "other", "rgb.png", "depth.png")
    assert is_recording(tmp_path / "other")
    (tmp_path / "other" / "calibration.json").write_text('{"fx": 1}')
    assert not is_recording(tmp_path / "other")
