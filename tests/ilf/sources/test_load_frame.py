"""Reading frames: every format exactly, and every hostile file with one clear message."""

import hashlib
import inspect
import json
import os
import struct
import subprocess
import sys
import zlib
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image, ImageCms

import ilf
from ilf._runtime.schema import Section
from ilf.data.frame import FrameInputs, InputFile
from ilf.errors import FormatError, InputError, ParameterError
from ilf.io.depth import read_depth_values
from ilf.io.images import read_colour
from ilf.sources.frame_ref import OPTIONS, FrameRef, ReadingOptions

from ..depth_files import npy, pillow
from ..small_frames import write_small_frame

H, W = 24, 32
RNG = np.random.default_rng(7)
RGB = RNG.integers(0, 256, (H, W, 3), dtype=np.uint8)
MILLIMETRES = RNG.integers(500, 9000, (H, W), dtype=np.uint16)
MILLIMETRES[3:9, 4:12] = 0
METRES = np.where(MILLIMETRES > 0, MILLIMETRES / 1000, np.nan).astype(np.float32)


def encoded(suffix, array):
    return cv2.imencode(suffix, array)[1].tobytes()


def pgm16(array):
    return b"P5\n# a comment\n%d %d\n65535\n" % array.shape[::-1] + array.astype(">u2").tobytes()


def pgm_text(array):
    return b"P2\n%d %d\n65535\n" % array.shape[::-1] + " ".join(map(str, array.ravel().tolist())).encode() + b"\n"


# file name -> content and the values that must come out, for every kind of depth file
DEPTH_FILES = {
    "u16.png": (encoded(".png", MILLIMETRES), MILLIMETRES),
    "u16.tif": (encoded(".tif", MILLIMETRES), MILLIMETRES),
    "big-endian.tiff": (pillow(MILLIMETRES.astype(">u2"), "TIFF"), MILLIMETRES),
    "f32.tif": (encoded(".tif", METRES), METRES),
    "binary.pgm": (pgm16(MILLIMETRES), MILLIMETRES),
    "text.pgm": (pgm_text(MILLIMETRES), MILLIMETRES),
    "u16.npy": (npy(MILLIMETRES), MILLIMETRES),
    "i64.npy": (npy(MILLIMETRES.astype(">i8")), MILLIMETRES),
    "f32.npy": (npy(METRES), METRES),
    "f64-fortran.npy": (npy(np.asfortranarray(METRES, np.float64)), METRES),
    "f16.npy": (npy(METRES.astype(np.float16)), METRES.astype(np.float16)),
}
COLOUR_FILES = {
    "rgb.png": encoded(".png", RGB[..., ::-1]),
    "rgb.tif": encoded(".tif", RGB[..., ::-1]),
    "rgb.jpg": encoded(".jpg", RGB[..., ::-1]),
}


@pytest.fixture
def save(tmp_path):
    """Write `content` under a name that is not ASCII and return the path."""

    def write(name, content):
        folder = tmp_path / "größe 深度"
        folder.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
        return folder / name

    return write


@pytest.fixture
def colour(save):
    return save("rgb.png", COLOUR_FILES["rgb.png"])


@pytest.mark.parametrize("name", DEPTH_FILES)
def test_every_depth_format_is_read_exactly(name, save, colour):
    content, expected = DEPTH_FILES[name]
    path = save(name, content)
    np.testing.assert_array_equal(read_depth_values(path), expected)
    frame = ilf.load_frame(colour, path)
    np.testing.assert_array_equal(frame.known, MILLIMETRES > 0)
    tolerance = 4e-3 if "f16" in name else 0
    np.testing.assert_allclose(frame.depth, METRES, rtol=0, atol=tolerance)
    np.testing.assert_array_equal(frame.rgb, RGB)


