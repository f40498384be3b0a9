"""The program's own results are no measured frames: they are left out, named, and not scored."""

import json
import shutil

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.sources.frame_folder import write_frame

from .batch_frames import work_in_this_process

QUICK = ("--max-iterations", "5", "--quiet")


@pytest.fixture(autouse=True)
def no_other_processes(monkeypatch):
    work_in_this_process(monkeypatch)


@pytest.fixture
def measured(small_frame, tmp_path, monkeypatch):
    """A folder with two measured frames and the results of one of them."""
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        write_frame(f"frames/{name}", small_frame)
    assert main(["complete", "frames/one", "--out", "frames/one-done", *QUICK]) == 0
    return "frames"


def test_results_beside_frames_are_left_out_and_named(measured):
    source = ilf.open_source(measured)
    assert source.keys == ("one", "two")
    assert any("one-done" in note for note in source.notes)


@pytest.mark.parametrize("results", ["frames/one-done", "done", "shards"])
def test_a_batch_of_results_alone_is_refused(results, measured, capsys, cli):
    if results == "done":
        assert main(["batch", measured, "--out", results, *QUICK]) == 0
    elif results == "shards":
        assert main(["batch", measured, "--shards", results, *QUICK]) == 0
    capsys.readouterr()
    assert "results of ILF Studio" in cli("batch", results, "--out", "again", *QUICK, status=1).err


def test_completed_depth_is_doubted_and_not_scored_as_known(measured, cli):
    main(["batch", measured, "--shards", "shards", *QUICK])
    colour, depth = "frames/one/rgb.png", "frames/one-done/depth.png"
    for given in (["frames/one-done"], [colour, depth], ["shards", "--frame", "one"]):
        assert "completed by ILF Studio" in cli("evaluate", *given, status=1).err
        assert "completed by ILF Studio" in cli("info", *given).out
    assert json.loads(cli("info", "--json", "frames/one-done").out)["frame"]["result"] == "run.json"
    frame = ilf.load_frame("frames/one-done", warn=False)
    assert any("completed by ILF Studio" in note for note in frame.notes)
    with pytest.raises(ilf.IlfError, match="completed by ILF Studio"):
        ilf.evaluate_hold_out(ilf.Run.of(frame))


def test_measured_depth_beside_a_record_of_a_run_stays_measured(measured):
    shutil.copy("frames/two/depth.tiff", "frames/one-done/measured.tiff")
    frame = ilf.load_frame("frames/two/rgb.png", "frames/one-done/measured.tiff")
    assert not frame.notes


def test_a_folder_with_colour_and_depth_is_a_frame_everywhere(small_frame, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("f0", "f1"):
        write_frame(f"set/{name}", small_frame)
        (tmp_path / "set" / name / "meta.json").unlink()
    assert ilf.load_frame("set/f0").name == "f0"
    np.testing.assert_array_equal(ilf.load_frame("set/f0").depth, small_frame.depth)
    source = ilf.open_source("set")
    assert source.keys == ("f0", "f1")
    assert source.read("f1").name == "f1"
    assert ilf.open_source("set/f0").keys == ("f0",)
    assert main(["complete", "set/f0", "--out", "by-folder", *QUICK]) == 0
    assert main(["complete", "set", "--frame", "f0", "--out", "by-key", *QUICK]) == 0
    np.testing.assert_array_equal(np.load("by-folder/depth.npy"), np.load("by-key/depth.npy"))
    assert main(["batch", "set", "--shards", "shards", *QUICK]) == 0
    assert [frame.name for frame in ilf.open_source("shards")] == ["shards f0", "shards f1"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(ilf.IlfError, match=r"neither meta.json nor rgb"):
        ilf.load_frame("empty")
