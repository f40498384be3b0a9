"""Runs on frames of recordings: on the command line, their records, and made again from these."""

import json
import re
import shutil

import cv2
import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import InputError
from ilf.sources.opening import close_all
from tests.ilf.bags import COLOUR, DEPTH, H, W, bag, write_aligned

KEY = "1600000000.033000000"
QUICK = ["--max-iterations", "5", "--no-expected-error", "--quiet"]


@pytest.fixture(autouse=True)
def nothing_left_open():
    yield
    close_all()


@pytest.fixture
def labels(tmp_path):
    values = np.zeros((H, W), np.uint8)
    values[2:14, 4:20] = 1
    cv2.imwrite(str(tmp_path / "blocks.png"), values)
    return tmp_path / "blocks.png"


def test_a_frame_by_its_key_its_record_and_its_folder(tmp_path, labels):
    path, out = write_aligned(tmp_path, "ros1"), tmp_path / "out"
    assert main(["complete", str(path), "--frame", KEY, "--blocks", str(labels), "--out", str(out), *QUICK]) == 0
    record = json.loads((out / "run.json").read_text())
    assert record["inputs"]["frame"] == KEY
    assert record["inputs"]["rgb"]["path"] == record["inputs"]["depth"]["path"] == str(path)
    completed = ilf.load_frame(out)
    assert np.array_equal(completed.rgb, COLOUR + 1)
    assert completed.known[2:14, 4:20].all()

    again = ilf.replay(out / "run.json")
    assert again.verdict(again.run.complete()) == ()
    moved = tmp_path / "elsewhere.bag"
    close_all()
    path.rename(moved)
    with pytest.raises(InputError, match=f"^{re.escape(str(path))}: there is no such file, but it is the recording"):
        ilf.replay(out / "run.json")
    assert (
        main(["complete", "--replay", str(out / "run.json"), str(moved), "--out", str(tmp_path / "b"), "--quiet"]) == 0
    )
    assert (tmp_path / "b" / "depth.png").read_bytes() == (out / "depth.png").read_bytes()
    shutil.copy(moved, out / path.name)  # beside the record it is found
    assert ilf.replay(out / "run.json").run.frame.inputs == again.run.frame.inputs


def test_another_recording_is_not_taken_for_it(tmp_path, labels):
    path, out = write_aligned(tmp_path, "ros1"), tmp_path / "out"
    assert main(["complete", str(path), "--frame", KEY, "--blocks", str(labels), "--out", str(out), *QUICK]) == 0
    close_all()
    path.unlink()
    with bag(tmp_path, "ros1") as changed:
        changed.image("/camera/color/image_raw", COLOUR, "rgb8", 33_000_000)
        changed.image("/camera/aligned_depth_to_color/image_raw", DEPTH, "16UC1", 33_000_000)
    with pytest.raises(InputError, match=f"frame {KEY} differs"):
        ilf.replay(out / "run.json")


def test_what_info_says(tmp_path, capsys, cli):
    path = write_aligned(tmp_path, "mcap")
    said = cli("info", path).out
    assert f"{path}, 3 frames" in said
    assert "1600000000.000000000, 1600000000.033000000, 1600000000.066000000" in said
    said = cli("info", path, "--frame", KEY).out
    assert f"{W} x {H}, uint16" in said
    assert "fx 30, fy 28, cx 16.2, cy 10.9" in said
    topics = "/camera/color/image_raw,/camera/aligned_depth_to_color/image_raw"
    assert main(["info", str(path), "--topics", topics, "--frame", KEY]) == 0
    assert "is not COLOUR,DEPTH" in cli("info", path, "--topics", "one", "--frame", KEY, status=2).err
    assert "give the key of one of its frames" in cli("complete", path, status=1).err


def test_a_project_of_a_recording(tmp_path):
    path = write_aligned(tmp_path, "sqlite3")
    project = tmp_path / "work.ilf"
    assert main(["project", "new", str(project), str(path)]) == 0
    assert main(["project", "info", str(project), "--json"]) == 0