@pytest.mark.parametrize("largest", [100, 255, 1023, 4095, 65535])
def test_colour_is_scaled_from_the_largest_value_that_its_file_declares(save, largest):
    values = np.rint(RGB.astype(float) * largest / 255).astype(">u2" if largest > 255 else np.uint8)
    expected = values.astype(float) * 255 / largest
    head = b"P6 # of\n# a camera\n%d %d\n%d\n" % (W, H, largest)
    text = b"P3\n%d %d\n%d\n" % (W, H, largest) + "\n".join(map(str, values.ravel().tolist())).encode() + b"\n"
    for name, content, most in (("binary.ppm", head + values.tobytes(), 0.501), ("text.ppm", text, 0.999)):
        path = save(name, content)
        assert np.abs(read_colour(path) - expected).max() <= most
        depth = save("d.png", DEPTH_FILES["u16.png"][0])
        assert ilf.load_frame(path, depth).notes == ()


@pytest.mark.parametrize(("bits", "factor"), [(8, 256), (10, 64), (12, 16)])
def test_colour_of_few_bits_in_16_is_doubted(save, bits, factor):
    depth = save("d.png", DEPTH_FILES["u16.png"][0])
    values = (RGB.astype(np.uint16) << 8) >> (16 - bits)
    rgb = save("few.png", encoded(".png", values[..., ::-1]))
    with pytest.warns(ilf.DepthWarning, match=rf"few\.png: Colour is nearly black.* {bits} bits .* by {factor}"):
        frame = ilf.load_frame(rgb, depth)
    assert frame.plausibility_warnings == frame.notes
    assert len(frame.plausibility_warnings) == 1
    assert ilf.load_frame(save("whole.png", encoded(".png", values * factor)), depth).notes == ()


def test_sources_tell_how_to_read_the_frame_again(save, colour, monkeypatch):
    depth = save("depth.png", DEPTH_FILES["u16.png"][0])
    monkeypatch.chdir(colour.parent)
    frame = ilf.load_frame("rgb.png", "depth.png", depth_units=2000, intrinsics="50,50,16,12")
    assert frame.sources == {
        "rgb": str(colour), "depth": str(depth), "depth_units": 2000.0, "intrinsics": [50.0, 50.0, 16.0, 12.0],
    }  # fmt: skip
    assert frame.name == colour.parent.name
    np.testing.assert_array_equal(ilf.load_frame(**json.loads(json.dumps(frame.sources))).depth, frame.depth)
    assert ilf.load_frame(colour, depth).sources["intrinsics"] is None


# --- colour


def test_deep_grey_and_transparent_colour_become_rgb8(save):
    deep = RGB.astype(np.uint16) * 257
    for suffix in (".png", ".tif"):
        np.testing.assert_array_equal(read_colour(save("deep" + suffix, encoded(suffix, deep[..., ::-1]))), RGB)
    grey = RGB[..., 0]
    expected = np.repeat(grey[..., None], 3, axis=2)
    np.testing.assert_array_equal(read_colour(save("grey.png", encoded(".png", grey))), expected)
    bgra = np.dstack([RGB[..., ::-1], np.full((H, W), 7, np.uint8)])
    np.testing.assert_array_equal(read_colour(save("alpha.png", encoded(".png", bgra))), RGB)
    np.testing.assert_array_equal(
        read_colour(save("r.png", encoded(".png", np.array([[[128, 129, 65535]]], np.uint16)))), [[[255, 1, 0]]]
    )


def test_a_tiff_may_have_a_smaller_version_of_its_image(save):
    for second in (RGB[::2, ::2], RGB):
        others = {"append_images": [Image.fromarray(second)], "tiffinfo": {254: int(second is RGB)}}
        pages = pillow(RGB, "TIFF", save_all=True, **others)
        np.testing.assert_array_equal(read_colour(save("pages.tif", pages)), RGB)


