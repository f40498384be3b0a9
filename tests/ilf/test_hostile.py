"""Damaged files, absurd numbers and files in the way: one line, and everything as it was."""

import ast
import errno
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ilf
from gui.features.frame_list.thumbnails import read_thumbnail, stored_thumbnail
from ilf.errors import FormatError, InputError, one_line
from ilf.io.block_files import read_blocks
from ilf.io.cameras import intrinsics_from
from ilf.run.options import ExportOptions
from ilf.run.writing import write
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import list_frames
from ilf.sources.pairing import TimedPairs

from ..bench.fuzz.formats import FORMATS
from ..bench.fuzz.worker import case, outcome
from .small_frames import CAMERA, QUICK, write_small_frame
from .small_runs import contents

IN_PROCESS = [
    "meta-json", "intrinsics-json", "intrinsics-yaml", "preset", "blocks-coco", "blocks-coco-rle", "blocks-labelme",
    "depth-png", "depth-tiff", "depth-pgm", "depth-npy", "depth-pfm", "colour-png", "colour-ppm-tiff", "colour-jpeg",
    "guide-npz", "time-list", "associations", "bop", "ros1-bag", "record3d",
    "sun-camera", "trajectory", "pose", "scannet-sens", "arkit-camera", "guide-npy", "guide-pfm", "confidence-npy",
    "file-names", "autosave", "project",
]  # fmt: skip
"""Formats whose readers cannot crash the interpreter; `python -m tests.bench.fuzz` has all, thousands of each."""


@pytest.mark.parametrize("name", IN_PROCESS)
def test_damaged_files_are_told_of_in_one_line(name, tmp_path):
    form = FORMATS[name]
    path = tmp_path / form.file
    seeds = form.seeds(tmp_path) or [path.read_bytes()]
    path.parent.mkdir(exist_ok=True)
    for number in range(8):
        path.write_bytes(case(form, seeds, 1, number))
        found = outcome(form, path)
        assert found[0] in {"ok", "told"}, f"case {number}: {found}"


def test_an_error_is_one_line_that_a_terminal_does_not_obey():
    told = str(InputError("a\nb \x1b[31mred\x07 é \udcff" + "x" * 5000))
    assert told.startswith("a b \\x1b[31mred\\x07 é \\udcff")
    assert len(told) < 2000
    assert one_line("as it was: 2  blanks") == "as it was: 2  blanks"


LONG = "x" * 5000


@pytest.mark.parametrize(
    "read",
    [
        lambda: ilf.load_frame(LONG),
        lambda: ilf.load_frame(f"{LONG}.png", f"{LONG}.png"),
        lambda: list_frames(LONG),
        lambda: read_blocks(LONG, (60, 80)),
        lambda: ilf.open_source(LONG),
        lambda: ilf.replay(LONG),
        lambda: intrinsics_from(LONG),
    ],
)
def test_names_that_no_file_can_have_are_errors_of_ours(read):
    with pytest.raises(ilf.IlfError):
        read()


@pytest.mark.parametrize(
    "meta",
    [
        {"K": [10**400] * 4},
        {"K": [1e-300, 1e-300, 1, 1]},
        {"depth_units_per_m": 10**400},
        {"depth_invalid": 10**400},
        {"size": [10**400, 1]},
        {"name": "two\nlines"},
        {"name": "\x1b[31mred"},
        {"rgb": "x" * 5000},
        {"run": "\0"},
        {"pose": [[10**400] * 4] * 4},
        {"pose": [[1e300, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},
    ],
)
def test_absurd_values_of_a_frame_folder_are_refused(meta, tmp_path):
    write_small_frame(tmp_path)
    (tmp_path / "meta.json").write_text(json.dumps({"depth_units_per_m": 1000} | meta))
    with pytest.raises(InputError, match=r"meta\.json|interrupted"):
        ilf.load_frame(tmp_path)


@pytest.mark.parametrize("value", [np.finfo(np.float32).max, 1e30, 1e-38])
def test_depth_that_cannot_be_is_refused(value):
    depth = np.full((40, 50), 2.0, np.float32)
    depth[:4, :4] = value
    with pytest.raises(InputError, match="m is impossible"):
        ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), depth)
    with pytest.raises(InputError, match="ground truth"):
        ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0), ground_truth=depth)


TIMES = st.lists(st.integers(0, 12).map(lambda time: time / 4), max_size=7)


@given(colours=TIMES, depths=TIMES, gap=st.sampled_from([0.0, 0.25, 1.0, np.inf]))
def test_the_nearest_in_time_belong_together_at_any_gap(colours, depths, gap):
    one = sorted((time, f"c{number}") for number, time in enumerate(colours))
    other = sorted((time, f"d{number}") for number, time in enumerate(depths))
    found, used = {}, set()
    all_pairs = ((abs(a - b), i, k) for i, (a, _) in enumerate(one) for k, (b, _) in enumerate(other))
    for apart, i, k in sorted(all_pairs):
        if apart <= gap and i not in found and k not in used:
            found[i] = k
            used.add(k)
    timed = ({name: (time, name) for time, name in images} for images in (one, other))
    assert [*TimedPairs(*timed).paired(gap).values()] == [(one[i][1], other[k][1]) for i, k in sorted(found.items())]


