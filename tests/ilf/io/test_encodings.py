"""Depth encodings: every way that a file's values become metres, what is missing in it, and what is doubted."""

import functools
import json
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ilf
from ilf.cli import main
from ilf.data.frame import FrameInputs, InputFile
from ilf.errors import DepthWarning, FormatError, InputError, ParameterError
from ilf.io.depth import decoded
from ilf.io.encodings import ENCODING_DESCRIPTIONS, ENCODINGS, encoding_of, encoding_of_inputs
from ilf.run.record import read_record
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading import read_depth
from tests.ilf.image_files import write_rgbd

H, W = 60, 80
HOLE = np.s_[10:20, 30:50]
NEVER = 2047  # what a Kinect v1 gives where it sees nothing


def _millimetres() -> np.ndarray:
    """A slanted floor and a box, with a hole: 1.3 to 3.6 m."""
    y, x = np.mgrid[:H, :W]
    depth = (1300 + 26 * y + 9 * x).astype(np.uint16)
    depth[35:50, 10:40] = 1600 + x[35:50, 10:40]
    depth[HOLE] = 0
    return depth


MM = _millimetres()
KNOWN = MM > 0
DISPARITY = np.where(KNOWN, np.rint(1092.5 - 351.3e3 / np.maximum(MM, 1)), NEVER).astype(np.uint16)
STORED = {
    "mm": MM,
    "sun": (MM << 3) | (MM >> 13),
    "mm-swapped": MM.byteswap(),
    "depth16": MM | np.uint16(5 << 13),
    "float16": (MM / 1000).astype(np.float16).view(np.uint16),
    "kinect-raw": DISPARITY,
    "nyu-raw": DISPARITY.byteswap(),
}


@pytest.fixture
def save(tmp_path):
    return functools.partial(write_rgbd, tmp_path)


@pytest.mark.parametrize("name", STORED)
def test_each_storage_gives_the_same_metres(save, name):
    frame = ilf.load_frame(*save(STORED[name], "depth.pgm"), encoding=name)
    assert np.array_equal(frame.known, KNOWN)
    step = 0.025 if "raw" in name else 0.001 if name == "float16" else 0.0005  # of the disparity, of half floats
    assert np.nanmax(np.abs(frame.depth - MM / 1000)) < step
    assert frame.notes == ()


NEAR, FAR = 0.1, 10.0
SEEN = np.where(KNOWN, MM / 1000, FAR)
BUFFER = FAR / (FAR - NEAR) * (1 - NEAR / SEEN)
SHARES = np.rint(SEEN / FAR * (2**24 - 1)).astype(np.uint32)
CHANNELS = np.stack([(SHARES >> shift) & 0xFF for shift in (0, 8, 16)], axis=-1).astype(np.uint8)
SIMULATED = {
    "zbuffer:0.1,10": (BUFFER.astype(np.float32), "depth.npy", 2e-5),
    "zbuffer:0.1,10,reversed": ((1 - BUFFER).astype(np.float32), "depth.npy", 1e-5),
    "zbuffer:0.1,inf,reversed": (np.where(KNOWN, NEAR / SEEN, 0).astype(np.float32), "depth.npy", 1e-6),
    "zbuffer:1,10": (np.rint(65535 * FAR / (FAR - 1) * (1 - 1 / SEEN)).astype(np.uint16), "depth.png", 1e-4),
    "m/10.00": (np.where(KNOWN, SEEN / FAR, np.nextafter(np.float32(1), 2)).astype(np.float32), "depth.npy", 1e-6),
    "m/10": ((SEEN / FAR).astype(np.float32), "depth.npy", 1e-6),
    "M/10.0": (np.rint(65535 * SEEN / FAR).astype(np.uint16), "depth.png", 1e-4),
    "m/0.5,10": ((np.where(KNOWN, SEEN - 0.5, 0) / 9.5).astype(np.float32), "depth.npy", 1e-6),
    "disparity:60,12": (np.where(KNOWN, 60 / SEEN - 12, np.inf).astype(np.float32), "depth.npy", 1e-5),
    "float32": (np.where(KNOWN, SEEN, np.inf).astype("<f4").view(np.uint8).reshape(H, W, 4), "depth.png", 1e-6),
    "rgb24:10": (CHANNELS[..., ::-1], "depth.png", 1e-6),  # red is written last
    "bgr24:10": (np.dstack((CHANNELS, np.full(MM.shape, 255, np.uint8))), "depth.png", 1e-6),
}


