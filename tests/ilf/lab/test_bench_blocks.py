"""The block bench: what the depth says, every measure where its value is known, the methods, and the command."""

import csv
import dataclasses
import json
import sys

import cv2
import numpy as np
import pytest

from ilf import RGBDFrame, complete, preset
from ilf.cli import main
from ilf.data.pixel_grids import both, mark
from ilf.data.results import Status
from ilf.errors import InputError
from ilf.lab.bench.block_measures import (
    boundary_score,
    count_leaks,
    coverage,
    cut_rate,
    find_reference,
    purity,
    recoverable_share,
    score_blocks,
)
from ilf.lab.bench.blocks import BLOCK_METHODS, BlockMethod, BlockPlan, run_block_bench, summarise_blocks

from ..small_frames import write_small_frame

SHAPE = (80, 120)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
STEP = np.where(COLUMNS < 60, 1.0, 1.5)
"""Two walls, one behind the other, that meet between columns 59 and 60."""

HALVES = np.where(COLUMNS < 60, 1, 2).astype(np.int32)
WHOLE = np.ones(SHAPE, np.int32)

REACH = 10
"""Over how many pixels around there must be depth to say whether a surface goes on."""


def frame_of(depth, missing=False):
    return RGBDFrame(np.full((*depth.shape, 3), 100, np.uint8), np.where(missing, np.nan, depth), name="walls")


def evidence_of(depth, missing=False):
    return find_reference(frame_of(depth, missing))


def with_jump(rows):
    """Evidence of nothing but a jump between columns 59 and 60, in some rows."""
    found = evidence_of(np.full(SHAPE, 1.0))
    right = ((COLUMNS == 59) & rows)[:, :-1]
    return dataclasses.replace(found, jumps=(right, found.jumps[1]))


# what the depth says


def test_a_jump_stands_where_depth_steps_and_nowhere_else():
    found = evidence_of(STEP)
    np.testing.assert_array_equal(mark(found.jumps), COLUMNS == 59)
    assert not mark(evidence_of(np.where(COLUMNS < 60, 1.0, 1.03)).jumps).any()
    assert not mark(evidence_of(np.where(COLUMNS < 60, 4.0, 4.1)).jumps).any()


def test_flying_pixels_are_no_jumps_and_narrow_gaps_hide_none():
    flying = np.full(SHAPE, 1.0)
    flying[20:70:9, 15:110:11] = 3.0
    assert not mark(evidence_of(flying).jumps).any()
    for width, seen in ((6, True), (20, False)):
        gap = abs(COLUMNS - 59.5) < width / 2
        assert mark(evidence_of(STEP, gap).jumps).any() == seen


@pytest.mark.parametrize(("rows", "counted"), [(11, False), (18, True)])
def test_short_lines_of_jumps_do_not_count(rows, counted):
    """A ledge whose height fades over some rows; it is a jump until 4 cm are left."""
    height = 0.0125 * np.clip(rows - ROWS, 0, None)
    found = evidence_of(np.where(COLUMNS < 60, 1.0, 1.0 + height))
    assert mark(found.jumps)[:12, 59].all() == mark(found.jumps).any() == counted
    assert not mark(found.smooth)[:4, 58:62].any()


def wall_corner(degrees):
    """Depth of two walls that meet at column 60 at an angle, as a camera of 525 px focal length sees them."""
    lean = np.tan(np.radians(90 - degrees / 2))
    return 2.0 / (1 + lean * abs(COLUMNS - 60) / 525)


def test_smooth_is_the_inside_of_a_noisy_wall_and_not_its_corners():
    rng = np.random.default_rng(0)
    inside = np.zeros(SHAPE, bool)
    inside[REACH + 3 : -REACH - 3, REACH + 3 : -REACH - 3] = True
    noise = rng.normal(0, 0.006, SHAPE)
    slanted = 2.0 / (1 + 0.8 * (COLUMNS - 60) / 525 + 0.5 * ROWS / 525)
    assert both(inside)[0][find_reference(frame_of(slanted + noise)).smooth[0]].sum() > 0.95 * both(inside)[0].sum()
    corner = mark(evidence_of(wall_corner(90) + noise).smooth)
    assert not corner[:, 58:62].any()
    assert corner[20:60, 20:45].all()
    assert mark(evidence_of(wall_corner(170)).smooth)[20:60, 58:62].all()


