"""A frame's truth: found or given, refused when it cannot be one, recorded, and never looked at by what makes depth."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf.data.frame import InputFile
from ilf.errors import ExportError, InputError, ParameterError
from ilf.evaluation.bench.frames import load_bench_frame
from ilf.io.frame_additions import read_ground_truth, with_ground_truth_file
from ilf.run.options import ExportOptions

from ..small_frames import write_small_frame
from ..small_runs import small_run, written

META = {"depth_units_per_m": 1000, "gt_units_per_m": 5000, "K": [80, 80, 39.5, 29.5]}


def ground_truth_in_metres():
    """Of the small frame, known everywhere but in its first row."""
    rows, columns = np.mgrid[:60, :80]
    ground_truth = np.where(columns < 40, 1.5 + 0.004 * rows, 2.6 + 0.003 * columns)
    ground_truth[0] = np.nan
    return ground_truth.astype(np.float32)


@pytest.fixture
def folder(tmp_path):
    """The small frame as a folder, with its truth in 0.2 mm."""
    write_small_frame(tmp_path)
    values = np.nan_to_num(np.rint(ground_truth_in_metres() * 5000)).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "gt.png"), values)
    (tmp_path / "meta.json").write_text(json.dumps(META))
    return tmp_path


def meta(folder, **changes):
    """The folder with other values in its meta.json."""
    (folder / "meta.json").write_text(json.dumps(META | changes))
    return folder


def test_a_folders_truth_is_read_by_itself(folder):
    frame = ilf.load_frame(folder)
    np.testing.assert_allclose(frame.ground_truth, ground_truth_in_metres(), atol=1.1e-4)
    assert frame.inputs.ground_truth.path == str(folder / "gt.png")
    assert frame.sources["ground_truth_units"] == 5000
    again = ilf.load_frame(**frame.sources)
    np.testing.assert_array_equal(again.ground_truth, frame.ground_truth)
    assert again.inputs == frame.inputs
    source = load_bench_frame(folder)
    assert source.frame.ground_truth is None, "no method of the bench has it"
    np.testing.assert_array_equal(source.ground_truth, frame.ground_truth)


def test_meta_may_name_the_truth_and_float_files_hold_metres(folder):
    (folder / "gt.png").unlink()
    np.save(folder / "laser.npy", ground_truth_in_metres())
    frame = ilf.load_frame(meta(folder, gt="laser.npy", gt_units_per_m=None))
    np.testing.assert_array_equal(frame.ground_truth, ground_truth_in_metres())
    with pytest.raises(InputError, match=r"lists lidar\.npy, which is missing"):
        ilf.load_frame(meta(folder, gt="lidar.npy"))


@pytest.mark.parametrize(
    ("words", "counts"),
    [("exact", True), ("measured by laser, see gt.png", True), ("exact filled", False), ("NOT measured", False)],
)
def test_words_in_meta_say_what_gt_is_worth(folder, words, counts):
    assert (ilf.load_frame(meta(folder, gt=words)).ground_truth is not None) == counts


def test_a_given_truth_takes_the_units_of_whole_numbers_from_the_depth(folder):
    values = np.nan_to_num(np.rint(ground_truth_in_metres() * 1000)).astype(np.uint16)
    cv2.imwrite(str(folder / "other.png"), values)
    files = folder / "rgb.png", folder / "depth.png"
    assert ilf.load_frame(*files, beside=False).ground_truth is None, "two files are just these"
    given = ilf.load_frame(*files, ground_truth=folder / "other.png")
    np.testing.assert_allclose(given.ground_truth, ground_truth_in_metres(), atol=6e-4)
    assert given.inputs.ground_truth.units == 1000
    assert isinstance(given.inputs.ground_truth, InputFile)
    with pytest.raises(ParameterError, match="without ground truth: give its file"):
        ilf.load_frame(*files, ground_truth_units=1000, beside=False)


def test_what_cannot_be_the_truth_is_refused_with_a_way_out(folder):
    frame = ilf.load_frame(folder / "rgb.png", folder / "depth.png")
    with pytest.raises(InputError, match=r"gt\.png: With 1000 units.* 5 times the measured depth: give 5000"):
        with_ground_truth_file(frame, folder / "gt.png", 1000)
    with pytest.raises(InputError, match=r"cannot be ground truth: The median depth would be"):
        read_ground_truth(folder / "gt.png", frame.shape, 1)
    cv2.imwrite(str(folder / "small.png"), np.full((30, 40), 2000, np.uint16))
    with pytest.raises(InputError, match=r"small\.png is 40 x 30, but the frame is 80 x 60"):
        read_ground_truth(folder / "small.png", frame.shape)
    with pytest.raises(ParameterError, match=r"gt\.png: Depth units must be positive"):
        read_ground_truth(folder / "gt.png", frame.shape, 0)
    with pytest.raises(InputError, match="no such file"):
        read_ground_truth(folder / "none.png", frame.shape)


def with_ground_truth(run, folder):
    """The run, of a frame that has a truth in a file."""
    np.save(folder / "gt.npy", ground_truth_in_metres())
    return replace(run, frame=with_ground_truth_file(run.frame, folder / "gt.npy"))


def test_a_truth_that_is_gone_does_not_keep_a_run_from_its_replay(tmp_path):
    run = with_ground_truth(small_run(tmp_path), tmp_path)
    path = written(run, tmp_path / "out")
    (tmp_path / "gt.npy").unlink()
    again = ilf.replay(path)
    assert again.run.frame.ground_truth is None
    assert again.run.frame.inputs.ground_truth is None
    assert "not evaluated against ground truth" in again.differences[0]
    assert again.verdict(again.run.complete()) == ()


def test_no_export_overwrites_the_truth(tmp_path):
    run = small_run(tmp_path)
    (tmp_path / "out").mkdir()
    np.save(tmp_path / "out" / "depth.npy", ground_truth_in_metres())
    run = replace(run, frame=with_ground_truth_file(run.frame, tmp_path / "out" / "depth.npy"))
    with pytest.raises(ExportError, match="the frame's own file"):
        written(run, tmp_path / "out", ExportOptions(cloud=None))