@pytest.mark.parametrize("spec", SIMULATED)
def test_renderers_depth_is_exact_and_the_far_plane_is_missing(save, spec):
    values, name, tolerance = SIMULATED[spec]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        frame = ilf.load_frame(*save(values, name), encoding=spec)
    assert np.array_equal(frame.known, KNOWN)
    assert np.nanmax(np.abs(frame.depth - MM / 1000)) < tolerance
    text = encoding_of(frame.inputs.encoding).text
    assert text.startswith(f"{frame.inputs.encoding}, ")
    assert not any(word in text for word in ("FAR,", "METRES,", "reversed]")), "the numbers, not how they are written"
    again = ilf.load_frame(**frame.sources)
    assert again.inputs == frame.inputs
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)


@pytest.mark.parametrize(("name", "encoding"), [("a_domain_depth.png", "taskonomy"), ("depth.npy", "sun")])
def test_units_that_a_name_or_the_bits_say_are_told(save, name, encoding):
    """Taskonomy has 512 per metre; an array of bytes in the other order is checked like any other."""
    values = np.rint(MM * 0.512).astype(np.uint16) if encoding == "taskonomy" else STORED["sun"].astype(">u2")
    files = save(values, name)
    with pytest.warns(DepthWarning, match=f"most likely {encoding}"):
        ilf.load_frame(*files)
    assert np.nanmax(np.abs(ilf.load_frame(*files, encoding=encoding).depth - MM / 1000)) < 0.002


@pytest.mark.parametrize(
    ("stored", "told"),
    [
        (STORED["float16"], r"float16 gives 2\.\d\d m"),
        (4 * MM, r"with 5000 units per metre it would be 1\.85 m.*with 4000 2\.31 m, with 6553\.5 1\.41 m\.$"),
    ],
    ids=["half floats", "L515"],
)
def test_an_unusual_scale_names_all_that_it_may_be(save, stored, told):
    with pytest.warns(DepthWarning, match=told):
        ilf.load_frame(*save(stored))


def test_depth_along_the_negative_axis_is_told(save):
    """As Isaac Gym gives it."""
    for nothing in (-np.inf, np.inf, 0):
        values = np.where(KNOWN, MM / -1000, nothing).astype(np.float32)
        with pytest.raises(FormatError, match=r"negative.*the other sign"):
            ilf.load_frame(*save(values, "depth.npy"))
    with pytest.raises(InputError, match="no known pixel"):  # -1 marks missing depth
        ilf.load_frame(*save(np.full((H, W), -1, np.float32), "depth.npy"))


def test_bits_of_floats_are_not_those_of_floats():
    with pytest.raises(FormatError, match="four channels of 8 bits, not to float32"):
        encoding_of("float32").metres(np.ones((H, W), np.float32))


def test_streets_of_a_renderer_are_not_cut_at_a_sensors_range(save):
    depth = np.geomspace(2, 900, H * W).reshape(H, W)
    frame = ilf.load_frame(*save((depth / 1000).astype(np.float32), "depth.npy"), encoding="m/1000")
    assert np.allclose(frame.depth, depth)


@pytest.mark.parametrize(
    "spec",
    ["zbuffer", "zbuffer:1", "zbuffer:2,1", "zbuffer:0,9", "zbuffer:1,9,up", "m/", "m/-1", "m/2,1", "rgb24", "bgr24:x"],
)
def test_numbers_of_a_renderer_that_are_none_are_told_with_their_form(save, spec):
    with pytest.raises(ParameterError, match=r"zbuffer:NEAR,FAR|m/FAR|24:METRES|positive"):
        ilf.load_frame(*save(MM), encoding=spec)


