"""A constant far value where nothing was measured, of which reading warns, is no ground truth of any evaluation."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.evaluation.bench.frames import PATTERNS, load_bench_frame, make_task
from ilf.evaluation.edit_summary import summarise_edit
from ilf.segmentation.editing.patches import patch_between

from ..small_frames import QUICK, write_small_frame

LABELS = np.where(np.arange(80) < 40, 1, 2) + np.zeros((60, 1), np.int32)


@pytest.fixture
def folder(tmp_path):
    """A frame folder whose holes have 10 m, and whose ground truth is its depth, with 10 m in a corner."""
    write_small_frame(tmp_path / "frame")
    depth = cv2.imread(str(tmp_path / "frame" / "depth.png"), cv2.IMREAD_UNCHANGED)
    truth = np.where(depth == 0, np.uint16(2000), depth)
    truth[:4, :14] = 10_000
    depth[depth == 0] = 10_000
    cv2.imwrite(str(tmp_path / "frame" / "depth.png"), depth)
    cv2.imwrite(str(tmp_path / "frame" / "gt.png"), truth)
    write_meta(tmp_path / "frame")
    return tmp_path / "frame"


def write_meta(folder: Path, **more: object) -> None:
    meta = {"name": "frame", "depth_units_per_m": 1000, "gt": "measured", "gt_units_per_m": 1000}
    (folder / "meta.json").write_text(json.dumps(meta | more))


@pytest.mark.parametrize("pattern", ["areas", "random"])
def test_hold_out_leaves_it_out_unless_it_is_said_to_be_depth(folder, pattern):
    frames = [ilf.load_frame(folder, warn=False, invalid=invalid) for invalid in (None, 0)]
    runs = [ilf.Run(frame, LABELS, ilf.preset("paper", **QUICK)) for frame in frames]
    left, counted = (ilf.evaluate_hold_out(run, ilf.HoldOutTest(pattern, (0,))) for run in runs)
    assert max(part.ground_truth.max() for part in left.parts) < 3
    assert max(part.ground_truth.max() for part in counted.parts) == 10
    np.testing.assert_array_equal(frames[0].depth, frames[1].depth, "it is still what the run completes")


def test_an_edit_is_not_judged_by_it(folder):
    wrong = np.where(np.arange(80) < 60, 1, 2) + np.zeros((60, 1), np.int32)  # moves the hole of 10 m
    patch = patch_between(wrong, LABELS)
    hidden = []
    for invalid in None, 0:
        frame = ilf.load_frame(folder, warn=False, invalid=invalid)
        runs = [ilf.Run(frame, labels, ilf.preset("paper", **QUICK)) for labels in (wrong, LABELS)]
        hidden.append(summarise_edit(*runs, patch).hidden)
    assert 0 < hidden[0] < hidden[1]


def test_evaluate_tells_what_it_leaves_out(folder, capsys):
    command = ["evaluate", str(folder), "--hold-out", "areas", "--seeds", "1", "--preset", "paper"]
    for more, is_told in ([], True), (["--invalid", "0"], False), (["--invalid", "10000"], False):
        assert main([*command, "--max-iterations", "25", *more]) == 0
        assert ("10.1% of the known depth, a constant 10.000 m" in capsys.readouterr().err) is is_told


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_bench_neither_scores_nor_shows_it(folder, pattern):
    with pytest.warns(ilf.DepthWarning) as told:
        source = load_bench_frame(folder)
    assert any("10.1% of the known depth, a constant 10.000 m" in str(one.message) for one in told)
    task = make_task(source, pattern)
    assert task.ground_truth[task.scored].max() < 3
    assert np.nanmax(task.frame.depth) < 3
    write_meta(folder, depth_invalid=0)
    assert np.nanmax(load_bench_frame(folder).frame.depth) == 10


def test_ground_truth_files_are_read_without_it(folder):
    with pytest.warns(ilf.DepthWarning) as told:
        frame = ilf.load_frame(folder)
    assert any("gt.png: a constant 10.000 m in 1.2% of the pixels" in str(one.message) for one in told)
    assert np.nanmax(frame.ground_truth) < 3
    assert any("gt.png" in note for note in frame.notes)
    as_depth = ilf.load_frame(folder, invalid=0)
    assert np.nanmax(as_depth.ground_truth) == 10
    assert as_depth.notes == ()
