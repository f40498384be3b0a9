"""Recordings of phones and data sets in files of their own: what they are read as, and what is damaged or hostile.
All are written here in the documented layouts."""

import json
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import FormatError, InputError, ParameterError
from tests.ilf.image_files import write_file, write_rgbd
from tests.ilf.phone_files import (
    COLOUR_SIZE,
    COUNT,
    DEPTH_K,
    LEVELS,
    MM,
    SIZE,
    SMALL,
    TIMES,
    K,
    pose,
    sens,
    write_arkit,
    write_record3d,
    write_stray,
)

for package in ("av", "lzfse", "h5py"):
    pytest.importorskip(package)

METRES = np.where(MM > 0, MM / 1000, np.nan).astype(np.float32)

WRITERS: dict[str, Callable[[Path], Path]] = {
    "record3d": lambda folder: write_record3d(folder / "a.r3d"),
    "stray": lambda folder: write_stray(folder / "stray"),
    "arkit": lambda folder: write_arkit(folder / "arkit"),
    "arkit, large colour": lambda folder: write_arkit(folder / "arkit", "wide", SMALL),
}
KEYS = {"record3d": "1", "stray": "000001"}


@pytest.mark.parametrize("kind", WRITERS)
def test_colour_comes_to_the_pixels_of_depth(tmp_path, kind):
    source = ilf.open_source(WRITERS[kind](tmp_path))
    assert len(source) == COUNT
    assert source.is_registered
    assert source.timestamps == pytest.approx(TIMES)
    key = KEYS.get(kind, "4242_100.100")
    assert source.keys[1] == key
    frame = source.read(key)
    assert frame.shape == MM.shape
    assert np.array_equal(frame.depth, METRES, equal_nan=True)
    assert np.abs(frame.rgb.astype(int) - 100).max() <= 6
    camera = frame.intrinsics
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == DEPTH_K
    assert source.calibration(key).depth.pinhole == camera
    assert np.allclose(source.pose(key), pose(1), atol=1e-6)
    again = ilf.load_frame(**frame.sources)
    assert again.inputs == frame.inputs
    assert np.array_equal(again.rgb, frame.rgb)


@pytest.mark.parametrize("kind", ["record3d", "stray", "arkit, large colour"])
def test_a_raw_pair_has_colour_as_it_was_recorded(tmp_path, kind):
    source = ilf.open_source(WRITERS[kind](tmp_path))
    pair = source.read_pair(source.keys[0])
    camera = pair.colour_camera
    assert (pair.colour_camera.size, pair.depth_camera.size) == (COLOUR_SIZE, SIZE)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == K
    assert pair.rgb.shape[:2] == COLOUR_SIZE[::-1]


@pytest.mark.parametrize("kind", WRITERS)
def test_low_confidence_is_missing_where_it_is_asked_for(tmp_path, kind):
    path = WRITERS[kind](tmp_path)
    frame = ilf.open_source(path).read(KEYS.get(kind, "4242_100.100"))
    assert frame.invalid_mask is None
    assert "confidence map" in frame.notes[0]
    for least, low in ((1, LEVELS < 1), (2, LEVELS < 2)):
        sure = ilf.open_source(path, min_confidence=least).read(KEYS.get(kind, "4242_100.100"))
        assert np.array_equal(np.isnan(sure.depth), np.isnan(METRES) | low)
        assert np.array_equal(sure.measured, METRES, equal_nan=True)
        assert f"below {least} counts as missing" in sure.notes[0]
    with pytest.raises(InputError, match="from 0 to 2"):
        ilf.open_source(path, min_confidence=3).read(KEYS.get(kind, "4242_100.100"))


def test_frames_of_a_video_in_any_order(tmp_path):
    source = ilf.open_source(write_stray(tmp_path / "stray"))
    values = [int(source.read(key).rgb[0, 0, 0]) for key in ("000002", "000000", "000001", "000001")]
    assert np.allclose(values, [160, 40, 100, 100], atol=4)
    hashes = {source.read(key).inputs.rgb.sha256 for key in source.keys}
    assert len(hashes) == COUNT


def test_a_video_that_is_a_list_of_others_is_not_followed(tmp_path):
    folder = write_stray(tmp_path / "stray")
    (folder / "rgb.mp4").rename(folder / "other.mp4")
    (folder / "rgb.mp4").write_text("ffconcat version 1.0\nfile other.mp4\n")
    with pytest.raises(FormatError, match=f"{folder} is damaged"):
        ilf.open_source(folder).read("000000")


def test_a_link_that_leads_nowhere_in_a_folder_of_stray_scanner_is_passed_over(tmp_path):
    folder = write_stray(tmp_path / "stray")
    try:
        (folder / "broken").symlink_to(folder / "nothing")
    except OSError:
        pytest.skip("no links can be made here")
    assert len(ilf.open_source(folder)) == COUNT