def test_files_that_are_not_of_a_renderers_encoding_are_refused(save, tmp_path):
    in_metres = save((MM / 1000).astype(np.float32), "depth.npy")
    with pytest.raises(FormatError, match=r"applies to 0 to 1.* not to 3\.5"):
        ilf.load_frame(*in_metres, encoding="zbuffer:0.1,10")
    with pytest.raises(FormatError, match="3 channels"):
        ilf.load_frame(*save(MM), encoding="rgb24:1000")
    with pytest.raises(FormatError, match="JPEG"):
        ilf.load_frame(*save(CHANNELS, "depth.jpg"), encoding="rgb24:10")
    with pytest.raises(FormatError, match="rgb24:METRES"):
        ilf.load_frame(*save(CHANNELS))


def test_named_scales_are_numbers_of_units(save):
    files = save(MM)
    for name, units in {"mm": 1000, "tum": 5000, "0.1mm": 10_000, "bop:0.5": 2000, "4000": 4000, 256: 256}.items():
        frame = ilf.load_frame(*files, encoding=name, warn=False)
        assert (frame.inputs.depth_units, frame.inputs.encoding) == (units, None)
        assert np.array_equal(frame.depth, ilf.load_frame(*files, depth_units=units, warn=False).depth, equal_nan=True)


def test_every_name_has_a_meaning():
    with_numbers = {"bop", "disparity", "ray", "zbuffer", "m/FAR", "rgb24", "bgr24"}
    assert set(ENCODING_DESCRIPTIONS) == {*ENCODINGS, *with_numbers}
    assert all(encoding.name in {None, name} for name, encoding in ENCODINGS.items())


@given(st.integers(1, 65535))
def test_bits_of_sun_rgbd_turn_back_whatever_the_depth(depth):
    stored = np.array([[(depth << 3 | depth >> 13) & 0xFFFF]], np.uint16)
    assert ENCODINGS["sun"].metres(stored)[0, 0] == np.float32(depth / 1000)


TINY = '{"4": {"cam_K": [5, 5, 4, 3], "depth_scale": 1e-320}}'


def test_bop_takes_the_scale_of_the_very_image(tmp_path, save):
    scene = {
        str(number): {"cam_K": [500, 0, 40, 0, 500, 30, 0, 0, 1], "depth_scale": scale}
        for number, scale in ((3, 0.5), (12, 2.0))
    }
    (tmp_path / "scene_camera.json").write_text(json.dumps(scene))
    (tmp_path / "depth").mkdir()
    for number, scale in ((3, 0.5), (12, 2.0)):
        rgb, depth = save(np.where(KNOWN, 2000 / scale, 0).astype(np.uint16), f"depth/{number:06d}.png")
        frame = ilf.load_frame(rgb, depth, encoding="bop")
        assert float(np.nanmedian(frame.depth)) == 2.0
        assert frame.inputs.depth_units == 1000 / scale
        assert f"{1000 / scale:g} (2.00 m)" in "".join(ilf.load_frame(rgb, depth, warn=False).notes)
    rgb, depth = save(MM, "depth/000004.png")
    with pytest.raises(InputError, match="no entry for 000004"):
        ilf.load_frame(rgb, depth, encoding="bop")
    for broken in ('{"4": {"cam_K": [1], "depth_scale": 1}}', '{"4": []}', "[]", "{", TINY):
        (tmp_path / "scene_camera.json").write_text(broken)
        with pytest.raises(FormatError, match=r"scene_camera\.json"):
            ilf.load_frame(rgb, depth, encoding="bop")
    with pytest.raises(InputError, match="not in a BOP scene"):
        ilf.load_frame(*save(MM), encoding="bop")