def test_float_colour_is_refused(save):
    with pytest.raises(FormatError, match=r"8 or 16 bits.*float32.*wrong order"):
        read_colour(save("f.tif", encoded(".tif", METRES)))
    lab = ImageCms.buildTransform(ImageCms.createProfile("sRGB"), ImageCms.createProfile("LAB"), "RGB", "LAB")
    with pytest.raises(FormatError, match=r"CIELAB colour, not RGB. Export it as RGB"):
        read_colour(save("lab.tif", pillow(ImageCms.applyTransform(Image.fromarray(RGB), lab), "TIFF")))


# --- hostile depth

PICKLED = npy(np.array([{}], object), allow_pickle=True)
HOSTILE_DEPTH = {
    "8-bit.png": (encoded(".png", RGB[..., 0]), "8-bit image.*raw 16-bit"),
    "colour-map.png": (encoded(".png", RGB), "8-bit image.*3 channels.*swapped"),
    "picture.jpg": (encoded(".jpg", RGB), "8-bit image"),
    "8-bit.npy": (npy(RGB[..., 0]), "8-bit image"),
    "bytes-as-float.npy": (npy(np.arange(H * W, dtype=np.float32).reshape(H, W) % 256), "8-bit image"),
    "8-bit.pgm": (b"P5\n4 4\n255\n" + bytes(16), "8-bit image"),
    "three.png": (encoded(".png", np.dstack([MILLIMETRES] * 3)), r"not \(24, 32, 3\).*one channel"),
    "flat.npy": (npy(METRES.ravel()), "shape .*one channel"),
    "volume.npy": (npy(np.stack([METRES, METRES])), "shape .*one channel"),
    "none.npy": (npy(np.zeros((0, 4), np.float32)), "truncated|shape"),
    "complex.npy": (npy(METRES.astype(complex)), "real numbers"),
    "bool.npy": (npy(METRES > 1), "real numbers"),
    "text.npy": (npy(np.array([["a", "b"]])), "real numbers"),
    "record.npy": (npy(np.zeros((2, 2), [("z", "f4")])), "real numbers"),
    "pickled.npy": (PICKLED, "Python objects"),
    "archive.npy": (b"PK\x03\x04" + bytes(50), "a zip archive, not an NPY"),
    "bare-pickle.npy": (b"\x80\x04K\x01.", "a Python pickle, not an NPY"),
    "text.png": (b"depth = 1.5\n", "a text file, not a PNG"),
    "wrong.npy": (encoded(".png", MILLIMETRES), "a PNG image, not an NPY"),
    "empty.png": (b"", "empty"),
    "empty.npy": (b"", "empty"),
    "big.tif": (b"II+\x00\x08\x00\x00\x00" + bytes(64), "BigTIFF"),
    "stack.tif": (cv2.imencodemulti(".tif", [MILLIMETRES] * 2)[1].tobytes(), "several images of one size"),
    "bitmap.pbm": (b"P4\n8 8\n" + bytes(8), "a PBM image of one bit, not a PNG"),
    "all-missing.png": (encoded(".png", np.zeros((H, W), np.uint16)), "no known pixel"),
    "other-size.png": (encoded(".png", MILLIMETRES[:-1]), "32 x 24 .* 32 x 23.*Give both cameras"),
    "turned.png": (encoded(".png", MILLIMETRES[::2, ::2].T), "32 x 24 .* 12 x 16.*turned by 90 degrees"),
    "absurd.npy": (npy(METRES * 1000), "median depth .*larger"),
    "tiny.npy": (npy(METRES / 1000), "median depth .*smaller"),
    "header-only.png": (
        b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
            for kind, body in [(b"IHDR", struct.pack(">IIBBBBB", 20000, 20000, 16, 0, 0, 0, 0)), (b"IEND", b"")]
        ), "20000 x 20000 pixels.*49 GB of memory, but only 8 GB are allowed.*ILF_MEMORY=49"),
    "huge.pgm": (b"P5\n99999 99999\n65535\n", "GB of memory"),
    "greedy.npy": (npy(METRES).replace(b"(24, 32), }      ", b"(99999, 99999), }"), "NPY cannot be read.*truncated"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE_DEPTH)