def test_nothing_is_smooth_near_jumps_and_holes():
    hole = (abs(COLUMNS - 30) < 8) & (abs(ROWS - 40) < 8)
    smooth = mark(evidence_of(STEP, hole).smooth)
    assert not smooth[:, 60 - REACH : 60 + REACH].any()
    assert not smooth[hole].any()
    assert smooth[40, 85:105].all()


# the measures


def test_coverage_is_inside_the_margins_and_of_the_frame():
    colour = np.full((*SHAPE, 3), 100, np.uint8)
    colour[:4] = colour[-4:] = colour[:, :6] = colour[:, -6:] = 255
    labels = np.zeros(SHAPE, np.int32)
    labels[4:-4, 6:60] = 1
    score = score_blocks(labels, find_reference(RGBDFrame(colour, STEP)))
    assert (score.coverage, score.frame_coverage) == (0.5, pytest.approx(54 * 72 / labels.size))
    assert score.blocks == 1
    assert coverage(np.zeros((2, 2), np.int32)) == 0.0


def test_missing_pixels_are_recoverable_in_blocks_with_enough_depth():
    known = np.zeros(SHAPE, bool)
    known[:, :30] = True
    assert recoverable_share(HALVES, known) == pytest.approx(30 / 90)
    assert recoverable_share(WHOLE, known) == 1.0
    assert recoverable_share(np.where(COLUMNS < 45, 1, 0).astype(np.int32), known) == pytest.approx(15 / 90)
    assert recoverable_share(WHOLE, np.ones(SHAPE, bool)) is None


@pytest.mark.parametrize("height", [10, 60])
@pytest.mark.parametrize("change", [0, -1])
def test_enough_depth_is_what_the_completion_asks_for(height, change):
    quick = preset(max_iterations=1)
    pixels = height * SHAPE[1]
    needed = max(quick.min_known_pixels, int(np.ceil(quick.min_known_share * pixels)))
    labels = np.where(height > ROWS, 1, 0).astype(np.int32)
    known = np.zeros(SHAPE, bool)
    known.ravel()[: needed + change] = True
    known[height:] = True
    outcome = complete(frame_of(STEP, ~known), labels, quick).outcomes[1]
    assert (outcome.status is Status.NOT_RECOVERABLE) == (change < 0)
    assert recoverable_share(labels, known) == (0.0 if change < 0 else 1.0)


@pytest.mark.parametrize(
    ("labels", "leaks"),
    [
        ([[1, 1, 2], [1, 2, 2], [3, 3, 2]], 0),
        ([[1, 1, 1], [1, 2, 1], [1, 1, 1]], 0),
        ([[1, 0, 2], [0, 2, 2], [2, 2, 0]], 0),
        ([[1, 2, 2], [2, 1, 1], [2, 1, 1]], 2),
        ([[1, 0, 1], [1, 0, 1], [1, 0, 1]], 1),
        ([[1, 2, 1], [1, 2, 1], [3, 2, 3]], 2),
        ([[0, 0, 0], [0, 0, 0], [0, 0, 0]], 0),
    ],
)
def test_a_leak_is_a_block_in_pieces(labels, leaks):
    assert count_leaks(np.array(labels, np.int32)) == leaks


def test_purity_is_the_area_of_blocks_without_a_jump():
    evidence = evidence_of(STEP)
    assert purity(HALVES, evidence) == 1.0
    assert purity(WHOLE, evidence) == 0.0
    third = np.where(COLUMNS < 40, 1, 2).astype(np.int32)
    assert purity(third, evidence) == pytest.approx(1 / 3)
    unknown = evidence_of(STEP, COLUMNS < 40)
    assert purity(third, unknown) == 0.0
    assert purity(np.zeros(SHAPE, np.int32), evidence) is None


@pytest.mark.parametrize(("length", "pure"), [(10, 1.0), (11, 0.0)])
def test_short_jumps_do_not_condemn_a_block(length, pure):
    assert purity(WHOLE, with_jump(length > ROWS)) == pure
    scattered = with_jump(ROWS % 8 < 6)
    assert purity(WHOLE, scattered) == 1.0