# what is missing


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_an_invalid_value_is_missing(save, dtype):
    values = np.where(KNOWN, MM, 65535).astype(dtype)
    files = save(values, "depth.npy")
    frame = ilf.load_frame(*files, encoding="mm", invalid=65535)
    assert np.array_equal(frame.known, KNOWN)
    assert frame.inputs.invalid == 65535
    assert frame.sources["invalid"] == 65535
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)


@pytest.mark.parametrize("mark", [np.finfo(np.float32).max, 1e6, 1000.0])
def test_what_no_sensor_gives_is_missing_and_told(save, mark):
    files = save(np.where(KNOWN, MM / 1000, mark).astype(np.float32), "depth.npy")
    with pytest.warns(DepthWarning, match=r"beyond 300 m.*counts as missing: 200 pixels \(4\.2%\)"):
        frame = ilf.load_frame(*files)
    assert np.array_equal(frame.known, KNOWN)


def test_a_mark_may_fill_most_of_the_frame():
    values = np.where(np.arange(H * W).reshape(H, W) % 10 == 0, 2.0, 1e6)
    metres, told = decoded(values, ENCODINGS["m"])
    assert np.isfinite(metres).mean() == 0.1
    assert "90.0%" in told


def test_depth_that_is_all_too_far_is_a_matter_of_units(save):
    with pytest.raises(InputError, match="try a larger number of file units"):
        ilf.load_frame(*save(MM), encoding="m")


def test_disparity_beyond_what_a_kinect_sees_is_missing():
    values = np.full((2, 500), 900, np.uint16)
    values[0, 0] = 1080  # 28 m
    metres, told = decoded(values, ENCODINGS["kinect-raw"])
    assert np.isnan(metres[0, 0])
    assert "beyond 10 m" in told


def test_truth_beyond_all_sensors_is_unknown(save):
    ground_truth = np.where(KNOWN, MM / 1000, 1e6).astype(np.float32)
    files = save(MM)
    _, path = save(ground_truth, "laser.npy")
    frame = ilf.load_frame(*files, ground_truth=path)
    assert np.array_equal(np.isfinite(frame.ground_truth), KNOWN)


# what is doubted


@pytest.mark.parametrize(
    ("name", "sign"),
    [
        ("sun", "lowest three bits"),
        ("mm-swapped", "two bytes"),
        ("nyu-raw", "two bytes"),
        ("kinect-raw", "maximum value is 2047"),
        ("depth16", "highest three bits"),
    ],
)
def test_another_storage_is_recognised_and_named(save, name, sign):
    # a floor that is long enough for the many values that real depth has
    wide = np.repeat(np.repeat(STORED[name], 4, 0), 4, 1)
    rgb, depth = save(wide)
    try:
        with pytest.warns(DepthWarning, match=sign) as told:
            ilf.load_frame(rgb, depth)
        text = str(told[0].message)
    except InputError as error:  # its scale is absurd, too
        text = str(error)
    assert sign in text
    assert f"most likely {name}, with a median of 2." in text
    assert ilf.load_frame(rgb, depth, encoding=name).notes == ()


def test_confidence_that_varies_is_known_from_depth_that_is_far(save):
    varied = np.where(KNOWN, MM | (np.arange(W) % 8 << 13), 0).astype(np.uint16)
    for values, is_doubted in ((varied, True), (3 * MM, False)):  # 3.9 to 10.8 m: they cross 2 to the power of 13
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            ilf.load_frame(*save(values))
        assert any("most likely depth16" in str(one.message) for one in told) == is_doubted


def test_millimetres_that_happen_to_end_at_2047_are_no_disparity(save):
    values = np.where(KNOWN, np.minimum(MM, 2040), 0).astype(np.uint16)
    values[0, :3] = NEVER
    rgb, depth = save(values)
    assert ilf.load_frame(rgb, depth).notes == ()


