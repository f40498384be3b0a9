"""Which frames a folder holds: every layout that is read, what is told of the rest, and what would be misread."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from gui.features.frame_list.thumbnails import read_thumbnail, thumbnail_of
from ilf._runtime.formatting import natural
from ilf.errors import FormatError, InputError
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import list_frames
from ilf.sources.pairing import paired
from ilf.sources.source import open_source


def _touch(root: Path, *names: str) -> Path:
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return root


def _named(root: Path, **how) -> list[tuple[str, str | None]]:
    return [
        (str(Path(source.rgb).relative_to(root)), source.depth and str(Path(source.depth).relative_to(root)))
        for source in list_frames(root, **how).sources
    ]


def test_folder_of_frame_folders_in_the_order_in_which_people_count(tmp_path):
    _touch(
        tmp_path, *(f"frame{number}/meta.json" for number in (10, 2, 1)), "notes.txt", ".hidden/meta.json", "more/x.txt"
    )
    assert _named(tmp_path) == [("frame1", None), ("frame2", None), ("frame10", None)]


def test_folders_without_meta_json_count_where_they_hold_one_pair(tmp_path):
    _touch(
        tmp_path, "a/rgb.png", "a/depth.png", "a/mask.png", "b/rgb.png", "c/1_rgb.png", "c/1_depth.png", "c/2_rgb.png"
    )
    _touch(tmp_path, "d/1_rgb.png", "d/1_depth.png", "d/2_rgb.png", "d/2_depth.png")
    _touch(tmp_path, "a/._rgb.png", "a/._depth.png")  # as macOS leaves them beside files on foreign drives
    assert _named(tmp_path) == [("a", None), ("c/1_rgb.png", "c/1_depth.png")]
    assert list_frames(tmp_path).notes[0].startswith("2 folders left out")


def test_links_that_lead_nowhere_do_not_count(tmp_path):
    _touch(tmp_path, "1_rgb.png", "1_depth.png")
    (tmp_path / "gone").symlink_to("nowhere")
    (tmp_path / "round").symlink_to("about")
    (tmp_path / "about").symlink_to("round")
    assert _named(tmp_path) == [("1_rgb.png", "1_depth.png")]
    (tmp_path / "1_rgb.png").unlink()
    _touch(tmp_path, "a/meta.json")
    assert _named(tmp_path) == [("a", None)]
    assert list_frames(tmp_path).notes == (), "none of them is a folder that is left out"


def test_names_that_differ_in_punctuation_or_case_only_are_pairs(tmp_path):
    names = ["a_b", "a;b", "a b", "A_b", "01", "1"]
    _touch(tmp_path, *(f"{folder}/{name}.png" for name in names for folder in ("rgb", "depth")))
    listing = list_frames(tmp_path)
    assert {Path(source.rgb).name for source in listing.sources} == {f"{name}.png" for name in names}
    assert all(Path(source.rgb).name == Path(source.depth).name for source in listing.sources)
    assert not listing.notes


def test_names_that_fit_several_files_are_named(tmp_path):
    _touch(tmp_path, "rgb/a_b.png", "rgb/a;b.png", "depth/a-b.png")
    with pytest.raises(InputError, match=r"a;b\.png and a_b\.png.*leave one"):
        list_frames(tmp_path)
    _touch(tmp_path, "rgb/1.png", "rgb/2.png", "depth/1.png")
    told = " ".join(list_frames(tmp_path).notes)
    assert "1 colour image left out: there is no depth image of that name." in told
    assert "a;b.png and a_b.png" in told


def test_numbers_that_agree_by_chance_are_no_pairs(tmp_path):
    _touch(tmp_path, *(f"rgb/1305.{n}.png" for n in (175304, 211214)), *(f"depth/1306.{n}.png" for n in (175304, 9)))
    with pytest.raises(InputError, match="contains no frames"):
        list_frames(tmp_path)


@pytest.mark.parametrize("colour", ["rgb", "Color", "colour", "image"])
def test_two_folders_matched_by_name(tmp_path, colour):
    _touch(
        tmp_path, *(f"{colour}/{n}.jpg" for n in (1, 2, 10, 11)), *(f"depth/{n}.png" for n in (10, 2, 1)), "depth/x.exr"
    )
    assert _named(tmp_path) == [(f"{colour}/{n}.jpg", f"depth/{n}.png") for n in (1, 2, 10)]
    assert list_frames(tmp_path).notes == ("1 colour image left out: there is no depth image of that name.",)


def test_two_folders_matched_by_number_where_names_differ(tmp_path):
    _touch(tmp_path, "rgb/cam0_0001.png", "rgb/cam0_0002.png", "depth/range-1.png", "depth/range-2.png")
    assert _named(tmp_path) == [("rgb/cam0_0001.png", "depth/range-1.png"), ("rgb/cam0_0002.png", "depth/range-2.png")]


@pytest.mark.parametrize(("colour", "depth"), [("left", "right"), ("cam0", "cam1"), ("rgb_camera_1", "d_camera_12")])
def test_colour_and_depth_of_two_cameras_are_not_matched_by_the_number_of_the_frame(colour, depth):
    names = [[f"{camera}_{number:04}.png" for number in (1, 2)] for camera in (colour, depth)]
    assert paired(*names).pairs == []
    assert len(paired(names[0], [name.replace(depth, "range") for name in names[1]]).pairs) == 2


@pytest.mark.parametrize(
    ("colour", "depth"),
    [
        ("frame-000000.color.png", "frame-000000.depth.png"),
        ("0001_rgb.png", "0001_depth.png"),
        ("img_0001.jpg", "depth_0001.npy"),
        ("0001.png", "0001_depth.tiff"),
        ("r-0001.png", "d-0001.png"),
        ("IMAGE7.PNG", "Depth7.PNG"),
        ("a_depthless_rgb_3.png", "a_depthless_depth_3.png"),
    ],
)
def test_pairs_in_one_folder(tmp_path, colour, depth):
    _touch(tmp_path, colour, depth, "0001_mask.png", "readme.txt")
    assert _named(tmp_path) == [(colour, depth)]
    assert list_frames(tmp_path).notes == ()


@pytest.mark.parametrize(
    ("colour", "depth", "units"), [("rgb.txt", "depth.txt", 5000), ("color.txt", "aligned_depth.txt", 1000)]
)
def test_lists_by_time_take_the_nearest_within_a_limit(tmp_path, colour, depth, units):
    (tmp_path / colour).write_text("# timestamp filename\n1.000 rgb/a.png\n1.033 rgb/b.png\n1.066 rgb/c.png\n\n")
    (tmp_path / depth).write_text("# depth maps\n1.004 depth/a.png\n1.030 depth/b.png\n1.200 depth/d.png\n")
    assert _named(tmp_path) == [("rgb/a.png", "depth/a.png"), ("rgb/b.png", "depth/b.png")]
    assert list_frames(tmp_path).sources[0].options.depth_units == units
    assert list_frames(tmp_path).notes[1] == "1 colour image left out: there is no depth image within 0.02 s."
    (tmp_path / depth).write_text("1.004\n")
    with pytest.raises(FormatError, match=f"{depth}, line 1"):
        list_frames(tmp_path)
    (tmp_path / depth).write_text("9.0 depth/a.png\n")
    with pytest.raises(InputError, match=r"smallest difference is 7\.934 s.*--max-gap"):
        list_frames(tmp_path)


@pytest.mark.parametrize(
    "line", ["nan a.png", "1e400 a.png", "2 .", "2 ..", "2 /", "2 rgb/..", "2 rgb/a.png", "2 ./rgb//a.png"]
)
def test_lists_by_time_name_each_file_once(tmp_path, line):
    (tmp_path / "rgb.txt").write_text(f"1.0 rgb/a.png\n{line}\n")
    (tmp_path / "depth.txt").write_text("1.0 depth/a.png\n2.0 depth/b.png\n")
    with pytest.raises(FormatError, match=r"rgb\.txt"):
        list_frames(tmp_path)
    (tmp_path / "rgb.txt").unlink()
    time, name = line.split()
    (tmp_path / "associations.txt").write_text(f"1 rgb/a.png 1 depth/a.png\n2 depth/b.png {time} {name}\n")
    with pytest.raises(FormatError, match=r"associations\.txt"):
        list_frames(tmp_path)


def test_names_that_no_file_can_have_are_refused(tmp_path):
    (tmp_path / "associations.txt").write_text(f"1 {'a' * 5000}.png 1 b.png\n2 c.png 2 d\0.png\n")
    source = open_source(tmp_path)
    for key in source.keys:
        assert source.pose(key) is None
        with pytest.raises(InputError):
            source.read(key)


@pytest.mark.parametrize("names", [[], ["a.txt"], ["a.png", "b.png"], ["sub/sub/meta.json"]])
def test_without_frames_it_says_what_a_folder_holds(tmp_path, names):
    with pytest.raises(InputError, match=r"contains no frames.*meta\.json.*rgb\.txt"):
        list_frames(_touch(tmp_path, *names))


@pytest.mark.parametrize(
    ("colours", "depths"),
    [
        (["1305031102_175304", "1305031102_208304"], ["1305031102_181304", "1305031102_214304"]),
        (["rgb_1305031102.175", "rgb_1305031102.208"], ["depth-1305031102.181", "depth-1305031102.214"]),
        (["12.033", "12.133"], ["12.037", "12.137"]),
        (["1305031102.175304_rgb", "1305031102.208304_rgb"], ["1305031102.181304_depth", "1305031102.214304_depth"]),
        (["1305031102175-color", "1305031102208-color"], ["1305031102181-depth", "1305031102214-depth"]),
        (["12.03", "12.13"], ["12.04", "12.14"]),
    ],
)
def test_files_whose_names_are_times_are_matched(tmp_path, colours, depths):
    names = [f"rgb/{name}.png" for name in colours], [f"depth/{name}.png" for name in depths]
    listing = list_frames(_touch(tmp_path, *names[0], *names[1]))
    assert _named(tmp_path) == list(zip(*names, strict=True))
    assert listing.times[1] - listing.times[0] == pytest.approx(0.1 if colours[0].startswith("12.") else 0.033)


@pytest.mark.parametrize(
    ("colours", "depths", "why"),
    [
        (["1.png"], ["2.png"], "no colour file has the name or number of a depth file: there are 1.png and 2.png"),
        (["12.033.png", "12.133.png"], ["12.083.png"], r"within 0.02 s .* smallest difference is 0.05 s.*--max-gap"),
        (
            ["12.033.png", "12.133.png"],
            ["17.033.png", "17.133.png"],
            r"4.9 s\. Allow more .* if two clocks differ",
        ),
        (
            ["1.png", "2.png"],
            ["1.png", "1.npy", "2.png", "2.npy"],
            r"the same name \(1.npy and 1.png; 2.npy and 2.png\)",
        ),
        (["1.png"], ["1.csv"], "no depth file of a supported format, only 1.csv"),
        (["1.png"], [], "no depth file of a supported format"),
    ],
)
def test_why_two_folders_have_no_frames(tmp_path, colours, depths, why):
    (tmp_path / "depth").mkdir()
    names = [f"rgb/{name}" for name in colours] + [f"depth/{name}" for name in depths]
    with pytest.raises(InputError, match=f"contains no frames: .*{why}"):
        list_frames(_touch(tmp_path, *names))


def test_what_is_no_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        list_frames(tmp_path / "gone")
    with pytest.raises(InputError, match="is a file"):
        list_frames(_touch(tmp_path, "a.png") / "a.png")


@given(st.lists(st.text("ab012-_.", max_size=6), unique=True), st.lists(st.text("ab012-_.", max_size=6), unique=True))
def test_no_file_is_in_two_pairs(colours, depths):
    found = paired([f"{name}.png" for name in colours], [f"{name}.png" for name in depths]).pairs
    assert len({rgb for rgb, _ in found}) == len({depth for _, depth in found}) == len(found)
    assert sorted(found, key=lambda pair: natural(pair[0])) == found


@pytest.mark.parametrize("size", [(161, 90), (643, 301), (1283, 721)])
def test_thumbnail_of_a_photo_is_that_of_all_its_pixels(tmp_path, size):
    photo = np.zeros((*size[::-1], 3), np.uint8)
    photo[..., 0], photo[: size[1] // 2, :, 2] = np.linspace(0, 255, size[0]), 200
    tag = Image.Exif()
    tag[274] = 6  # for viewers: turned by a quarter
    Image.fromarray(photo).save(tmp_path / "a.jpg", quality=95, exif=tag)
    small, whole = read_thumbnail(FrameRef(str(tmp_path / "a.jpg"), "unread.png")), thumbnail_of(photo)
    assert small.shape[1] == whole.shape[1]
    assert abs(small.shape[0] - whole.shape[0]) <= 1
    assert np.abs(cv2.resize(small, whole.shape[1::-1]).astype(int) - whole).mean() < 3


def test_thumbnail_is_the_colour_image_made_small(tmp_path):
    ramp = np.zeros((300, 900, 3), np.uint8)
    ramp[..., 0], ramp[:, 450:, 2] = np.linspace(0, 255, 900), 255
    cv2.imwrite(str(tmp_path / "a.png"), ramp[..., ::-1])
    small = read_thumbnail(FrameRef(str(tmp_path / "a.png"), "unread.png"))
    assert small.shape == (53, 160, 3)
    assert np.abs(small[26, :, 0].astype(int) - np.linspace(1, 254, 160)).max() < 5
    assert small[9, 140, 2] == 255
    assert small[9, 18, 2] == 0
    (tmp_path / "a.png").write_bytes((tmp_path / "a.png").read_bytes()[:400])
    with pytest.raises(FormatError):
        read_thumbnail(FrameRef(str(tmp_path / "a.png"), "unread.png"))


@pytest.mark.parametrize(
    ("name", "start"), [("a.bag.gz", b"\x1f\x8b\x08"), ("a.mcap.zst", b"\x28\xb5\x2f\xfd"), ("a.zip", b"PK\x03\x04")]
)
def test_a_recording_that_is_packed_as_a_whole_is_to_be_unpacked(tmp_path, name, start):
    (tmp_path / name).write_bytes(start)
    with pytest.raises(InputError, match=r"not a recording that is read .*Unpack it, and give the files in it"):
        open_source(tmp_path / name)