@pytest.mark.parametrize(("length", "pure"), [(24, 1.0), (25, 0.0)])
def test_jumps_count_only_from_a_share_of_the_perimeter(length, pure):
    """A comb: 40 slots of 25 px in a block of 80 x 120 px, which itself has 400 px of outline."""
    comb = WHOLE.copy()
    comb[50:75, 10:90:2] = 0
    perimeter = 400 + 40 * 2 * (25 + 1)
    assert 24 < 0.01 * perimeter < 25
    assert purity(comb, with_jump(length > ROWS)) == pure


def test_cut_rate_counts_the_smooth_pairs_that_are_parted():
    evidence = evidence_of(STEP)
    assert cut_rate(HALVES, evidence) == 0.0
    quarters = np.where(COLUMNS < 90, HALVES, 3).astype(np.int32)
    right, below = evidence.smooth
    expected = right[:, 89].sum() / (right.sum() + below.sum())
    assert expected > 0
    assert cut_rate(quarters, evidence) == pytest.approx(expected)
    every = np.arange(HALVES.size, dtype=np.int32).reshape(SHAPE) + 1
    assert cut_rate(every, evidence) == 1.0
    assert cut_rate(HALVES, evidence_of(STEP, (ROWS + COLUMNS) % 2 == 0)) is None


def cut_at(*columns):
    return np.searchsorted(columns, COLUMNS, side="right").astype(np.int32) + 1


@pytest.mark.parametrize(
    ("labels", "recall", "precision", "f"),
    [
        (cut_at(60), 1.0, 1.0, 1.0),
        (cut_at(62), 1.0, 1.0, 1.0),
        (cut_at(58), 1.0, 1.0, 1.0),
        (cut_at(63), 0.0, 0.0, 0.0),
        (cut_at(60, 90), 1.0, 0.5, 2 / 3),
        (np.where(ROWS < 40, HALVES, 1).astype(np.int32), 42 / 80, 42 / 100, 7 / 15),
        (WHOLE, 0.0, None, 0.0),
    ],
)
def test_boundaries_are_held_against_jumps_with_two_pixels_to_spare(labels, recall, precision, f):
    score = boundary_score(labels, evidence_of(STEP))
    assert score.recall == pytest.approx(recall)
    assert score.precision == (None if precision is None else pytest.approx(precision))
    assert score.f == pytest.approx(f)


def test_boundaries_in_holes_are_not_judged_and_frames_without_jumps_say_nothing():
    hole = (COLUMNS > 80) & (COLUMNS < 110)
    score = boundary_score(cut_at(60, 95), evidence_of(STEP, hole))
    assert (score.recall, score.precision) == (1.0, 1.0)
    assert boundary_score(cut_at(60, 85), evidence_of(STEP)).precision == 0.5
    flat = boundary_score(HALVES, evidence_of(np.full(SHAPE, 2.0)))
    assert (flat.recall, flat.precision, flat.f) == (None, None, None)


# the methods and their runs


@pytest.fixture
def folders(tmp_path):
    """Two frame folders, the second of one colour, and one that cannot be read."""
    for name in ("colours", "grey", "broken"):
        folder = tmp_path / "frames" / name
        write_small_frame(folder)
        (folder / "meta.json").write_text(json.dumps({"name": name, "depth_units_per_m": 1000}))
    cv2.imwrite(str(tmp_path / "frames" / "grey" / "rgb.png"), np.full((60, 80, 3), 90, np.uint8))
    (tmp_path / "frames" / "broken" / "depth.png").write_bytes(b"no image")
    return tmp_path / "frames"


def test_only_depth_finds_a_jump_without_colour(folders):
    result = run_block_bench(BlockPlan((folders / "grey",), tuple(BLOCK_METHODS)))
    recall = {row.method: row.recall for row in result.rows}
    assert min(recall.pop("canny+depth"), recall.pop("combined")) > 0.9
    assert set(recall.values()) == {0.0}
    assert all(row.seconds > 0 and not row.failure for row in result.rows)