@pytest.mark.parametrize(
    ("values", "name", "mark"),
    [
        (np.where(KNOWN, MM, 65535).astype(np.uint16), "depth.png", "65535"),
        (np.where(KNOWN, MM, 8191).astype(np.uint16), "depth.png", "8191"),
        (np.where(KNOWN, MM, 10_000).astype(np.uint16), "depth.png", "10000"),
        (np.where(KNOWN, MM / 1000, 10).astype(np.float32), "depth.npy", "10"),
        (np.where(KNOWN, MM / 1000, 20).astype(np.float64), "depth.npy", "20"),
    ],
)
def test_one_far_value_in_all_holes_is_doubted(save, values, name, mark):
    values[0, 0] = min(1.5 * values.max(), 65535)  # noise is farther
    files = save(values, name)
    with pytest.warns(DepthWarning, match=rf"{mark} fills 4\.2% of the pixels .* Give {mark} as the invalid value"):
        frame = ilf.load_frame(*files)
    assert len(frame.plausibility_warnings) == 1
    assert np.nanmax(frame.depth) > 8, "it is asked about, not decided"
    assert ilf.load_frame(*files, invalid=float(mark)).plausibility_warnings == ()
    assert ilf.load_frame(*files, invalid=0).notes == (), "0 says that there is none"


def test_any_far_value_in_many_holes_is_doubted(save):
    holes = np.zeros((H, W), bool)
    holes[5:45:4, 5:75:6] = True
    files = save(np.where(holes, 9000, np.maximum(MM, 1300)).astype(np.uint16))
    with pytest.warns(DepthWarning, match="9000 fills"):
        ilf.load_frame(*files)


FLOOR = np.linspace(0.15, 0.53, 4 * H)[:, None] + np.zeros(4 * W)  # inverse depth [1/m]: 6.7 m at the top, 1.9 m below


@pytest.mark.parametrize(
    "values", [FLOOR, 52.5 * FLOOR, 2 * FLOOR], ids=["inverse depth", "disparity", "of what is near"]
)
def test_what_rises_where_depth_should_fall_is_doubted(save, values):
    files = save(values.astype(np.float32), "depth.npy")
    surely = "are most likely" if np.median(values) > 6 else "may be"  # depth of 0.3 to 6 m is plausible
    with pytest.warns(DepthWarning, match=rf"they {surely} disparity or inverse depth.*disparity:FB"):
        ilf.load_frame(*files)
    assert (
        ilf.load_frame(*files, encoding="disparity:1" if values.max() < 2 else "disparity:52.5").plausibility_warnings
        == ()
    )
    sound = save((1 / values).astype(np.float32), "sound.npy")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if np.median(1 / values) > 0.1:
            assert ilf.load_frame(*sound).plausibility_warnings == ()


def test_what_rises_too_far_to_be_read_names_disparity(save):
    with pytest.raises(InputError, match=r"median depth would be.*most likely disparity or inverse depth"):
        ilf.load_frame(*save((300 * FLOOR).astype(np.float32), "depth.npy"))


def _of_kinect() -> np.ndarray:
    """A floor from 1.5 to 4 m as a Kinect v1 measures it, in steps of its disparity [mm]."""
    disparity = np.linspace(1092.5 - 351.3 / 4, 1092.5 - 351.3 / 1.5, 4 * H).round()
    return (351.3e3 / (1092.5 - disparity))[:, None] + np.zeros(4 * W)


def _sign_of(folder: Path, values: np.ndarray, name: str = "depth.png") -> list[str | None]:
    rgb, depth = write_rgbd(folder, values.astype(np.uint16), name)
    return [doubt.encoding for doubt in read_depth(FrameRef(str(rgb), str(depth))).plausibility_warnings]


