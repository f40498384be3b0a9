"""Batches that write shards: what tars and tables contain, resuming, checking, and reading them as a source."""

import gc
import glob
import io
import json
import subprocess
import sys
import time
import warnings
from pathlib import Path

import cv2
import numpy as np
import PIL.Image
import pytest

import ilf
import ilf.batch.engine
from ilf.cli import main
from ilf.errors import InputError

from ..batch_frames import write_frames
from .test_batch import FLAGS

pyarrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

QUICK = ["--quiet", *FLAGS[:-1]]


def command(source: Path, out: Path, *more: str) -> list[str]:
    return ["batch", str(source), "--shards", str(out), "--per-shard", "2", *QUICK, *more]


def tars(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.tar"))}


def rows(folder: Path) -> list[dict]:
    return [row for path in sorted(folder.glob("shard-*.parquet")) for row in parquet.read_table(path).to_pylist()]


def samples(folder: Path) -> list[dict]:
    iterators = pytest.importorskip("webdataset").tariterators
    found = []
    for path in sorted(folder.glob("*.tar")):
        with open(path, "rb") as stream:
            files = iterators.tar_file_expander([{"url": str(path), "stream": stream}])
            found += list(iterators.group_by_keys(files))
    return found


def test_shards_contain_what_folders_do(source, tmp_path, begun, capsys):
    (source / "depth" / "0002.png").write_bytes(b"no image")
    out, folders = tmp_path / "out", tmp_path / "folders"
    impossible = "--export", "camera.json"  # without intrinsics, which both say
    assert main(command(source, out, *impossible)) == 1
    assert "1 of 5 frames failed. rgb/0002: " in capsys.readouterr().err
    assert sorted(path.suffix for path in out.iterdir()) == [".json", ".jsonl", *[".parquet"] * 3, *[".tar"] * 3]
    assert main(["batch", str(source), "--out", str(folders), *QUICK, "--no-cloud", *impossible]) == 1
    found = {sample["__key__"]: sample for sample in samples(out)}
    assert list(found) == ["rgb__0000", "rgb__0001", "rgb__0003", "rgb__0004"]
    for key, sample in found.items():
        assert set(sample) - {"__key__", "__url__", "__local_path__"} == {
            "depth.png",
            "expected_error.png",
            "blocks.png",
            "frame.json",
        }
        for name in ("depth.png", "expected_error.png", "blocks.png"):
            assert sample[name] == (folders / key / name).read_bytes()
        facts = json.loads(sample["frame.json"])
        assert (facts["key"].replace("/", "__"), facts["size"], facts["depth_units_per_m"], facts["K"]) == (
            key,
            [32, 24],
            1000,
            None,
        )
    table = rows(out)
    for row in table:
        outcome = json.loads((folders / row["sample"] / "frame.json").read_text())["outcome"]
        outcome |= {"key": outcome.pop("frame"), "sample": outcome.pop("folder"), "seconds": row["seconds"]}
        assert outcome == {name: row[name] for name in outcome}
    assert [row["status"] for row in table] == ["completed", "completed", "failed", "completed", "completed"]
    assert "not a PNG" in table[2]["message"]
    assert (table[2]["offset"], table[2]["shard"], table[2]["seconds"] >= 0) == (None, None, True)
    row = table[4]
    tar = (out / row["shard"]).read_bytes()[row["offset"] : row["offset"] + row["size"]]
    assert tar.startswith(b"rgb__0004.depth.png")
    assert found["rgb__0004"]["depth.png"] in tar


def test_shards_are_a_source(source, tmp_path, begun, cli):
    out = tmp_path / "out"
    (source / "depth" / "0001.png").write_bytes(b"no image")
    assert main(command(source, out)) == 1
    opened = ilf.open_source(out)
    assert opened.keys == ("rgb/0000", "rgb/0002", "rgb/0003", "rgb/0004")
    assert "not done: 1 of" in opened.notes[0]
    (sample,) = [one for one in samples(out) if one["__key__"] == "rgb__0003"]
    depth = cv2.imdecode(np.frombuffer(sample["depth.png"], np.uint8), cv2.IMREAD_UNCHANGED)
    frame = opened["rgb/0003"]
    np.testing.assert_array_equal(np.nan_to_num(frame.depth), (depth / 1000).astype(np.float32))
    colour = source / "rgb" / "0003.png"
    np.testing.assert_array_equal(frame.rgb, cv2.imread(str(colour))[..., ::-1])
    told = cli("info", out).out
    assert "3 of 3 finished, 2 frames each" in told
    assert "5 frames: 4 completed, 1 failed, 0 not done" in told
    assert "4 frames" in told
    colour.write_bytes((source / "rgb" / "0000.png").read_bytes()[:-1] + b"x")
    with pytest.raises(InputError, match="has changed since depth was completed"):
        opened["rgb/0003"]
    colour.unlink()
    with pytest.raises(InputError, match="--keep depth,rgb"):
        opened["rgb/0003"]


def test_webdataset_reads_them_as_documented(source, tmp_path, begun):
    webdataset = pytest.importorskip("webdataset")
    assert main(command(source, tmp_path / "DIR")) == 0
    text = (Path(__file__).parents[3] / "assets" / "docs" / "clusters.md").read_text(encoding="utf-8")
    example = next(code for code in text.split("```python\n") if code.startswith("def decoded")).partition("```")[0]
    example = example.replace("DIR", str(tmp_path / "DIR"))
    names: dict = {"np": np, "PIL": PIL, "io": io, "glob": glob, "webdataset": webdataset}
    expected = ilf.open_source(tmp_path / "DIR")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # it leaves tars open until they are collected
        exec(compile(example, "clusters.md", "exec"), names)
        found = {facts["key"]: depth for depth, facts in names.pop("samples")}
        gc.collect()
    assert sorted(found) == list(expected.keys)
    for key, depth in found.items():
        np.testing.assert_array_equal(depth, np.nan_to_num(expected[key].depth))


def test_shards_with_colour_need_no_source(source, tmp_path, begun):
    out, pose = tmp_path / "out", np.eye(4)
    pose[0, 3] = 10
    for number in range(5):
        np.savetxt(source / "depth" / f"{number:04}.pose.txt", pose)
    more = ["--keep", "unsupported,rgb,depth", "--depth-formats", "npy", "--intrinsics", "30,30,16,12"]
    assert main(command(source, out, *more)) == 0
    colour = cv2.imread(str(source / "rgb" / "0001.png"))[..., ::-1]
    source.rename(tmp_path / "moved")
    opened = ilf.open_source(out)
    frame = opened["rgb/0001"]
    np.testing.assert_array_equal(frame.rgb, colour)
    assert (frame.intrinsics.fx, frame.pose[0, 3], opened.calibration("rgb/0001").depth.cy) == (30, 10, 12)
    (sample,) = [one for one in samples(out) if one["__key__"] == "rgb__0001"]
    assert {name for name in sample if name[0] != "_"} == {"depth.npy", "unsupported.png", "rgb.png", "frame.json"}
    assert not np.isnan(frame.depth).all()


def test_finished_shards_are_not_done_again(source, tmp_path, begun, capsys, cli):
    out = tmp_path / "out"
    assert main(command(source, out, "--shard", "2/2")) == 0
    assert begun == ["rgb/0002", "rgb/0003"]
    (source / "rgb" / "0009.png").write_bytes(b"added later: the list is frozen")
    assert "5 frames: 2 completed, 0 failed, 3 not done" in cli("info", out).out
    assert "2 of 3 shards not finished. Run the batch again" in cli("batch", "--shards", out, "--verify", status=1).err
    assert "The batch is unfinished: merged.parquet has 1 of 3 shards" in cli("batch", "--shards", out, "--merge").err
    assert main([word for word in command(source, out) if word != "--quiet"]) == 0
    assert begun[2:] == ["rgb/0000", "rgb/0001", "rgb/0004"]
    assert "5 frames: 3 completed, 0 failed, 2 completed before" in capsys.readouterr().out
    first = tars(out)
    sorted(out.glob("*.parquet"))[-1].unlink()  # as if it had ended between the tar and the table
    assert main(command(source, out)) == 0
    assert begun[5:] == ["rgb/0004"]
    assert tars(out) == first
    state = json.loads(cli("batch", "--shards", out, "--verify", "--merge", "--json").out)
    assert (state["finished"], state["completed"], state["problems"]) == (3, 5, [])
    assert parquet.read_table(out / "merged.parquet").to_pylist() == rows(out)


def test_kills_lose_nothing_and_repeat_nothing(source, tmp_path, begun):
    out, alone = tmp_path / "out", tmp_path / "alone"
    assert main(command(source, alone)) == 0
    assert main(command(source, out, "--shard", "3/3")) == 0
    process = subprocess.Popen([sys.executable, "-m", "ilf", *command(source, out)], stderr=subprocess.PIPE)
    try:
        while not list(out.glob("parts/*000001/0*")):
            assert process.poll() is None
            time.sleep(0.002)
    finally:
        process.kill()
        process.communicate()  # its worker, which ends with it, has the same end of the pipe
    done = {int(path.name) for path in out.glob("parts/*/0*")} | {int(row["key"][-4:]) for row in rows(out)}
    begun.clear()
    assert main(command(source, out)) == 0
    assert sorted(begun) == [f"rgb/{number:04}" for number in range(5) if number not in done]
    assert tars(out) == tars(alone)
    assert main(["batch", "--shards", str(out), "--verify"]) == 0


def test_other_settings_and_frames_are_noticed(source, tmp_path, begun, capsys):
    out = tmp_path / "out"
    assert main(command(source, out, "--frames", ":2")) == 0
    before = tars(out)
    for more, message in (
        (["--frames", ":2", "--keep", "depth"], "other settings (shards.keep: "),
        (["--frames", ":3"], "other frames (frames: [None, 2], now [None, 3])"),
    ):
        assert main(command(source, out, *more)) == 1
        assert message in capsys.readouterr().err
    folders = tmp_path / "folders"
    assert main(["batch", str(source), "--out", str(folders), "--frames", ":1", *QUICK]) == 0
    assert main(command(source, folders)) == 1
    assert "a folder for each frame. Choose another folder" in capsys.readouterr().err
    assert tars(out) == before


PROCESS = """
import sys, time
import ilf.batch.engine as engine, ilf.batch.shard_sink as shards
from ilf.cli import main
real = engine._completed
def noted(*how):
    with open(sys.argv[1], "a") as log:
        log.write(how[1].key + "\\n")
    time.sleep(0.1)
    return real(*how)
engine._completed = noted
engine.run_in_processes = shards.run_in_processes = lambda work, items, **_: ((item, work(item)) for item in items)
sys.exit(main(sys.argv[2:]))
"""


def test_two_batches_share_the_work(tmp_path, begun, monkeypatch):
    source, out, log = write_frames(tmp_path / "in", 12), tmp_path / "out", tmp_path / "log"
    shared, real = command(source, out, "--per-shard", "3"), ilf.batch.engine.complete_frame
    assert main(command(source, tmp_path / "alone", "--per-shard", "3")) == 0
    begun.clear()
    monkeypatch.setattr(ilf.batch.engine, "complete_frame", lambda *how, **more: time.sleep(0.1) or real(*how, **more))
    with subprocess.Popen([sys.executable, "-c", PROCESS, str(log), *shared]) as other:
        try:
            while not log.exists():
                assert other.poll() is None
                time.sleep(0.01)
            assert main(shared) == 0
            assert other.wait() == 0
        finally:
            other.kill()
    done = log.read_text().split() + begun
    assert begun
    assert len(set(done)) == 12
    assert len(done) <= 12 + 4, "one at most where they meet, in each of the last shards"
    assert tars(out) == tars(tmp_path / "alone")
    assert main(["batch", "--shards", str(out), "--verify"]) == 0
    assert not (out / "parts").exists()
