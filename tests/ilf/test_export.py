"""Export: every chosen file or none, and never over the frame's own files."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.completion import compose
from ilf.confidence import expected_error
from ilf.errors import ExportError, InputError, ParameterError
from ilf.io import read_colour, read_depth_values, read_labels
from ilf.run import export as module
from ilf.run.export import ExportOptions, check_export, export
from ilf.run.record import make_run_record

from .small_frames import CAMERA, QUICK, write_small_frame

ALL = ExportOptions(depth_formats=("png", "tiff", "npy"), cloud="pcd")


@pytest.fixture
def run(tmp_path):
    """Frame, labels and completion."""
    frame = ilf.load_frame(*write_small_frame(tmp_path / "in"), intrinsics=CAMERA)
    labels = ilf.extract_blocks(frame)
    return frame, labels, ilf.complete(frame, labels, ilf.preset(**QUICK))


def record_of(run, options, edited=False):
    frame, labels, completion = run
    return make_run_record(frame, labels, ilf.BlockParameters(), edited, completion, options)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_all_chosen_files_are_written_and_hold_the_result(run, tmp_path):
    _, labels, completion = run
    out = tmp_path / "deep" / "out"
    report = export(out, *run, ALL, run_record=record_of(run, ALL))
    assert [path.name for path in report.files] == list(ALL.filenames())
    assert set(contents(out)) == set(ALL.filenames())
    assert report.warnings == ()
    np.testing.assert_array_equal(np.load(out / "depth.npy"), completion.depth)
    np.testing.assert_array_equal(read_depth_values(out / "depth.tiff"), completion.depth)
    stored = read_depth_values(out / "depth.png") / 1000
    np.testing.assert_allclose(stored, np.nan_to_num(completion.depth), atol=0.0005001)
    np.testing.assert_array_equal(read_labels(out / "blocks.png"), labels)
    rows = (out / "curves.csv").read_text().splitlines()
    assert len(rows) == 1 + sum(map(len, completion.history.values()))
    assert json.loads((out / "run.json").read_text())["program"] == "ilf-studio"


def test_only_chosen_files_are_written_and_others_left_alone(run, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    options = ExportOptions(("npy",), expected_error=False, labels=False, curves=False, cloud=None, run_record=False)
    export(tmp_path, *run, options)
    assert {path.name for path in tmp_path.iterdir()} == {"in", "notes.txt", "depth.npy"}


def test_lost_depth_is_warned_about_by_file(run, tmp_path):
    options = replace(ALL, depth_units=50_000.0, run_record=False)
    (warning,) = export(tmp_path / "out", *run, options).warnings
    assert warning.startswith("depth.png: ")
    assert "clipped" in warning


def test_dense_depth_has_no_gap_and_a_mask_of_what_is_guessed(run, tmp_path):
    frame, labels, _ = run
    partial = compose(frame, {})
    options = replace(ALL, dense=True, run_record=False)
    report = export(tmp_path, frame, labels, partial, options)
    depth, guessed = np.load(tmp_path / "depth.npy"), read_colour(tmp_path / "guessed.png")[..., 0] == 255
    assert frame.missing_share > 0
    np.testing.assert_array_equal(guessed, ~frame.known)
    assert np.isfinite(depth).all()
    np.testing.assert_array_equal(depth[frame.known], frame.depth[frame.known])
    assert np.nanmin(frame.depth) <= depth.min()
    assert depth.max() <= np.nanmax(frame.depth)
    assert f"{guessed.sum()} pixels" in report.warnings[0]


def test_dense_depth_without_a_gap_left_is_not_warned_of(run, tmp_path):
    assert np.isfinite(run[2].depth).all()
    assert export(tmp_path / "out", *run, replace(ALL, dense=True, run_record=False)).warnings == ()
    assert not read_colour(tmp_path / "out" / "guessed.png").any()


def test_expected_errors_come_in_the_formats_and_units_of_the_depth(run, tmp_path):
    frame, _, completion = run
    options = replace(ALL, depth_units=200.0, run_record=False)
    assert export(tmp_path, *run, options).warnings == ()
    expected = expected_error(frame, completion)
    np.testing.assert_array_equal(np.load(tmp_path / "expected_error.npy"), expected)
    np.testing.assert_array_equal(read_depth_values(tmp_path / "expected_error.tiff"), expected)
    stored = read_depth_values(tmp_path / "expected_error.png")
    np.testing.assert_array_equal(stored > 0, completion.filled)
    assert np.nanmin(expected) < 0.0025
    wanted = np.maximum(expected[completion.filled], 1 / 200)
    np.testing.assert_allclose(stored[completion.filled] / 200, wanted, atol=0.0025001)
    no_files = ExportOptions((), labels=False, curves=False, cloud=None).filenames()
    assert no_files == ("run.json",)


def test_edited_blocks_without_label_map_are_warned_about(run, tmp_path):
    options = replace(ALL, labels=False)
    (warning,) = export(tmp_path / "out", *run, options, run_record=record_of(run, options, edited=True)).warnings
    assert "blocks.png" in warning


def test_failing_writer_leaves_the_folder_as_it_was(run, tmp_path, monkeypatch):
    out = tmp_path / "out"
    export(out, *run, ALL, run_record=record_of(run, ALL))
    before = contents(out)

    def fails(path, *_, **__):
        raise ExportError(f"Could not write {path}: the disk is full.")

    monkeypatch.setattr(module, "write_cloud", fails)
    frame, labels, completion = run
    other = replace(completion, depth=completion.depth + 1)
    with pytest.raises(ExportError) as caught:
        export(out, frame, labels, other, ALL, run_record=record_of(run, ALL))
    assert str(caught.value) == f"Could not write {out / 'cloud.pcd'}: the disk is full."
    assert contents(out) == before
    with pytest.raises(ExportError):
        export(tmp_path / "new" / "folder", *run, replace(ALL, run_record=False))
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("failing", range(1, 18))
def test_failing_move_takes_the_earlier_ones_back(run, tmp_path, monkeypatch, failing):
    """Eight files go aside and nine go in: whichever move fails, the folder is as before."""
    frame, labels, completion = run
    out = tmp_path / "out"
    options = replace(ALL, run_record=False)
    export(out, *run, options)
    (out / "depth.tiff").unlink()
    before = contents(out)
    real_replace, real_move_in = os.replace, module._move_in
    moves = []

    def fails_once(source, target):
        moves.append(target)
        if len(moves) == failing:
            raise PermissionError(13, "in use by another program")
        real_replace(source, target)

    def move_in(*arguments):
        monkeypatch.setattr(os, "replace", fails_once)
        real_move_in(*arguments)

    monkeypatch.setattr(module, "_move_in", move_in)
    with pytest.raises(ExportError, match="in use by another program"):
        export(out, frame, labels, replace(completion, depth=completion.depth + 1), options)
    assert contents(out) == before


def test_cloud_without_intrinsics_writes_nothing(run, tmp_path):
    frame, labels, completion = run
    bare = ilf.RGBDFrame(frame.rgb, frame.depth)
    with pytest.raises(InputError, match="intrinsics"):
        export(tmp_path / "out", bare, labels, completion, ALL)
    assert not (tmp_path / "out").exists()


def test_the_frames_own_files_are_never_overwritten(run, tmp_path):
    raw = (tmp_path / "in" / "depth.png").read_bytes()
    with pytest.raises(ExportError, match="own file"):
        export(tmp_path / "in", *run, replace(ALL, run_record=False))
    assert (tmp_path / "in" / "depth.png").read_bytes() == raw


def test_what_cannot_be_written_is_refused(run, tmp_path):
    options = replace(ALL, run_record=False)
    (tmp_path / "file").write_text("")
    (tmp_path / "odd" / "depth.npy").mkdir(parents=True)
    for folder in ("file", "file/below", "odd"):
        with pytest.raises(ExportError):
            export(tmp_path / folder, *run, options)
    assert (tmp_path / "odd" / "depth.npy").is_dir()
    assert len(list((tmp_path / "odd").iterdir())) == 1
    with pytest.raises(ExportError, match="record"):
        export(tmp_path / "out", *run, ALL)
    export(tmp_path / "out", *run, options)
    with pytest.raises(ExportError, match="already"):
        check_export(tmp_path / "out", run[0], options, overwrite=False)


@pytest.mark.parametrize(
    "wrong",
    [{"depth_formats": ("jpg",)}, {"cloud": "obj"}, {"axes": "z"}, {"cloud_unit": "in"}, {"depth_units": float("nan")}],
)
def test_unknown_choices_are_refused(wrong):
    with pytest.raises(ParameterError):
        ExportOptions(**wrong)