def test_stray_scanner_with_depth_of_8_bits_or_twice_is_refused(tmp_path):
    twice = write_stray(tmp_path / "twice")
    np.save(twice / "depth" / "000001.npy", np.ones((2, 2), np.float32))
    with pytest.raises(InputError, match=r"000001\.npy and 000001\.png have the same name"):
        ilf.open_source(twice)
    folder = write_stray(tmp_path / "grey")
    for file in (folder / "depth").iterdir():
        cv2.imwrite(str(file), cv2.imread(str(file), cv2.IMREAD_UNCHANGED).astype(np.uint8))
    with pytest.raises(FormatError, match="this is an 8-bit image, not depth"):
        ilf.open_source(folder)


def test_scannet_is_registered_by_its_two_cameras(tmp_path):
    source = ilf.open_source(written(tmp_path / "a.sens", sens()))
    assert (source.keys, source.is_registered) == (("0", "1", "2"), False)
    assert source.timestamps == pytest.approx(TIMES)
    pair = source.read_pair("1")
    assert np.array_equal(pair.depth, METRES, equal_nan=True)
    assert (pair.colour_camera.size, pair.depth_camera.size) == (COLOUR_SIZE, SIZE)
    frame = source.read("1")
    assert frame.shape == COLOUR_SIZE[::-1]
    assert np.abs(frame.rgb.astype(int) - 100).max() <= 6
    assert frame.intrinsics.fx == K[0]
    own = ilf.open_source(tmp_path / "a.sens", view="depth", intrinsics=ilf.Camera(30, 31, 14, 12, size=SIZE)).read("1")
    assert (own.shape, own.intrinsics.numbers) == (SIZE[::-1], (30, 31, 14, 12))
    assert np.allclose(source.pose("1"), pose(1), atol=1e-6)
    shift = np.eye(4)
    shift[0, 3] = 0.05
    moved = ilf.open_source(written(tmp_path / "b.sens", sens(shift)))
    assert np.allclose(moved.calibration("0").depth_to_colour, shift)


def test_a_sequence_without_its_trajectory_has_no_poses(tmp_path):
    folder = write_arkit(tmp_path / "arkit")
    (folder / "lowres_wide.traj").unlink()
    assert ilf.open_source(folder)[0].pose is None


def test_info_tells_of_confidence_and_has_its_facts_in_line(tmp_path, capsys, cli):
    path = str(write_record3d(tmp_path / "a.r3d"))
    assert main(["info", path, "--frame", "1"]) == 0
    assert "confidence:   from 0 to 2. There is a confidence map, but all depth is used" in capsys.readouterr().out
    assert main(["info", path, "--frame", "1", "--min-confidence", "2"]) == 0
    assert "confidence:   from 0 to 2. Depth with a confidence below 2 counts" in capsys.readouterr().out
    assert "No depth has a confidence of 3" in cli("info", path, "--frame", "1", "--min-confidence", "3", status=1).err
    facts = cli("info", path).out.split("\n\n")[0].splitlines()
    assert any(fact.startswith("colour camera: ") for fact in facts)
    assert {len(fact) - len(fact.split(":", 1)[1].lstrip()) for fact in facts} == {15}


def test_confidence_beside_files(tmp_path, cli):
    folder = tmp_path / "frame"
    files = write_rgbd(folder, MM)
    write_file(folder / "sure.png", LEVELS)
    low = np.isnan(METRES) | (LEVELS < 2)
    frame = ilf.load_frame(*files, confidence=folder / "sure.png", min_confidence=2)
    assert np.array_equal(np.isnan(frame.depth), low)
    assert ilf.load_frame(*files, min_confidence=2).notes == (
        "There is no confidence map, so the min. confidence has no effect.",
    )
    meta = {"depth_units_per_m": 1000, "confidence": "sure.png", "min_confidence": 2}
    (folder / "meta.json").write_text(json.dumps(meta))
    assert np.array_equal(np.isnan(ilf.load_frame(folder).depth), low)
    assert "sure.png, from 0 to 2. Depth with a confidence below 2 counts as missing" in cli("info", folder).out
    assert np.array_equal(np.isnan(ilf.load_frame(folder, min_confidence=0).depth), np.isnan(METRES))
    (folder / "meta.json").write_text(json.dumps(meta | {"min_confidence": "high"}))
    with pytest.raises(FormatError, match="must be a number"):
        ilf.load_frame(folder)
    with pytest.raises(ParameterError, match="finite"):
        ilf.load_frame(*files, min_confidence=float("nan"))
    write_file(folder / "small.png", LEVELS[:-1])
    with pytest.raises(InputError, match="same pixels"):
        ilf.load_frame(*files, confidence=folder / "small.png", min_confidence=1)


def replaced(path: Path, name: str, content: bytes) -> Path:
    """A zip with another content of a member."""
    with zipfile.ZipFile(path) as archive:
        members = {one: archive.read(one) for one in archive.namelist()} | {name: content}
    with zipfile.ZipFile(path, "w") as archive:
        for one, data in members.items():
            archive.writestr(one, data)
    return path