def test_many_images_of_two_clocks_are_paired_without_looking_at_each_with_each():
    count = 60_000
    colours = {f"c{number}": (float(number), number) for number in range(count)}
    for offset in (0.5, 2.0 * count):
        depths = {f"d{number}": (time + offset, number) for time, number in colours.values()}
        assert len(TimedPairs(colours, depths).paired(np.inf)) == count


def test_a_thumbnail_takes_no_more_memory_than_the_image(tmp_path):
    content = bytearray(cv2.imencode(".png", np.zeros((20, 30, 3), np.uint8))[1].tobytes())
    at = content.index(b"IDAT") - 4
    content[at : at + 3] = b"\xff\xff\xff"
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(FormatError, match="checksum"):
        read_thumbnail(FrameRef(str(tmp_path / "a.png"), "unread.png"))
    with pytest.raises(FormatError, match="checksum"):
        stored_thumbnail(bytes(content))
    cv2.imwrite(str(tmp_path / "tower.png"), np.zeros((50_000, 1), np.uint8))
    assert read_thumbnail(FrameRef(str(tmp_path / "tower.png"), "unread.png")).nbytes < 2**22


def given_files(folder):
    """A frame, and files that a run can be made from, in the places where a run writes its own."""
    write_small_frame(folder / "in")
    out = folder / "out"
    out.mkdir()
    labels = np.zeros((60, 80), np.uint16)
    labels[:, :40], labels[:, 40:] = 1, 2
    mask = np.zeros((60, 80), np.uint8)
    mask[44:50, 4:10] = 255
    for name, image in (("labels.png", labels), ("drawn.png", mask), ("invalid_mask.png", mask)):
        cv2.imwrite(str(out / name), image)
    (out / "meta.json").write_text(json.dumps({"program": "ILF Studio", "K": [80, 80, 39.5, 29.5]}))
    files = {"--blocks": "labels.png", "--drawn": "drawn.png", "--invalid-mask": "invalid_mask.png"}
    return {flag: str(out / name) for flag, name in (files | {"--intrinsics": "meta.json"}).items()}


@pytest.mark.parametrize("flag", ["--blocks", "--drawn", "--invalid-mask", "--intrinsics"])
def test_what_a_run_is_made_from_is_not_overwritten_by_it(flag, tmp_path, cli):
    given = given_files(tmp_path)
    before = contents(tmp_path / "out")
    words = ["complete", str(tmp_path / "in/rgb.png"), str(tmp_path / "in/depth.png"), "--out", str(tmp_path / "out")]
    assert "would be overwritten" in cli(*words, "--max-iterations", "3", "--quiet", flag, given[flag], status=1).err
    assert contents(tmp_path / "out") == before


def test_the_sample_is_written_as_a_whole_or_not_at_all(tmp_path, monkeypatch, cli):
    write_bytes, written = Path.write_bytes, []

    def until_full(path, content):
        written.append(path)
        if len(written) == 3:
            write_bytes(path, content[:10])
            raise OSError(errno.ENOSPC, "No space left on device")
        return write_bytes(path, content)

    monkeypatch.setattr(Path, "write_bytes", until_full)
    assert "the disk is full" in cli("sample", tmp_path / "new" / "room", status=1).err
    assert not (tmp_path / "new").exists()


def test_a_checkpoint_of_training_is_read_as_numbers_and_not_as_a_program():
    calls = [
        node
        for path in (Path(__file__).parents[2] / "assets" / "models").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "torch.load"
    ]
    assert calls
    for call in calls:
        assert {word.arg: ast.unparse(word.value) for word in call.keywords}.get("weights_only") == "True"


def test_sources_that_are_deleted_while_open_do_not_keep_results_from_being_written(tmp_path):
    rgb, depth = write_small_frame(tmp_path / "in")
    np.save(tmp_path / "in/truth.npy", np.full((60, 80), 2.0, np.float32))
    frame = ilf.load_frame(rgb, depth, intrinsics=CAMERA, ground_truth=tmp_path / "in/truth.npy")
    for path in (tmp_path / "in").iterdir():
        path.unlink()
    (tmp_path / "in").rmdir()
    run = ilf.Run.of(frame, preset=ilf.preset(**QUICK))
    written = write(tmp_path / "out", run.complete(), ExportOptions(cloud="ply", mesh="ply"))
    assert all(path.is_file() for path in written.files)
    assert "run.json" in {path.name for path in written.files}
