"""Replay: the same bytes where all is as it was; and where it is not, a word on what differs and what that means."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf._runtime.installation import asset_path
from ilf.errors import InputError
from ilf.io.block_files import write_blocks
from ilf.io.depth import read_depth_values
from ilf.io.frame_additions import with_ground_truth_file
from ilf.io.images import encode_mask
from ilf.run.options import ExportOptions
from ilf.run.record import array_sha256, read_record
from ilf.run.replaying import Replay, depth_difference_text, file_problems
from ilf.run.writing import write
from ilf.segmentation.extraction import found_blocks

from ..small_frames import QUICK
from ..small_runs import (
    OPTIONS,
    changed,
    contents,
    drawn,
    small_run,
    with_depth_by_hand,
    with_drawn_border,
    with_invalid_mask,
    written,
)


def replayed(path: Path, out: Path, *files: Path) -> Replay:
    """Replay a record and write what comes out."""
    again = ilf.replay(path, *files)
    write(out, again.run.complete(), again.options)
    return again


RUNS = {
    "plain": lambda run: run,
    "edited": drawn,
    "invalid mask": with_invalid_mask,
    "drawn border": with_drawn_border,
    "depth by hand": with_depth_by_hand,
    "some blocks": lambda run: replace(run, only=frozenset({2})),
    "extrapolate": lambda run: replace(run, extrapolate=True, only=frozenset({2})),
    "own parameters": lambda run: run.with_parameters(run.parameters, {2: ilf.preset(**QUICK, mode="fill+denoise")}),
    "released code": lambda run: replace(run, parameters=ilf.preset("released-code", **QUICK)),
    "given": lambda run: replace(run, blocks=replace(run.blocks, extraction=None)),
}


@pytest.mark.parametrize("how", RUNS)
def test_replay_gives_the_same_bytes(tmp_path, how):
    path = written(RUNS[how](small_run(tmp_path)), tmp_path / "out")
    again = replayed(path, tmp_path / "again")
    assert again.differences == ()
    assert again.verdict(again.run.complete()) == ()
    assert contents(tmp_path / "again") == contents(tmp_path / "out")
    write(tmp_path / "restored", again.completion, again.options)
    assert contents(tmp_path / "restored") == contents(tmp_path / "out")


@pytest.mark.parametrize("name", ["depth.npy", "extrapolated.png"])
def test_a_recorded_completion_needs_all_that_it_consists_of(tmp_path, name):
    path = written(replace(small_run(tmp_path), extrapolate=True, only=frozenset({2})), tmp_path / "out")
    (tmp_path / "out" / name).write_bytes(b"")
    assert ilf.replay(path).completion is None


def test_a_recorded_completion_without_curves_has_no_history(tmp_path):
    path = written(small_run(tmp_path), tmp_path / "out")
    (tmp_path / "out" / "curves.csv").unlink()
    completion = ilf.replay(path).completion
    assert array_sha256(completion.depth) == read_record(path).depth_sha256
    assert not any(completion.history.values())


def test_depth_in_whole_millimetres_is_not_the_recorded_completion(tmp_path):
    path = written(small_run(tmp_path), tmp_path / "out", replace(OPTIONS, depth_formats=("png",)))
    assert ilf.replay(path).completion is None


def test_inputs_replaced_between_reading_and_writing_do_not_pass(tmp_path):
    """The record vouches for what was read: what lies there by the time of the export is another file."""
    run = small_run(tmp_path)
    depth = tmp_path / "in" / "depth.png"
    values = read_depth_values(depth)
    ilf.write_depth(depth, values / 1000 + 0.2)
    with pytest.raises(InputError, match="its content has changed"):
        ilf.replay(written(run, tmp_path / "out"))


def test_replay_finds_moved_inputs_when_told_or_beside_the_record(tmp_path):
    run, names = small_run(tmp_path), ("rgb.png", "depth.png", "truth.npy")
    ilf.write_depth(tmp_path / "in" / "truth.npy", np.full(run.frame.shape, 1.5))
    frame = with_ground_truth_file(run.frame, tmp_path / "in" / "truth.npy")
    path = written(replace(run, frame=frame), tmp_path / "out")
    *moved, _ = [(tmp_path / "in" / name).rename(tmp_path / name) for name in names]
    with pytest.raises(InputError, match=r"rgb\.png: there is no such file"):
        ilf.replay(path)
    replayed(path, tmp_path / "again", *moved)
    assert contents(tmp_path / "again") == contents(tmp_path / "out")
    with pytest.raises(InputError, match="not the colour file"):
        ilf.replay(path, *moved[::-1])

    record = tmp_path / "run.json"
    record.write_bytes(path.read_bytes())
    replayed(record, tmp_path / "beside")
    assert contents(tmp_path / "beside") == contents(tmp_path / "out")


def test_an_output_of_the_inputs_name_is_not_taken_for_it(tmp_path):
    path = written(small_run(tmp_path), tmp_path / "out")
    (tmp_path / "in" / "depth.png").unlink()
    assert (tmp_path / "out" / "depth.png").is_file()
    with pytest.raises(InputError, match=r"in.depth\.png: there is no such file"):
        ilf.replay(path)


def test_replay_of_edited_blocks_needs_their_label_map(tmp_path):
    run = drawn(small_run(tmp_path))
    path = written(run, tmp_path / "out")
    labels = tmp_path / "out" / "blocks.png"
    others = run.blocks.labels.copy()
    others[0, 0] = 9
    write_blocks(labels, others)
    with pytest.raises(InputError, match="edited by hand"):
        ilf.replay(path)
    labels.unlink()
    with pytest.raises(InputError, match=r"blocks\.png"):
        ilf.replay(path)


@pytest.mark.parametrize(
    ("how", "file", "what"),
    [
        (with_invalid_mask, "invalid_mask.png", "the mask of invalid depth"),
        (with_drawn_border, "drawn.png", "the mask of drawn borders"),
        (with_depth_by_hand, "depth_by_hand.npy", "depth by hand"),
    ],
)
def test_replay_needs_the_masks_and_the_depth_by_hand_of_the_run(tmp_path, how, file, what):
    path = written(how(small_run(tmp_path)), tmp_path / "out")
    given = tmp_path / "out" / file
    if given.suffix == ".npy":
        np.save(given, np.load(given) + 0.01)
    else:
        given.write_bytes(encode_mask(np.ones((60, 80), bool)))
    with pytest.raises(InputError, match=f"not {what} of the recorded run"):
        ilf.replay(path)
    given.unlink()
    with pytest.raises(InputError, match=rf"\({file}\) is not beside the record"):
        ilf.replay(path)


def test_replay_where_the_extraction_has_changed(tmp_path, monkeypatch):
    """Another version of a library may find other blocks: the written ones are used, and the user is told."""
    run = small_run(tmp_path)
    path = changed(written(run, tmp_path / "out"), "versions", "scipy", "0.1")

    def one_block(frame, parameters):
        return replace(found_blocks(frame, parameters), labels=np.ones(frame.shape, np.int32))

    monkeypatch.setattr("ilf.run.replaying.found_blocks", one_block)
    again = replayed(path, tmp_path / "again")
    assert array_sha256(again.run.blocks.labels) == array_sha256(run.blocks.labels)
    (note,) = again.run.blocks.notes
    assert "scipy 0.1 (here" in note
    (difference,) = again.differences
    assert "The run was made with scipy 0.1 (here" in difference
    (tmp_path / "out" / "blocks.png").unlink()
    with pytest.raises(InputError, match=r"scipy 0\.1.*put the run's blocks\.png beside the record"):
        ilf.replay(path)
    with pytest.raises(InputError, match=r"put the run's blocks\.png beside the record"):
        ilf.replay(written(run, tmp_path / "no-labels", replace(OPTIONS, labels=False)))


def test_frames_that_came_from_no_file_have_a_record_but_no_replay(tmp_path):
    run = small_run(tmp_path)
    frame = ilf.RGBDFrame(run.frame.rgb, run.frame.depth)
    path = written(replace(run, frame=frame), tmp_path / "bare", replace(OPTIONS, cloud=None))
    assert json.loads(path.read_text())["inputs"] is None
    assert not (tmp_path / "bare" / "meta.json").exists()
    with pytest.raises(InputError, match="not read from files"):
        ilf.replay(path)


def test_a_network_that_is_as_it_was_hides_no_other(tmp_path):
    path = written(ilf.Run.of(small_run(tmp_path).frame, preset=ilf.preset(**QUICK)), tmp_path / "out")
    record = json.loads(path.read_text(encoding="utf-8"))
    record["networks"]["filter"]["gone"] = "00"
    path.write_text(json.dumps(record), encoding="utf-8")
    (said,) = ilf.replay(path).differences
    assert "'gone' used by the filter is not available" in said


def test_a_network_that_was_replaced_is_said(tmp_path, monkeypatch):
    """The same name, another file: the depth beside edges is another, and nobody may think it were the same run."""
    monkeypatch.setenv("ILF_MODELS", str(tmp_path / "models"))
    own = tmp_path / "models" / "mine.onnx"
    own.parent.mkdir()
    own.write_bytes(asset_path("models/edges.onnx").read_bytes())
    frame = small_run(tmp_path).frame
    run = ilf.Run.of(frame, preset=ilf.preset(**QUICK, model="mine"), extraction=ilf.BlockParameters(model="mine"))
    path = written(run, tmp_path / "out")
    assert ilf.replay(path).differences == ()
    own.write_bytes(own.read_bytes() + b"\x82\x01\x00")  # an empty field that no reader minds
    blocks, filtering = ilf.replay(path).differences
    assert "'mine' used by the extraction has changed" in blocks
    assert "'mine' used by the filter has changed" in filtering
    own.unlink()
    again = ilf.replay(path)
    assert len(again.differences) == 2
    assert all("is not available" in difference for difference in again.differences)


def test_another_processor_and_other_versions_are_said(tmp_path):
    path = changed(written(small_run(tmp_path), tmp_path / "out"), "processor", "z80")
    changed(path, "version", "0.1")
    (difference,) = ilf.replay(path).differences
    assert "ilf 0.1 (here" in difference
    assert "processor z80 (here" in difference


def test_files_that_are_gone_or_changed_are_said(tmp_path):
    path = written(small_run(tmp_path), tmp_path / "out")
    (tmp_path / "out" / "curves.csv").unlink()
    (tmp_path / "out" / "depth.png").write_bytes(b"")
    gone, differing = file_problems(read_record(path), path.parent)
    assert gone == "The set of files is incomplete: missing curves.csv."
    assert differing.startswith("depth.png has changed since the run was written")
    assert ilf.replay(path).differences == (gone, differing)


def test_the_verdict_says_how_far_the_depth_is_off(tmp_path):
    path = written(small_run(tmp_path), tmp_path / "out")
    again = ilf.replay(path)
    completion = again.run.complete()
    depth = completion.depth.copy()
    depth[0, :7] += np.float32(4e-6)
    (rounding,) = again.verdict(replace(completion, depth=depth))
    assert "by up to 4." in rounding
    assert "e-06 m, at 7 pixels: within rounding" in rounding
    depth[0, 0] += np.float32(0.25)
    (real,) = again.verdict(replace(completion, depth=depth))
    assert "by up to 2.5e-01 m, at 7 pixels." in real
    depth[0, 1:4] = np.nan
    (missing,) = again.verdict(replace(completion, depth=depth))
    assert "at 4 pixels; in addition, 3 pixels missing in only one of them." in missing
    recorded = completion.depth
    assert depth_difference_text(depth, recorded) == depth_difference_text(recorded, depth)


def test_the_verdict_says_where_it_cannot_tell_how_far(tmp_path):
    options = ExportOptions(("png",), cloud=None)
    again = ilf.replay(written(small_run(tmp_path), tmp_path / "out", options))
    completion = again.run.complete()
    (verdict,) = again.verdict(replace(completion, depth=completion.depth + 1))
    assert "not bit for bit the recorded one" in verdict
    assert "The difference cannot be computed" in verdict


def test_a_record_whose_blocks_are_not_in_its_label_map_is_refused(tmp_path):
    path = changed(written(small_run(tmp_path), tmp_path / "out"), "blocks_outcome", 0, "label", 77)
    with pytest.raises(InputError, match=r"\[77\]"):
        ilf.replay(path)