def test_kitti_read_as_millimetres_is_doubted(tmp_path):
    kinect = _of_kinect()
    assert _sign_of(tmp_path / "kinect", kinect) == []
    assert _sign_of(tmp_path / "steps", kinect * 0.256) == ["kitti"], "0.6 m, but in steps of what is 2.4 m away"
    street = np.repeat(np.linspace(10_000, 1000, 94)[:, None], 311, 1)
    assert _sign_of(tmp_path / "wide", street) == ["kitti"], "no camera has such an aspect"
    assert _sign_of(tmp_path / "drive/proj_depth/velodyne_raw/image_02", street[:, :100]) == ["kitti"]
    assert _sign_of(tmp_path / "cut", street[:, :100]) == []
    lidar = np.where(np.random.default_rng(0).random(street.shape) < 0.2, street * 0.5 + 600, 0)
    assert _sign_of(tmp_path / "sparse", lidar) == ["kitti"], "within 22 m"
    assert _sign_of(tmp_path / "room", np.repeat(np.geomspace(6000, 900, 94)[:, None], 311, 1)) == [None]
    files = tmp_path / "wide/rgb.png", tmp_path / "wide/depth.png"
    with pytest.warns(DepthWarning, match=r"KITTI: .* encoding is most likely kitti, with a median of 21\.\d\d m"):
        ilf.load_frame(*files)
    assert ilf.load_frame(*files, encoding="kitti").plausibility_warnings == ()


def test_replica_is_offered_for_replica(tmp_path):
    far = _of_kinect() * 6.5535
    assert _sign_of(tmp_path / "results", far, "depth000000.png") == ["replica"]
    assert _sign_of(tmp_path / "Replica/office0/results", far) == ["replica"]
    assert _sign_of(tmp_path / "size", np.repeat(np.linspace(40_000, 6000, 680)[:, None], 1200, 1)) == ["replica"]
    assert _sign_of(tmp_path / "any", far) == ["replica"], "by the steps of a Kinect"
    assert _sign_of(tmp_path / "slope", np.repeat(np.linspace(40_000, 6000, H)[:, None], W, 1)) == [None]
    assert _sign_of(tmp_path / "results", _of_kinect(), "depth000001.png") == [], "millimetres by that name"