@pytest.mark.parametrize("nothing", [None, [None], [[]], [[1.0]]])
def test_record3d_without_poses_and_cameras_of_frames(tmp_path, nothing):
    path = write_record3d(tmp_path / "a.r3d")
    with zipfile.ZipFile(path) as archive:
        metadata = json.loads(archive.read("metadata"))
    metadata |= {"poses": nothing and nothing * COUNT, "frameTimestamps": None, "perFrameIntrinsicCoeffs": None}
    frame = ilf.open_source(replaced(path, "metadata", json.dumps(metadata).encode())).read("1")
    assert frame.pose is None
    assert frame.intrinsics is not None


def changed(path: Path, pattern: str, change: Callable[[bytes], bytes | None]) -> Path:
    """A recording with the content of some of its files changed, or without them."""
    for file in list(path.glob(pattern)) if path.is_dir() else [path]:
        content = change(file.read_bytes())
        file.unlink() if content is None else file.write_bytes(content)
    return path


def cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def written(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def bomb() -> bytes:
    import lzfse

    return lzfse.compress(bytes(2_000_000))


DAMAGED: dict[str, tuple[Callable[[Path], Path], str]] = {
    "cut .r3d": (lambda f: changed(write_record3d(f / "a.r3d"), "", cut), "is damaged"),
    "no frames": (lambda f: _zip(f / "a.r3d"), "no frames"),
    "no sizes": (lambda f: write_record3d(f / "a.r3d", dw=None), "no .dw."),
    "huge depth": (lambda f: write_record3d(f / "a.r3d", dw=50_000, dh=100_000), "50000 x 100000 pixels"),
    "endless depth": (lambda f: write_record3d(f / "a.r3d", dw=10**400), "Resize or crop it first"),
    "other depth": (lambda f: write_record3d(f / "a.r3d", dw=40, dh=30), "is damaged"),
    "no camera": (lambda f: write_record3d(f / "a.r3d", K=[1, 2]), "K of nine numbers"),
    "bomb": (lambda f: replaced(write_record3d(f / "a.r3d"), "rgbd/0.depth", bomb()), "is damaged"),
    "no lzfse": (lambda f: replaced(write_record3d(f / "a.r3d"), "rgbd/0.depth", b"x" * 99), "is damaged"),
    "no jpeg": (lambda f: replaced(write_record3d(f / "a.r3d"), "rgbd/0.jpg", b"x" * 99), "not a PNG, JPEG"),
    "no json": (lambda f: replaced(write_record3d(f / "a.r3d"), "metadata", b"[" * 9), "not valid JSON"),
    "cut video": (lambda f: changed(write_stray(f / "s"), "rgb.mp4", cut), "video"),
    "no video": (lambda f: changed(write_stray(f / "s"), "rgb.mp4", lambda _: b"nothing"), "is damaged"),
    "short video": (lambda f: _more_depth(write_stray(f / "s")), "3 frames, but no frame 3"),
    "no matrix": (lambda f: changed(write_stray(f / "s"), "camera_matrix.csv", lambda _: b"1,2\n"), "camera matrix"),
    "no odometry": (lambda f: changed(write_stray(f / "s"), "odometry.csv", lambda _: b"a,b\n1,2\n"), "header line"),
    "other levels": (lambda f: changed(write_stray(f / "s"), "confidence/000000.png", lambda _: b""), "empty"),
    "no pincam": (
        lambda f: changed(write_arkit(f / "k"), "*/*.pincam", lambda _: b"1 2 3"),
        "width height fx fy cx cy",
    ),
    "no depth": (lambda f: changed(write_arkit(f / "k"), "lowres_depth/*", lambda _: None), "0 images with times"),
    "no .sens": (lambda f: written(f / "a.sens", b"x" * 500), "not a ScanNet recording"),
    "cut .sens": (lambda f: written(f / "a.sens", sens()[:-1]), "ends within frame 2 of 3"),
    "cut header": (lambda f: written(f / "a.sens", sens()[:100]), "is damaged"),
    "endless .sens": (lambda f: written(f / "a.sens", sens(count=2**60)), "is damaged"),
    "huge .sens": (lambda f: written(f / "a.sens", _with_size(100_000)), "100000 x 100000 pixels"),
    "other .sens": (lambda f: written(f / "a.sens", _with_size(20)), "does not have the 960 bytes"),
    "no .mat": (lambda f: written(f / "a.mat", b"x" * 500), "HDF5"),
}


def _zip(path: Path) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("metadata", "{}")
    return path


def _more_depth(path: Path) -> Path:
    for number in range(COUNT):
        (path / "depth" / f"{number:06}.png").rename(path / "depth" / f"{number + COUNT:06}.png")
    return path


def _with_size(width: int) -> bytes:
    before = struct.pack("<4I", *COLOUR_SIZE, *SIZE)
    return sens().replace(before, struct.pack("<4I", *COLOUR_SIZE, width, width if width > 1000 else SIZE[1]))


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_and_hostile_recordings_are_told_of_in_one_line(tmp_path, name, capfd):
    make, told = DAMAGED[name]
    path = make(tmp_path)
    with pytest.raises(InputError, match=told) as raised:
        ilf.open_source(path)[0]
    assert path.name in str(raised.value)
    assert "\n" not in str(raised.value)
    assert capfd.readouterr().out == ""