@pytest.mark.parametrize("name", BLOCK_METHODS)
def test_methods_part_colours_and_leave_the_margins_out(name):
    colour = np.where(COLUMNS[..., None] < 60, (40, 90, 200), (220, 200, 60)).astype(np.uint8)
    colour[:4] = colour[-4:] = colour[:, :6] = colour[:, -6:] = 255
    frame = RGBDFrame(colour, STEP)
    labels = BLOCK_METHODS[name].run(frame)
    assert labels.dtype == np.int32
    inside = np.zeros(SHAPE, bool)
    inside[4:-4, 6:-6] = True
    np.testing.assert_array_equal(labels > 0, inside)
    score = score_blocks(labels, find_reference(frame))
    assert score.recall == 1.0
    if name != "network":  # its boundaries are true to a pixel, not to the line between two
        assert score.purity == 1.0


def test_summary_is_the_mean_over_frames_that_have_a_value_and_failures_count(folders, monkeypatch):
    def halves(frame):
        if frame.name == "grey":
            raise InputError("too grey")
        return np.where(np.mgrid[:60, :80][1] < 40, 1, 2).astype(np.int32)

    monkeypatch.setitem(BLOCK_METHODS, "halves", BlockMethod(halves, {}))
    result = run_block_bench(BlockPlan((folders / "colours", folders / "grey"), ("halves", "canny+depth")))
    best, line = summarise_blocks(result)
    assert (best.method, line.method) == ("canny+depth", "halves")
    assert (line.frames, line.failures, line.coverage, line.watertight, line.blocks) == (2, 1, 0.5, 1.0, 1.0)
    assert (line.purity, line.recall, line.f) == (1.0, 0.5, 0.5)
    assert best.f > line.f


# the command


def test_command_end_to_end(folders, tmp_path, capsys):
    contents = []
    for jobs in ("1", "2"):
        files = ["--csv", str(tmp_path / "a.csv"), "--json", str(tmp_path / f"{jobs}.json")]
        assert main(["bench", "blocks", str(folders), "--jobs", jobs, "--progress", *files]) == 0
        contents.append(json.loads((tmp_path / f"{jobs}.json").read_text()))
    captured = capsys.readouterr()
    assert "3/3 frames" in captured.err
    assert captured.err.splitlines()[-1].startswith("ilf: warning: skipped: broken. ")
    lines = captured.out.splitlines()[: 2 + len(BLOCK_METHODS)]
    assert lines[0] == "blocks: quality of operation blocks, without hold-out (2 frames)"
    assert lines[2].split()[0] == "canny+depth"
    assert {line.split()[0] for line in lines[2:]} == set(BLOCK_METHODS)

    first, second = (
        [{key: value for key, value in row.items() if key != "seconds"} for row in content["rows"]]
        for content in contents
    )
    assert first == second
    assert len(first) == 2 * len(BLOCK_METHODS)
    assert contents[0]["methods"]["canny"]["use_depth"] is False
    with open(tmp_path / "a.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["method"] for row in rows] == [row["method"] for row in contents[1]["table"]]
    assert float(rows[0]["f"]) == contents[1]["table"][0]["f"]


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        ([], 2, "Give folders of frames after 'blocks'"),
        (["frames", "--pattern", "areas"], 2, "leave out --pattern, --seed and --peers-from"),
        (["frames", "--methods", "watershed"], 1, "There is no method 'watershed'. Known: all, canny, network"),
        (["frames/broken"], 1, "No frame could be read"),
        (["missing"], 1, "missing is not a folder"),
    ],
)
def test_what_cannot_be_done_is_one_line(folders, monkeypatch, capsys, arguments, status, message):
    monkeypatch.chdir(folders.parent)
    assert main(["bench", "blocks", *arguments]) == status
    assert message in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize("arguments", [["blocks", "frames"], ["denoise"]])
def test_a_missing_package_of_public_methods_is_named_before_the_work(folders, monkeypatch, capsys, arguments):
    monkeypatch.chdir(folders.parent)
    monkeypatch.setitem(sys.modules, "skimage", None)
    assert main(["bench", *arguments]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.endswith('which is not installed. Install it: pip install "ilf-studio[plot]".\n')
