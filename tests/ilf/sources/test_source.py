"""Sources: every layout that is opened, what its frames are read as, and what is damaged or hostile."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ilf
from ilf.cli import main
from ilf.errors import DepthWarning, FormatError, InputError, ParameterError
from ilf.sources.pairing import paired_by_time, time_of
from tests.ilf.image_files import write_file

H, W = 48, 64
MM = (1500 + 7 * np.arange(W)[None] + 20 * np.arange(H)[:, None]).astype(np.uint16)
MM[10:20, 30:40] = 0
K = [52, 0, 30.2, 0, 49, 24.9, 0, 0, 1]


@pytest.fixture
def save(tmp_path):
    def write(rgb: str, depth: str, values: np.ndarray = MM) -> None:
        write_file(tmp_path / rgb, np.full((H, W, 3), 90, np.uint8))
        write_file(tmp_path / depth, values)

    return write


def _is_read(frame: ilf.RGBDFrame) -> bool:
    return bool(np.array_equal(np.rint(np.nan_to_num(frame.depth) * 1000), MM))


def _bop(scales: dict[int, float]) -> str:
    return json.dumps({str(number): {"cam_K": K, "depth_scale": scale} for number, scale in scales.items()})


def test_reading_from_a_source_warns_of_what_it_doubts(tmp_path, save):
    save("results/frame000000.jpg", "results/depth000000.png", (MM * 6.5535).astype(np.uint16))
    source = ilf.open_source(tmp_path / "results", intrinsics=(50, 50, 32, 24))
    for read in (source.read, source.read_pair):
        with pytest.warns(
            DepthWarning, match=r"depth000000\.png: .*most likely replica, with a median of 2\.\d\d m"
        ) as told:
            read(source.keys[0])
        assert [Path(warning.filename).name for warning in told] == ["test_source.py"], "where it was called"


def test_frames_are_found_by_the_end_of_their_key(tmp_path, save):
    for name in ("a", "b"):
        save(f"{name}/1_rgb.png", f"{name}/1_depth.png")
    source = ilf.open_source(tmp_path)
    assert source.keys == ("a/1_rgb", "b/1_rgb")
    with pytest.raises(InputError, match=r"2 frames of .* end in '1_rgb'"):
        source.read("1_rgb")
    with pytest.raises(InputError, match=r"has no frame 'c'\. It has 2, from a/1_rgb to b/1_rgb"):
        source.find("c")


def test_folders_by_time_take_the_nearest_once(tmp_path, save):
    for time in (1305031102.10, 1305031102.14, 1305031102.5):
        save(f"rgb/{time:.6f}.png", f"unused/{time:.6f}.png")
    for time in (1305031102.11, 1305031102.13, 1305031103.0):
        save(f"unused/{time:.6f}.jpg", f"depth/{time:.6f}.png")
    source = ilf.open_source(tmp_path)
    assert source.keys == ("rgb/1305031102.100000", "rgb/1305031102.140000")
    assert source.timestamps == (1305031102.10, 1305031102.14)
    assert source.ref("1305031102.140000").depth.endswith("1305031102.130000.png")
    assert "1 colour image left out" in source.notes[0]
    assert len(ilf.open_source(tmp_path, max_gap=0.5)) == 3
    with pytest.raises(InputError, match="contains no frames"):
        ilf.open_source(tmp_path, max_gap=0.001)
    for wrong in (-1, float("nan")):
        with pytest.raises(ParameterError, match="maximum time gap"):
            ilf.open_source(tmp_path, max_gap=wrong)


@given(st.lists(st.integers(0, 400), unique=True, max_size=12), st.lists(st.integers(0, 400), unique=True, max_size=12))
def test_no_file_is_in_two_pairs_by_time(colours, depths):
    names = [[f"13050311{time:02d}.{time % 100:02d}.png" for time in times] for times in (colours, depths)]
    found = paired_by_time(*names, 0.05)
    assert len({rgb for rgb, _ in found.pairs}) == len({depth for _, depth in found.pairs}) == len(found.pairs)
    assert all(abs(time_of(rgb) - time_of(depth)) <= 0.051 for rgb, depth in found.pairs)


@pytest.mark.parametrize(
    ("folder", "fx"),
    [("rgbd_dataset_freiburg1_xyz", 517.3), ("rgbd_dataset_freiburg3_teddy", 535.4), ("rgbd_bonn_box", 542.822841)],
)
def test_sequences_of_tum_and_bonn(tmp_path, save, folder, fx):
    for time in (1.0, 1.1):
        save(f"{folder}/rgb/{time}.png", f"{folder}/depth/{time}.png", MM * 5)
    root = tmp_path / folder
    for what in ("rgb", "depth"):
        (root / f"{what}.txt").write_text(f"# list\n1.1 {what}/1.1.png\n1.0 {what}/1.0.png\n")
    (root / "groundtruth.txt").write_text("1.0 1 2 3 0 0 0 1\n1.1 4 5 6 0 0 0 1\n")
    source = ilf.open_source(root)
    assert (source.keys, source.timestamps) == (("rgb/1.0", "rgb/1.1"), (1.0, 1.1))
    assert source.calibration("rgb/1.0").colour.fx == fx
    assert source.pose("rgb/1.1")[:3, 3].tolist() == [4, 5, 6]
    assert _is_read(source.read("rgb/1.1"))
    assert source.calibration("1.0").colour.fx == fx
    mine = ilf.open_source(root, encoding="0.1mm", intrinsics=(50, 50, 32, 24))
    assert mine.read("1.0").inputs.depth_units == 10_000
    assert mine.calibration("1.0").colour.fx == 50


@pytest.mark.parametrize("line", ["{0} rgb/{0}.png {0} depth/{0}.png", "{0} depth/{0}.png {0} rgb/{0}.png"])
def test_pairs_side_by_side_in_a_list(tmp_path, save, line):
    for number in (1, 2):
        save(f"rgb/{number}.png", f"depth/{number}.png", MM * 5)
    (tmp_path / "associations.txt").write_text("\n".join(line.format(number) for number in (1, 2)))
    source = ilf.open_source(tmp_path)
    assert (source.keys, source.timestamps) == (("rgb/1", "rgb/2"), (1.0, 2.0))
    assert _is_read(source.read("2"))
    save("rgb/1.jpg", "depth/3.png", MM * 5)
    (tmp_path / "associations.txt").write_text("1 rgb/1.png 1 depth/1.png\n2 rgb/1.jpg 2 depth/2.png")
    assert ilf.open_source(tmp_path).keys == ("rgb/1", "rgb/1.jpg")
    twice = "1 rgb/1.png 1 depth/1.png\n2 rgb/1.png 2 depth/2.png"
    for wrong in ("1 rgb/1.png", "1 rgb/1.png x depth/1.png", twice, "#"):
        (tmp_path / "associations.txt").write_text(wrong)
        with pytest.raises(FormatError, match=r"associations\.txt"):
            ilf.open_source(tmp_path)


@pytest.mark.parametrize("digits", [6, 4])
def test_scenes_of_bop_have_a_scale_for_each_image(tmp_path, save, digits):
    for scene, scales in (("000001", {0: 0.5, 7: 1.0}), ("000002", {3: 0.1})):
        for number, scale in scales.items():
            save(
                f"{scene}/rgb/{number:0{digits}d}.jpg",
                f"{scene}/depth/{number:0{digits}d}.png",
                np.rint(MM / scale).astype(np.uint16),
            )
        (tmp_path / scene / "scene_camera.json").write_text(_bop({**scales, 99: 1.0}))
    source = ilf.open_source(tmp_path / "000001")
    assert source.keys == tuple(f"rgb/{number:0{digits}d}" for number in (0, 7))
    both = ilf.open_source(tmp_path)
    assert both.keys == (*(f"000001/{key}" for key in source.keys), f"000002/rgb/{3:0{digits}d}")
    for key in both.keys:
        assert _is_read(both.read(key))
        assert both.calibration(key).depth.fx == 52


def test_frames_of_sun_rgbd_have_their_bits_turned_back(tmp_path, save):
    for name in ("NYU0001", "NYU0002"):
        save(f"{name}/image/{name}.jpg", f"{name}/depth/00-{name}.png", (MM << 3) | (MM >> 13))
        (tmp_path / name / "intrinsics.txt").write_text("52 0 31.5\n0 52 23.5\n0 0 1\n")
    source = ilf.open_source(tmp_path)
    assert source.keys == ("NYU0001/image/NYU0001", "NYU0002/image/NYU0002")
    frame = source.read("NYU0002")
    assert _is_read(frame)
    assert (frame.inputs.encoding, frame.notes, frame.intrinsics.cx) == ("sun", (), 31.5)
    assert len(ilf.open_source(tmp_path / "NYU0001")) == 1
    for wrong in ("525 0", "", "a b c", "1 " * 8):
        (tmp_path / "NYU0001" / "intrinsics.txt").write_text(wrong)
        with pytest.raises(FormatError, match=r"intrinsics\.txt"):
            ilf.open_source(tmp_path / "NYU0001")
    (tmp_path / "NYU0002" / "depth" / "more.png").touch()
    with pytest.raises(InputError, match="1 colour and 2 depth files"):
        ilf.open_source(tmp_path / "NYU0002")


def test_frames_of_7_scenes_have_no_depth_of_65_metres(tmp_path, save):
    for number in (0, 1):
        name = f"frame-{number:06d}"
        save(f"{name}.color.png", f"{name}.depth.png", np.where(MM == 0, 65535, MM).astype(np.uint16))
        np.savetxt(tmp_path / f"{name}.pose.txt", np.eye(4) + number * np.eye(4, k=3))
    source = ilf.open_source(tmp_path)
    assert source.keys == ("frame-000000.color", "frame-000001.color")
    assert _is_read(source.read("frame-000001.color"))
    assert source.pose("frame-000001.color")[0, 3] == 1
    assert not source.is_registered
    assert "not registered" in source.notes[0]
    camera = source.calibration("frame-000000.color")
    assert (camera.colour, camera.depth.fx, camera.depth_to_colour) == (None, 585, None)


def test_command_line_tells_of_sources_and_completes_their_frames(tmp_path, save, capsys, cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in range(8):
        save(f"in/rgb/{number:06d}.png", f"in/depth/{number:06d}.png", MM * 2)
    Path("in/scene_camera.json").write_text(_bop(dict.fromkeys(range(8), 0.5)))
    told = cli("info", "in").out
    assert "in, 8 frames" in told
    assert "rgb/000002 ... rgb/000005" in told
    assert "depth camera:  fx 52" in told
    told = cli("info", "in", "--frame", "000003").out
    assert "encoding:     2000 units per metre\n" in told
    assert "range:        1.500 to 2.8" in told
    assert "fx 52" in told
    how = ["complete", "in", "--frame", "000003", "--out", "out", "--max-iterations", "20", "--no-cloud", "--quiet"]
    how += ["--png-units", "2000"]
    assert cli(*how).err == ""
    assert cli("complete", "--replay", "out/run.json", "--out", "again", "--quiet").err == ""
    assert Path("again/depth.npy").read_bytes() == Path("out/depth.npy").read_bytes()
    assert "--frame" in cli("complete", "in", status=1).err
    assert main(["complete", "in", "--frame", "000009"]) == 1
    assert "has no frame '000009'. It has 8, from rgb/000000 to rgb/000007." in capsys.readouterr().err
    assert main(["info", "in", "in", "--frame", "1"]) == 2
    assert main(["complete", "in/rgb/000003.png", "in/depth/000003.png", "--max-gap", "1"]) == 2
    assert main(["complete", "--replay", "out/run.json", "--frame", "1", "--max-gap", "1"]) == 2
    assert "leave out --frame, --max-gap" in capsys.readouterr().err
    assert "maximum time gap" in cli("info", "in", "--max-gap", "-1", status=1).err
    Path("empty").mkdir()
    assert "contains no frames" in cli("info", "empty", status=1).err


def test_a_source_is_read_by_number_by_key_and_one_after_the_other(tmp_path, save):
    for number in (10, 2, 1):
        save(f"color/{number}.jpg", f"depth/{number:04d}.png", (MM + number * (MM > 0)).astype(np.uint16))
    source = ilf.open_source(tmp_path, intrinsics=(50, 50, 32, 24))
    assert (len(source), source.keys, source.timestamps) == (3, ("color/1", "color/2", "color/10"), None)
    assert source.is_registered
    medians = [float(np.nanmedian(frame.depth)) for frame in source]
    assert medians == sorted(medians)
    assert len(set(medians)) == 3
    for place, wanted in ((0, 0), (2, 2), (-1, 2), (np.int64(1), 1), ("color/2", 1), ("10", 2)):
        assert float(np.nanmedian(source[place].depth)) == medians[wanted]
    for outside in (3, -4):
        with pytest.raises(IndexError, match="it has 3, from 0 to 2"):
            source[outside]
    with pytest.raises(InputError, match="has no frame 'nope'"):
        source["nope"]
    assert "color/2" in source
    assert "nope" not in source
    assert repr(source) == f"<Source {str(tmp_path)!r}: 3 frames>"
    camera = source.calibration("color/2")
    assert camera.colour == camera.depth == source.read("2").intrinsics
    assert np.array_equal(camera.depth_to_colour, np.eye(4))
    assert source.pose("1") is None
