"""Depth by hand in files: read, written, marked, recorded, and by the command line."""

import json

import cv2
import numpy as np

import ilf
from ilf.cli import main
from ilf.io.images import read_mask
from ilf.run.options import ExportOptions
from ilf.run.writing import write

from ..small_frames import CAMERA, write_small_frame
from ..small_runs import contents, small_run, with_depth_by_hand
from ..space_formats import read_points

ARGUMENTS = ["--max-iterations", "25", "--intrinsics", CAMERA]


def test_it_is_marked_in_the_results(tmp_path):
    run = with_depth_by_hand(small_run(tmp_path))
    completion = run.complete()
    write(tmp_path / "out", completion, ExportOptions(cloud="ply"))
    marked = read_mask(tmp_path / "out" / "by_hand.png", run.frame.shape)
    assert np.array_equal(marked, run.blocks.by_hand.pixels & run.frame.missing & (run.blocks.labels > 0))
    assert np.array_equal(marked, completion.by_hand)
    points = read_points(tmp_path / "out" / "cloud.ply")
    assert np.array_equal(points["scalar_by_hand"] > 0, marked[np.isfinite(completion.depth)])
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["by_hand"]["weight"] == 0.6
    assert sum(outcome["by_hand"] for outcome in record["blocks_outcome"]) == marked.sum()

    plain = small_run(tmp_path)
    write(tmp_path / "plain", plain.complete(), ExportOptions(cloud="ply"))
    assert not {"by_hand.png", "depth_by_hand.npy"} & contents(tmp_path / "plain").keys()
    assert "scalar_by_hand" not in read_points(tmp_path / "plain" / "cloud.ply")


def test_by_the_command_line(tmp_path, monkeypatch, capsys, cli):
    monkeypatch.chdir(tmp_path)
    write_small_frame(tmp_path / "in")
    files = ["in/rgb.png", "in/depth.png"]
    stated = np.zeros((60, 80), np.uint16)
    stated[24:28, 12:20] = 1750
    cv2.imwrite("hand.png", stated)
    np.save("hand.npy", stated / 1000.0)
    for name in ("hand.png", "hand.npy"):
        out = f"out-{name}"
        document = json.loads(cli("complete", *files, *ARGUMENTS, "--by-hand", name, "--json", "--out", out).out)
        assert document["by_hand"] == np.count_nonzero(stated)
        assert sum(block["by_hand"] for block in document["blocks"]) == np.count_nonzero(stated)
    assert np.array_equal(np.load("out-hand.png/depth.npy"), np.load("out-hand.npy/depth.npy"))
    frame = ilf.load_frame(*files)
    library = ilf.complete(frame, max_iterations=25, by_hand=stated / 1000.0)
    assert np.array_equal(np.load("out-hand.npy/depth.npy"), library.depth)

    assert main(["complete", *files, *ARGUMENTS, "--by-hand", "hand.npy", "--by-hand-weight", "0.9"]) == 0
    assert "32 of them by hand" in capsys.readouterr().out
    assert main(["complete", "--replay", "in-ilf/run.json", "--out", "again", "--quiet"]) == 0
    assert contents(tmp_path / "again") == contents(tmp_path / "in-ilf")
    assert "depth_by_hand.npy, weight 0.9" in cli("info", "in-ilf/run.json").out
