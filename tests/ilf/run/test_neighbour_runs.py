"""Runs with the depth of neighbours: command line, files, record, replay, batches, hold-out."""

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import InputError
from ilf.evaluation.hold_out import frame_without, hidden_pixels
from ilf.io.images import read_mask
from ilf.run.record import read_record

from ..batch_frames import work_in_this_process
from ..small_sequences import CAMERA, CAMERA_TEXT, SHAPE, pose_of, sequence, write_sequence

QUICK = [
    *("--max-iterations", "5", "--no-correction", "--blocks-detector", "canny", "--blocks-min-size", "20"),
    *("--no-expected-error", "--quiet"),
]
FRAME = "frame-000002.color"


@pytest.fixture
def source(tmp_path):
    return write_sequence(tmp_path / "in")


def complete(source: Path, out: Path, *flags: str) -> int:
    inputs = [str(source), "--frame", FRAME, "--intrinsics", CAMERA_TEXT]
    return main(["complete", *inputs, "--neighbours", "1", "--out", str(out), *QUICK, *flags])


def test_a_run_marks_what_neighbours_measured_and_replays(source, tmp_path, capsys):
    assert complete(source, tmp_path / "out", "--cloud", "ply-ascii") == 0
    assert "Depth of 2 neighbours is used at" in capsys.readouterr().err
    marked = read_mask(tmp_path / "out" / "from_neighbours.png", SHAPE)
    assert marked[27:37, 21:35].all()
    assert not marked[:25].any()
    cloud = (tmp_path / "out" / "cloud.ply").read_text()
    assert "property float scalar_from_neighbours" in cloud
    record = read_record(tmp_path / "out" / "run.json")
    assert [one.name for one in record.neighbours] == ["frame-000001.color", "frame-000003.color"]
    np.testing.assert_array_equal(record.neighbours[0].motion, np.linalg.inv(pose_of(2)) @ pose_of(1))
    assert main(["complete", "--replay", str(tmp_path / "out" / "run.json"), "--out", str(tmp_path / "again")]) == 0
    assert "identical to the recorded one" in capsys.readouterr().out
    assert (tmp_path / "again" / "run.json").read_bytes() == (tmp_path / "out" / "run.json").read_bytes()
    assert main(["info", str(tmp_path / "out" / "run.json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["run"]["neighbours"] == ["frame-000001.color", "frame-000003.color"]


def test_a_replay_names_the_neighbour_that_is_gone_or_has_changed(source, tmp_path):
    assert complete(source, tmp_path / "out") == 0
    path = source / "frame-000003.depth.png"
    whole = path.read_bytes()
    depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    depth[0, 0] += 1
    cv2.imwrite(str(path), depth)
    with pytest.raises(InputError, match=r"frame-000003\.depth\.png is not the neighbour frame-000003\.color of"):
        ilf.replay(tmp_path / "out" / "run.json")
    path.unlink()
    with pytest.raises(InputError, match=r"The neighbour frame-000003\.color .* cannot be read.*frame-000003\.depth"):
        ilf.replay(tmp_path / "out" / "run.json")
    (tmp_path / "out" / path.name).write_bytes(whole)
    assert ilf.replay(tmp_path / "out" / "run.json").run.frame.from_neighbours is not None


def test_neighbours_that_are_not_from_files_cannot_be_replayed(source, tmp_path):
    frames = sequence()
    own = ilf.open_source(source, intrinsics=CAMERA)[2]
    frame = ilf.with_neighbours(own, [frames[1]])
    done = ilf.complete(frame, np.ones(SHAPE, np.int32), "paper", max_iterations=3)
    done.save(tmp_path / "out", expected_error=False)
    with pytest.raises(InputError, match="its neighbour frame 1 was not read from files"):
        ilf.replay(tmp_path / "out" / "run.json")


def test_a_batch_uses_neighbours_and_notices_when_their_files_change(source, tmp_path, monkeypatch, capsys):
    begun = work_in_this_process(monkeypatch)
    out = tmp_path / "out"
    command = ["batch", str(source), "--out", str(out), "--intrinsics", CAMERA_TEXT, "--neighbours", "1", *QUICK]
    command += ["--no-cloud"]
    assert main(command) == 0
    assert len(begun) == 5
    rows = list(csv.DictReader((out / "manifest.csv").read_text().splitlines()))
    assert [row["message"].count("Depth of 2 neighbours is used") for row in rows] == [0, 1, 1, 1, 0]
    assert all((out / row["folder"] / "from_neighbours.png").is_file() for row in rows)
    assert int(rows[2]["missing_before"]) == 12 * 16
    assert main(command) == 0
    assert len(begun) == 5
    path = source / "frame-000004.depth.png"
    depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    depth[0, 0] += 1
    cv2.imwrite(str(path), depth)
    assert main([*command, "--rerun-changed"]) == 0
    assert begun[5:] == ["frame-000003.color", "frame-000004.color"]


def test_hold_out_hides_the_frames_own_depth_from_the_neighbours_test():
    frames = sequence()
    frame = ilf.with_neighbours(frames[2], frames[1:2], frames[3:4])
    left = frame_without(frame, "areas")
    hidden = hidden_pixels(frame, "areas")
    assert not left.own[hidden].any()
    assert left.from_neighbours[hidden].mean() > 0.7
    np.testing.assert_array_equal(left.own, frame.own & ~hidden)