def test_hostile_depth_gets_one_clear_message_with_the_files_name(name, save, colour, capfd):
    content, message = HOSTILE_DEPTH[name]
    path = save(name, content)
    with pytest.raises(InputError, match=message) as caught:
        ilf.load_frame(colour, path)
    text = str(caught.value)
    assert str(path) in text
    assert "\n" not in text
    assert text.endswith((".", ")", "?"))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", [*DEPTH_FILES, *COLOUR_FILES])
@pytest.mark.parametrize("share", [0.02, 0.6, 0.99])
def test_truncated_files_of_every_format(name, share, save, capfd):
    content = COLOUR_FILES.get(name) or DEPTH_FILES[name][0]
    path = save(name, content[: max(1, int(share * len(content)))])
    reader = read_colour if name in COLOUR_FILES else read_depth_values
    with pytest.raises(FormatError, match=r"truncated|damaged|not a PNG") as caught:
        reader(path)
    assert str(path) in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_damaged_png_is_not_read_as_other_values(save):
    content = bytearray(DEPTH_FILES["u16.png"][0])
    content[len(content) // 2] ^= 1
    with pytest.raises(FormatError, match="checksum"):
        read_depth_values(save("d.png", bytes(content)))


@pytest.mark.parametrize("reader", [read_colour, read_depth_values])
def test_paths_that_are_no_files(reader, tmp_path):
    for path, message in [
        (tmp_path / "absent.png", "no such file"), (tmp_path, "is a folder"),
        ("nul\0byte.png", "no such file|cannot be read"), ("x" * 5000 + ".png", "cannot be read|no such file"),
    ]:  # fmt: skip
        with pytest.raises(InputError, match=message):
            reader(path)


def test_a_pipe_is_refused_instead_of_waited_for(tmp_path):
    if not hasattr(os, "mkfifo"):
        pytest.skip("this system has no named pipes")
    os.mkfifo(tmp_path / "pipe.png")
    with pytest.raises(InputError, match="device or a pipe"):
        read_depth_values(tmp_path / "pipe.png")


def test_a_file_that_may_not_be_read(save, monkeypatch):
    path = save("d.png", DEPTH_FILES["u16.png"][0])

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(np, "fromfile", refuse)
    with pytest.raises(InputError, match=r"Permission denied.*permissions"):
        read_depth_values(path)


def test_absurdly_large_files_are_refused_unread(save):
    path = save("d.png", b"x")
    os.truncate(path, 2**31)
    with pytest.raises(FormatError, match=r"2\.0 GiB"):
        read_depth_values(path)


@pytest.mark.parametrize("units", [0, -1000, float("nan"), float("inf"), "1000", True, None])
def test_depth_units_must_be_positive(units, save, colour):
    depth = save("d.png", DEPTH_FILES["u16.png"][0])
    if units is None:
        assert ilf.load_frame(colour, depth, depth_units=None).sources["depth_units"] == 1000
        return
    with pytest.raises(ParameterError, match=r"[Dd]epth units"):
        ilf.load_frame(colour, depth, depth_units=units)


# --- folders with meta.json

META = {"name": "kitchen", "size": [W, H], "depth_units_per_m": 1000, "K": [30, 30.5, 16, 12]}


@pytest.fixture
def folder(tmp_path):
    def make(meta, names=("rgb.png", "depth.png")):
        root = tmp_path / "frame"
        root.mkdir()
        if meta is not None:
            (root / "meta.json").write_bytes(meta if isinstance(meta, bytes) else json.dumps(meta).encode())
        contents = {"rgb": COLOUR_FILES["rgb.png"], "depth": DEPTH_FILES["u16.png"][0]}
        for name in names:
            (root / name).write_bytes(contents.get(name.split(".")[0], contents["depth"]))
        return root

    return make


@pytest.mark.parametrize("names", [(), ("rgb.png", "depth.png")], ids=["folder", "two files in it"])
def test_a_frame_is_read_as_its_meta_says(folder, names):
    root = folder({**META, "depth_units_per_m": 500} | ({"size": [1, 1]} if names else {}))
    given = [root / name for name in names] or [root]
    frame = ilf.load_frame(*given)
    np.testing.assert_array_equal(frame.depth, METRES * 2)
    assert (frame.name, frame.intrinsics.fy, frame.sources["depth_units"]) == ("kitchen", 30.5, 500)
    assert frame.sources["depth"] == str(root / "depth.png")
    changed = ilf.load_frame(*given, depth_units=1000, intrinsics=[40, 40, 15, 11], name="other")
    np.testing.assert_array_equal(changed.depth, METRES)
    assert (changed.name, changed.intrinsics.fx) == ("other", 40)


@pytest.mark.skipif(os.name == "nt", reason="Windows refuses such names")
@pytest.mark.parametrize("meta", [None, {**META, "name": None}])
def test_a_folder_with_any_name_is_read_under_a_name_of_one_line(meta, folder):
    root = folder(meta)
    with_lines = root.rename(root.with_name("two\nlines"))
    assert ilf.load_frame(with_lines, depth_units=1000).name == "two lines"


@pytest.mark.parametrize("meta", [{**META, "depth": "other.png"}, {**META, "name": 7}, b"{not json"])
def test_two_files_can_be_had_whatever_a_meta_beside_them_is(meta, folder):
    root = folder(meta, ["rgb.png", "depth.png", "other.png"])
    frame = ilf.load_frame(root / "rgb.png", root / "depth.png")
    assert (frame.name, frame.intrinsics) == ("frame", None)


def test_folder_with_truth_only_says_what_is_there(folder):
    root = folder({**META, "depth_units_per_m": None, "gt_units_per_m": 10000}, ["rgb.jpg", "gt.png", "mask.png"])
    with pytest.raises(InputError, match=r"no raw depth.*gt\.png, mask\.png, rgb\.jpg.*depth units 10000"):
        ilf.load_frame(root)


@pytest.mark.parametrize(
    ("meta", "message"),
    [
        (b"", "empty"),
        (b"{not json", "not valid JSON"),
        (b"\xff\xfe\x00", "not valid JSON"),
        (b'{"K":' + b"[" * 100_000 + b"]" * 100_000 + b"}", "not valid JSON"),
        (b"9" * 5000, "not valid JSON"),
        ([1, 2], "JSON object"),
        ({}, "no depth_units_per_m"),
        ({**META, "depth_units_per_m": "1000"}, "depth_units_per_m"),
        ({**META, "depth_units_per_m": 0}, "depth_units_per_m"),
        ({**META, "depth_units_per_m": True}, "depth_units_per_m"),
        ({**META, "depth_units_per_m": 10**400}, "depth_units_per_m"),
        ({**META, "K": [1, 2, 3]}, "four numbers"),
        ({**META, "K": "nyu-kinect-v1"}, "plain numbers"),
        ({**META, "size": "640x480"}, "size"),
        ({**META, "size": [W]}, "size"),
        ({**META, "size": [H, W]}, "Correct its size"),
        ({**META, "name": 7}, "name"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_bad_meta_is_refused_by_name(meta, message, folder):
    root = folder(meta)
    with pytest.raises(InputError, match=message) as caught:
        ilf.load_frame(root)
    assert str(root) in str(caught.value)


@pytest.mark.parametrize("meta", [None, {"depth_units_per_m": 1000}])
@pytest.mark.parametrize("as_folder", [True, False])
def test_images_in_a_folder_ask_no_reader_of_recordings(as_folder, meta, tmp_path, monkeypatch):
    files = write_small_frame(tmp_path)
    if meta is not None:
        (tmp_path / "meta.json").write_text(json.dumps(meta))
    monkeypatch.setattr("ilf.sources.opening.built_in_kinds", lambda: pytest.fail("a reader of recordings was asked"))
    frame = ilf.load_frame(tmp_path) if as_folder else ilf.load_frame(*files)
    assert frame.shape == (60, 80)


def test_a_link_to_nothing_in_a_frame_folder_is_named(folder):
    root = folder(None, ["depth.png"])
    (root / "rgb.png").symlink_to("gone.png")
    with pytest.raises(InputError, match=r"rgb\.png: there is no such file"):
        ilf.load_frame(root)


def test_one_file_alone_is_no_frame(colour):
    with pytest.raises(InputError, match=r"needs a depth image.*meta\.json"):
        ilf.load_frame(colour)


# --- real frames


def test_the_hash_is_of_the_bytes_that_were_read(tmp_path):
    colour, depth = write_small_frame(tmp_path)
    read = {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in (colour, depth)}
    frame = ilf.load_frame(colour, depth)
    depth.write_bytes(b"another file")
    assert frame.inputs == FrameInputs(
        InputFile(str(colour), read[colour]), InputFile(str(depth), read[depth]), 1000.0, None
    )


EVERY_OPTION = ReadingOptions(
    encoding="tum",
    depth_units=5000.0,
    invalid=65535.0,
    dataset="/left/depth",
    min_confidence=2.0,
    intrinsics="kinect-v2",
    ground_truth="gt.png",
    ground_truth_units=1000.0,
    guide="guide.npy",
    guide_gives="metric",
    confidence="sure.png",
    depth_intrinsics="azure-kinect",
    undistort=True,
    view="depth",
    pose=tuple(np.eye(4).ravel().tolist()),
    max_gap=0.5,
    topics=("/colour", "/depth"),
    layout="scannet",
)


def test_every_reading_option_is_an_argument_of_load_frame_or_open_source():
    assert EVERY_OPTION.given.keys() == OPTIONS.keys()
    assert EVERY_OPTION.of_frame.given.keys() < inspect.signature(ilf.load_frame).parameters.keys()
    of_sources = {name for name, option in OPTIONS.items() if not option.one_frame}
    assert EVERY_OPTION.of_all_frames.given.keys() < of_sources < inspect.signature(ilf.open_source).parameters.keys()


def test_reading_options_come_back_from_json():
    by_numbers = replace(EVERY_OPTION.of_frame, depth_intrinsics=(60.0, 60.0, 31.5, 23.5))
    source = FrameRef("rgb.png", "depth.png", options=by_numbers)
    assert FrameRef.from_json(Section("frame", json.loads(json.dumps(source.to_json())))) == source


def test_options_given_go_before_those_of_the_files():
    stated = ReadingOptions(depth_units=1000.0, invalid=0.0, ground_truth="gt.png", ground_truth_units=1000.0)
    chosen = ReadingOptions(encoding="tum", ground_truth="other.npy").or_else(stated)
    assert chosen == ReadingOptions(encoding="tum", invalid=0.0, ground_truth="other.npy")
    assert ReadingOptions(ground_truth_units=1.0).or_else(stated) == replace(stated, ground_truth_units=1.0)


def test_frames_of_image_files_import_no_reader_of_recordings():
    code = """
import sys
import ilf
from ilf._runtime.installation import asset_path
room = asset_path("samples/room")
ilf.load_frame(room / "rgb.jpg", room / "depth.png")
assert len(ilf.open_source(room)) == 1
ilf.load_frame(room)
assert "fsspec" not in sys.modules
readers = "ros azure_kinect record3d scannet nyu stray_scanner arkit_scenes raw_pairs shards".split()
print(*(name for name in readers if f"ilf.sources.{name}" in sys.modules))
"""
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "\n"