@pytest.mark.parametrize(
    "values",
    [
        MM,
        np.where(KNOWN, MM // 8 * 8 + 1, 0),  # another step of eight
        MM // 16 * 16,
        np.where(KNOWN, 2000, 0),
        np.where(np.arange(W) < W // 2, 1000, 4000) + np.zeros((H, 1), int),
        np.where(KNOWN, np.minimum(MM, 2500), 0),  # all that is farther is cut off
        np.where(KNOWN, MM, 8000),  # a wall, as far as one sees
        MM // 25 * 25,
    ],
    ids=["plain", "odd", "sixteen", "level", "two walls", "cut off", "wall", "coarse"],
)
def test_plain_depth_is_not_doubted(save, values):
    assert ilf.load_frame(*save(values.astype(np.uint16))).notes == ()


def test_an_unusual_scale_is_doubted_unless_it_is_named(save):
    files = save((MM * 5).astype(np.uint16))
    with pytest.warns(DepthWarning, match="with 5000 units per metre it would be"):
        ilf.load_frame(*files)
    assert ilf.load_frame(*files, encoding="mm").notes == ()
    assert len(ilf.load_frame(*files, depth_units=1000).notes) == 1, "whoever states units is not warned by Python"


# how it is said


def test_units_and_encoding_are_one_thing(save):
    files = save(MM)
    with pytest.raises(ParameterError, match="give only one of them"):
        ilf.load_frame(*files, depth_units=1000, encoding="mm")
    with pytest.raises(ParameterError, match="Did you mean nyu-raw"):
        ilf.load_frame(*files, encoding="nyu_raw")
    with pytest.raises(ParameterError, match="Did you mean sun"):
        encoding_of("suns")
    for wrong in (0, -1, float("nan"), "-5", "bop:0", "bop:x", True):
        with pytest.raises(ParameterError):
            ilf.load_frame(*files, encoding=wrong)
    for wrong in (float("inf"), "65535", True):
        with pytest.raises(ParameterError, match="invalid value must be a"):
            ilf.load_frame(*files, invalid=wrong)


def test_bits_of_floats_have_no_order(save):
    with pytest.raises(FormatError, match=r"depth\.npy: .* 16-bit integers, not to float32"):
        ilf.load_frame(*save((MM / 1000).astype(np.float32), "depth.npy"), encoding="sun")


def test_meta_json_says_it_and_what_is_given_goes_first(tmp_path, save):
    save(np.where(KNOWN, STORED["sun"], 65535).astype(np.uint16))
    meta = tmp_path / "meta.json"
    meta.write_text(json.dumps({"depth_encoding": "sun", "depth_invalid": 65535}))
    for paths in ((tmp_path,), (tmp_path / "rgb.png", tmp_path / "depth.png")):
        frame = ilf.load_frame(*paths)
        assert np.array_equal(np.nan_to_num(frame.depth * 1000).round(), MM)
        assert np.nanmedian(ilf.load_frame(*paths, depth_units=8000).depth) == np.nanmedian(frame.depth)
    for wrong in (
        {"depth_encoding": "sun", "depth_units_per_m": 1000},
        {"depth_encoding": ["sun"]},
        {"depth_encoding": "sun", "depth_invalid": "no"},
        {"depth_encoding": True},
        {"depth_encoding": 10**400},
        {"depth_encoding": "sunny"},
    ):
        meta.write_text(json.dumps(wrong))
        with pytest.raises(FormatError, match=r"meta\.json"):
            ilf.load_frame(tmp_path)
    meta.write_text(json.dumps({"depth_encoding": "bop"}))
    with pytest.raises(InputError, match="not in a BOP scene"):
        ilf.load_frame(tmp_path)


def test_how_a_frame_was_read_is_told():
    file = InputFile("a.png", "0" * 64)
    inputs = FrameInputs(file, file, 5000.0, None, invalid=65535.0)
    assert encoding_of_inputs(inputs).text == "5000 units per metre, 65535 is missing"


def test_command_line_reads_records_and_replays_it(tmp_path, save, capsys, cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    values = np.where(KNOWN, STORED["sun"], 65535).astype(np.uint16)
    save(values)
    files = ["rgb.png", "depth.png"]
    assert "warning:      65535 fills 4.2% of the pixels" in cli("info", *files).out
    how = ["--depth-encoding", "sun", "--invalid", "65535"]
    told = cli("info", *files, *how).out
    assert "encoding:     sun, millimetres with rotated bits (SUN RGB-D, SUN3D), 65535 is missing" in told
    assert "warning" not in told
    assert main(["info", *files, "--strict"]) == main(["complete", *files, "--out", "strict", "--strict"]) == 1
    told = capsys.readouterr().err.splitlines()
    assert [line[:31] for line in told] == ["ilf: error: The lowest three bi"] * 2
    assert not Path("strict").exists()
    assert main(["complete", *files, *how, "--strict", "--out", "out", "--max-iterations", "20", "--quiet"]) == 0
    assert "warning: No point cloud" in capsys.readouterr().err
    inputs = read_record("out/run.json").inputs
    assert (inputs.encoding, inputs.invalid, inputs.depth_units) == ("sun", 65535, 1000)
    record = json.loads(Path("out/run.json").read_text())
    record["inputs"]["encoding"] = "later"
    Path("later.json").write_text(json.dumps(record))
    with pytest.raises(FormatError, match="no depth encoding 'later'"):
        read_record("later.json")
    assert cli("complete", "--replay", "out/run.json", "--out", "again", "--no-cloud", "--quiet").err == ""
    assert Path("again/depth.npy").read_bytes() == Path("out/depth.npy").read_bytes()
    assert "leave out --depth-encoding, --invalid" in cli("complete", "--replay", "out/run.json", *how, status=2).err
    both = ["--depth-encoding", "sun", "--depth-units", "1000"]
    assert "not allowed with" in cli("info", *files, *both, status=2).err
