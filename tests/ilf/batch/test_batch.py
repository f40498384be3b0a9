"""Batches: which frames there are, what is not done again, what came of each, and whatever may go wrong with one."""

import csv
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from statistics import median

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ilf
import ilf.batch.folder_sink
from ilf._runtime.formatting import grouped, millimetres
from ilf._runtime.networks.models import BUNDLED, CORRECTION, SPARSE_CORRECTION
from ilf.batch.cluster import run_on_cluster
from ilf.batch.engine import complete_frame, complete_many
from ilf.batch.folder_sink import open_folder
from ilf.batch.frame_record import LoadedFrame, read_frame, read_frame_record
from ilf.batch.frames import folder_name, frames_of_sources, named_frames, sample_name, shard_of, slice_frames
from ilf.batch.pictures import depth_levels, read_preview
from ilf.batch.settings import BatchSettings, read_settings, write_settings
from ilf.batch.static_camera import with_temporal_median
from ilf.cli import main
from ilf.errors import FormatError, InputError
from ilf.run.options import ExportOptions
from ilf.run.record import read_record
from ilf.run.run import BlockChoice
from ilf.sources import reading
from ilf.sources.frame_ref import FrameRef

from ..batch_frames import Deadly, contents, write_frames

SETTINGS = BatchSettings(
    ilf.preset(max_iterations=5, correction=False),
    BlockChoice(ilf.BlockParameters(detector="canny", min_size=20)),
    options=ExportOptions(cloud=None),
)
FLAGS = ["--max-iterations", "5", "--no-correction", "--blocks-detector", "canny", "--blocks-min-size", "20"]
FLAGS += ["--no-cloud"]


@pytest.fixture
def source(tmp_path):
    """A folder of three small frames."""
    return write_frames(tmp_path / "in", 3)


def frames_in(folder):
    return frames_of_sources([ilf.open_source(folder)])


def manifest(folder):
    return list(csv.DictReader((folder / "manifest.csv").read_text().splitlines()))


def test_a_frame_that_kills_its_process_costs_itself_alone(source, tmp_path):
    frames = [*frames_in(source)[:2], *named_frames([("deadly", Deadly("a.png", "b.png"), None)])]
    (tmp_path / "out").mkdir()
    write_settings(tmp_path / "out", SETTINGS.facts(), (1.0, 3.0))
    batch = open_folder(frames, tmp_path / "out", SETTINGS)
    outcomes = {outcome.frame: outcome for outcome in complete_many(batch)}
    assert [outcomes[frame.key].status for frame in frames] == ["completed", "completed", "failed"]
    assert "crashed twice" in outcomes["deadly"].message
    assert [outcome.status for outcome in batch.recorded()] == ["completed", "completed", "failed"]
    assert not list((tmp_path / "out").rglob(".ilf-*"))
    again = open_folder(frames, tmp_path / "out", SETTINGS)
    assert (again.to_do, [outcome.frame for outcome in again.earlier if not outcome.is_completed]) == ((), ["deadly"])
    assert list(complete_many(again)) == []


@pytest.mark.skipif(sys.platform != "linux", reason="other systems' names of files are text")
def test_frames_whose_names_are_no_text(source, tmp_path, begun):
    for folder in ("rgb", "depth"):
        (path,) = (source / folder).glob("0000.*")
        path.rename(source / folder / f"{os.fsdecode(bytes([0xE9]))}{path.suffix}")
    for count in (1, 0):
        assert main(["batch", str(source), "--out", str(tmp_path / "out"), *FLAGS, "--frames", "2:"]) == 0
        assert len(begun) == count
        begun.clear()
    assert [row["frame"] for row in manifest(tmp_path / "out")] == [r"rgb/\udce9"]


def test_what_is_told_of_frames_and_that_one_without_all_its_files_is_done_again(source, tmp_path, begun, cli):
    out = tmp_path / "out"
    command = ["batch", str(source), "--out", str(out), *FLAGS]
    said = cli(*command).out
    assert "3 frames: 3 completed, 0 failed" in said
    row = manifest(out)[0]
    pixels, before, after = (
        sum(int(one[name]) for one in manifest(out)) for name in ("pixels", "missing_before", "missing_after")
    )
    assert f"Missing depth: {before / pixels:.1%} of the pixels before, {after / pixels:.1%} after." in said
    middle = median(float(one["expected_error_median_m"]) for one in manifest(out))
    assert f"Expected error, median: {millimetres(middle)} mm in the median frame." in said
    assert (int(row["pixels"]), int(row["missing_before"]) > int(row["missing_after"])) == (768, True)
    assert float(row["expected_error_median_m"]) <= float(row["expected_error_p90_m"])
    before = contents(out)
    (out / "rgb__0001" / "depth.npy").unlink()
    assert main([*command, "--quiet"]) == 0
    assert begun[3:] == ["rgb/0001"]
    assert contents(out) == before


def test_a_run_of_its_own_gives_the_same_files(source, tmp_path, begun):
    assert main(["batch", str(source), "--out", str(tmp_path / "out"), "--frames", ":1", "--quiet", *FLAGS]) == 0
    alone = tmp_path / "alone"
    files = [str(source / name / "0000.png") for name in ("rgb", "depth")]
    assert main(["complete", *files, "--out", str(alone), "--quiet", *FLAGS]) == 0
    there = tmp_path / "out" / "rgb__0000"
    assert {path.name for path in there.iterdir()} - {path.name for path in alone.iterdir()} == {
        "frame.json",
        "preview.png",
    }
    for path in alone.iterdir():
        assert path.read_bytes() == (there / path.name).read_bytes(), path.name


def test_a_frame_whose_reader_has_a_fault_fails_alone(source, tmp_path, begun, monkeypatch, cli):
    read = reading.read_files

    def faulty(files, *given):
        return read(files, *given) if "0001" not in str(files.rgb) else np.zeros(3).reshape(2, 2)

    monkeypatch.setattr(reading, "read_files", faulty)
    said = cli("batch", source, "--out", tmp_path / "out", "--quiet", *FLAGS, status=1).err
    assert "1 of 3 frames failed. rgb/0001: ValueError: cannot reshape" in said


def test_batch_prints_one_json_document(source, tmp_path, begun, cli):
    (source / "depth" / "0001.png").write_bytes(b"no image")
    out = tmp_path / "out"
    found = json.loads(cli("batch", source, "--out", out, "--json", *FLAGS, status=1).out, parse_constant=pytest.fail)
    assert (found["completed"], found["failed"], found["not_done"]) == (2, 1, 0)
    assert [frame["status"] for frame in found["frames"]] == ["completed", "failed", "completed"]
    assert [list(frame) for frame in found["frames"]] == [list(row) for row in manifest(out)]
    assert (found["folder"], found["files"]) == (str(out), ["manifest.csv"])


def test_frames_of_other_settings_are_done_again_on_request(source, tmp_path, begun):
    command = ["batch", str(source), "--out", str(tmp_path / "out"), "--quiet", "--frames", ":2", *FLAGS]
    assert main(command) == 0
    other = [*command, "--max-iterations", "6"]
    assert [main(other), main([*other, "--rerun-changed"]), main(other)] == [1, 0, 0]
    assert begun[2:] == ["rgb/0000", "rgb/0001"]


def test_changed_files_are_noticed_moved_ones_are_the_same(source, tmp_path, begun, cli):
    out = tmp_path / "out"
    command = ["--out", str(out), "--quiet", *FLAGS]
    assert main(["batch", str(source), *command]) == 0
    moved = source.rename(tmp_path / "moved")
    assert main(["batch", str(moved), *command]) == 0
    assert len(begun) == 3
    depth = cv2.imread(str(moved / "depth" / "0002.png"), cv2.IMREAD_UNCHANGED)
    cv2.imwrite(str(moved / "depth" / "0002.png"), depth + 1)
    assert "The files of 1 frame have changed since they were completed" in cli("batch", moved, *command, status=1).err
    assert main(["batch", str(moved), *command, "--rerun-changed"]) == 0
    assert begun[3:] == ["rgb/0002"]


def test_parts_of_a_batch_share_a_folder(source, tmp_path, begun):
    out = tmp_path / "out"
    command = ["batch", str(source), "--out", str(out), "--quiet", "--hold-out", "areas", "--seeds", "1", *FLAGS]
    for part in ("2/2", "1/2"):
        assert main([*command, "--shard", part]) == 0
    assert begun == ["rgb/0001", "rgb/0000", "rgb/0002"]
    assert [row["frame"] for row in manifest(out)] == ["rgb/0000", "rgb/0001", "rgb/0002"]
    assert all(0 < float(row["hold_out_mae_m"]) <= float(row["hold_out_rmse_m"]) for row in manifest(out))


def test_a_manifest_has_what_comes_while_it_is_written(source, tmp_path, monkeypatch, begun):
    out = tmp_path / "out"
    batch = open_folder(frames_in(source), out, SETTINGS)
    complete_frame(batch, batch.to_do[0])
    real = ilf.batch.folder_sink.write_csv

    def slow(path, rows):
        real(path, rows)
        complete_frame(batch, batch.to_do[1])  # by somebody else, who has written a manifest before

    monkeypatch.setattr(ilf.batch.folder_sink, "write_csv", slow)
    batch.close()
    assert len(manifest(out)) == 2


def test_damaged_records_of_a_batch(source, tmp_path, begun):
    out = tmp_path / "out"
    assert main(["batch", str(source), "--out", str(out), "--quiet", *FLAGS]) == 0
    folder = out / frames_in(source)[0].folder
    sound = json.loads((folder / "frame.json").read_text())
    outcome = sound["outcome"]
    for wrong in (
        {"outcome": outcome | {"frame": []}},
        {"outcome": outcome | {"status": "done"}},
        {"outcome": 7},
        {"files": {"x": 3}},
    ):
        (folder / "frame.json").write_text(json.dumps(sound | wrong))
        assert read_frame_record(folder) is None
    for odd in ({"outputs": ["x" * 5000, "\0"]}, {"files": {"\0": [1, 2], "x" * 5000: [3]}}):
        (folder / "frame.json").write_text(json.dumps(sound | odd))
        record = read_frame_record(folder)
        assert not (record.has_all_files(folder) and record.is_of(frames_in(source)[0]))
    for schema in (0, 2, None):
        (folder / "frame.json").write_text(json.dumps(sound | {"schema": schema}))
        assert read_frame_record(folder) is None
    settings = json.loads((out / "batch.json").read_text())
    for schema in (0, 2, None):
        (out / "batch.json").write_text(json.dumps(settings | {"schema": schema}))
        with pytest.raises(FormatError, match=r"batch\.json has schema .* reads schema 1 only"):
            read_settings(out)
    for levels in ([10**400, 1], [1.0, None], [1.0], "ab"):
        (out / "batch.json").write_text(json.dumps(settings | {"levels": levels}))
        with pytest.raises(FormatError, match="not written by a batch"):
            read_settings(out)


@pytest.mark.parametrize("content", ["{", "[]", '{"address": 7}', '{"address": "tcp://x"}', '"address"', "\0"])
def test_damaged_files_of_schedulers(tmp_path, content):
    path = tmp_path / "scheduler.json"
    path.write_text(content)
    with pytest.raises(InputError, match=str(path)):
        list(run_on_cluster(abs, [-1], str(path)))


def test_previews_share_their_colours(source, tmp_path, begun):
    out = tmp_path / "out"
    command = ["batch", str(source), "--out", str(out), "--quiet", "--contact-sheet", "--video", *FLAGS]
    assert main(command) == 0
    frames = frames_in(source)
    assert json.loads((out / "batch.json").read_text())["levels"] == list(depth_levels(frames))
    wall = [read_preview(out / frame.folder)[-1, 70] for frame in frames]  # the same surface in all of them
    assert np.ptp(wall, axis=0).max() == 0
    assert read_preview(out / frames[0].folder).shape == (24, 96, 3)
    sheet = cv2.imread(str(out / "contact-sheet.png"))
    assert sheet.shape == (128, 1184, 3)
    for number, frame in enumerate(frames):
        shown = sheet[8:104, 8 + 392 * number :][:, :384, ::-1].astype(int)  # four times as large, and BGR
        assert np.abs(shown[2::4, 2::4] - read_preview(out / frame.folder)).mean() < 10
    import av

    with av.open(str(out / "video.mp4")) as video:
        assert [picture.width for picture in video.decode(video=0)] == [96] * 3
    with pytest.raises(FormatError, match="complete the frame again"):
        read_preview(out)


@pytest.mark.parametrize(
    ("request_", "message", "status"),
    [
        ("SOURCE --out OUT --shard 3/2", "is not a part K/N", 2),
        ("SOURCE --out OUT --frames 3", "not a range of frames", 2),
        ("SOURCE --out OUT --frames 7:", "numbered from 0 to 2", 1),
        ("SOURCE --out OUT --seeds 2", "add --hold-out", 2),
        ("SOURCE --out OUT --dask 127.0.0.1:1 --jobs 2", "leave out --jobs", 2),
        ("SOURCE --out OUT --invalid-mask missing.png", "missing.png", 1),
        ("SOURCE --out OUT --depth-encoding mmm", "Did you mean mm?", 1),
        ("SOURCE --out OUT --intrinsics kinectt", "Did you mean kinect-v2?", 1),
        ("SOURCE --out OUT --depth-intrinsics 525,525", "is not fx,fy,cx,cy", 1),
        ("SOURCE --out OUT --keep depth", "add --shards", 2),
        ("SOURCE", "an output folder by --out or --shards", 2),
        ("SOURCE --shards OUT --out elsewhere", "--shards replaces --out", 2),
        ("SOURCE --shards OUT --keep rgb", "--keep takes depth", 2),
        ("SOURCE --shards OUT --keep depth,normals", "--keep takes depth", 2),
        ("SOURCE --shards OUT --depth-formats png,npy", "one format, png or npy", 2),
        ("SOURCE --shards OUT --mesh ply --video", "--video, --mesh cannot be combined with --shards", 2),
        ("SOURCE --shards OUT --no-expected-error", "--no-expected-error cannot be combined with --shards", 2),
        ("SOURCE --shards OUT --verify", "--verify needs no SOURCE", 2),
        ("SOURCE --shards OUT --frames 7:", "numbered from 0 to 2", 1),
        ("--shards OUT --verify", "contains no shards", 1),
    ],
)
def test_wrong_requests_are_told_before_anything_is_made(source, tmp_path, begun, cli, request_, message, status):
    places = {"SOURCE": source, "OUT": tmp_path / "out"}
    words = [places.get(word, word) for word in request_.split()]
    assert message in cli("batch", *words, status=status).err
    assert not (tmp_path / "out").exists()


def test_results_do_not_go_into_the_source(source, cli):
    before = contents(source)
    assert "another output folder" in cli("batch", source, "--out", source, status=1).err
    assert contents(source) == before


def test_what_is_no_address_is_not_asked_for_a_scheduler(monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(distributed, "Client", lambda **_: pytest.fail("a client was made"))
    with pytest.raises(InputError, match="no Dask scheduler at nowhere"):
        next(run_on_cluster(abs, (), "nowhere"))


_LOST = """
import subprocess, sys
from pathlib import Path

import distributed

from ilf.cli import main

source, out, told = sys.argv[1:]
if __name__ == "__main__":
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
    command += ["--no-dashboard", "--scheduler-file", told]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as scheduler:
        try:
            while not Path(told).exists():
                assert scheduler.poll() is None
            as_completed = distributed.as_completed

            def lost(*args, **more):  # once the frames have been handed in
                scheduler.kill()
                return as_completed(*args, **more)

            distributed.as_completed = lost
            sys.exit(main(["batch", source, "--out", out, "--dask", told]))
        finally:
            scheduler.kill()
"""


def test_a_scheduler_that_is_lost_is_told_in_one_line(source, tmp_path):
    pytest.importorskip("distributed")
    told = tmp_path / "scheduler.json"
    ended = subprocess.run(
        [sys.executable, "-c", _LOST, source, tmp_path / "out", told], capture_output=True, text=True
    )
    assert ended.returncode == 1
    assert ended.stderr == (f"ilf: error: The Dask scheduler at {told} was lost. What is done is kept: run it again.\n")
    assert "3 not done" in ended.stdout
    assert (tmp_path / "out" / "manifest.csv").exists()


def test_sources_of_one_name_are_refused(source):
    opened = ilf.open_source(source)
    with pytest.raises(InputError, match="Two sources are named in"):
        frames_of_sources([opened, opened])


@pytest.mark.parametrize(("name_of", "never"), [(folder_name, '\\:*?"<>|'), (sample_name, ".")])
@given(keys=st.lists(st.text("aA_/.+: é\x00-", min_size=1, max_size=12), unique=True, max_size=8))
def test_frames_have_names_of_their_own(name_of, never, keys):
    frames = named_frames((key, FrameRef("/a", "/b"), None) for key in keys)
    folders = [frame.folder.casefold() for frame in frames]
    assert len(set(folders)) == len({name_of(key) for key in keys}) == len(keys)
    assert not any(set(name_of(key)) & set(f"/\0 {never}") for key in keys)
    assert not any(name.startswith(".") for name in folders)
    assert all(frame.folder.startswith(folder_name(frame.key)) for frame in frames)


@given(st.integers(1, 40), st.integers(1, 7))
def test_every_frame_is_in_one_shard(count, shards):
    frames = named_frames((f"{number}", FrameRef("/a", "/b"), None) for number in range(count))
    parts = [frame.key for number in range(shards) for frame in shard_of(frames, number + 1, shards)]
    assert sorted(parts) == sorted(frame.key for frame in frames)
    assert [frame.key for frame in slice_frames(frames, every=shards)] == [
        str(number) for number in range(0, count, shards)
    ]


def test_settings_hold_what_their_files_do(source, tmp_path):
    mask = tmp_path / "mask.png"
    cv2.imwrite(str(mask), np.zeros((24, 32), np.uint8))
    settings = replace(SETTINGS, invalid_mask=str(mask), hidden=ilf.HoldOutTest("areas", (0,)))
    before = settings.facts()
    cv2.imwrite(str(mask), np.full((24, 32), 255, np.uint8))
    assert before != settings.facts()
    assert before["hidden"] == {"pattern": "areas", "seeds": [0]}
    assert "neighbours" not in before
    assert replace(settings, neighbours=2, neighbour_step=3).facts()["neighbours"] == [2, 3]


def test_settings_name_the_networks_that_have_a_part_in_the_results():
    def networks(**parameters):
        chosen = ilf.preset("best", edges="canny", **parameters)
        return set(replace(SETTINGS, parameters=chosen).facts()["networks"])

    assert networks(correction=True) == {CORRECTION, SPARSE_CORRECTION}
    assert networks(correction=False) == set()
    assert BUNDLED in BatchSettings().facts()["networks"]


def test_frames_have_guides_and_truths_by_their_names(source, tmp_path, begun, cli):
    (tmp_path / "ground_truth").mkdir()
    for number in range(2):
        depth = cv2.imread(str(source / "depth" / f"{number:04}.png"), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(
            str(tmp_path / "ground_truth" / f"{number:04}.png"), np.where(depth > 0, depth, 2000).astype(np.uint16)
        )
    beside = ["--ground-truth", str(tmp_path / "ground_truth"), "--guide", str(tmp_path / "ground_truth")]
    command = ["batch", str(source), "--out", str(tmp_path / "out"), "--quiet", *beside, *FLAGS]
    assert "no file for rgb/0002. Add rgb__0002 or 0002" in cli(*command, status=1).err
    assert main([*command, "--frames", ":2"]) == 0
    assert all(0 < float(row["truth_mae_m"]) <= float(row["truth_rmse_m"]) for row in manifest(tmp_path / "out"))
    assert (tmp_path / "out" / "rgb__0001" / "guide_used.npy").exists()


def test_a_camera_that_stands_still_gives_steady_depth(tmp_path, begun, capsys, cli):
    source, out = tmp_path / "in", tmp_path / "out"
    for folder in ("rgb", "depth"):
        (source / folder).mkdir(parents=True)
    colour = np.full((24, 64, 3), 90, np.uint8)
    for number, stored in enumerate((2000, 2030, 1990)):
        depth = np.full((24, 64), stored, np.uint16)
        depth[5:9, 5 + number : 8 + number] = 0  # a hole that moves: each pixel is known in some frame
        moving = colour.copy()
        moving[:, 56:] = 60 * number  # something else goes on there
        cv2.imwrite(str(source / "rgb" / f"{number:04}.png"), moving)
        cv2.imwrite(str(source / "depth" / f"{number:04}.png"), depth)
    command = ["batch", str(source), "--out", str(out), "--quiet", "--static-camera", "1", *FLAGS]
    assert main(command) == 0
    made = np.load(out / "rgb__0001" / "steady" / "depth.npy")
    assert np.allclose(made[10:, :40], 2.0)
    np.testing.assert_allclose(made[6, 6:9], [1.99, np.nan, 2.0])
    assert np.allclose(made[:, 56:], 2.03)
    measured = cv2.imread(str(source / "depth" / "0001.png"), cv2.IMREAD_UNCHANGED) / np.float32(1000)
    changed = np.count_nonzero(np.isfinite(made) & (made != measured))
    told = manifest(out)[1]["message"]
    differs = f"it differs from the measured depth at {grouped(changed)} of {grouped(made.size)} pixels"
    assert f"of up to 3 frames where colour is unchanged: {differs}" in told
    assert main(["complete", "--replay", str(out / "rgb__0001" / "run.json"), "--out", str(tmp_path / "again")]) == 0
    assert "identical to the recorded one" in capsys.readouterr().out
    before = contents(out)
    assert main(command) == 0
    assert contents(out) == before
    cv2.imwrite(str(source / "depth" / "0000.png"), np.full((24, 64), 2001, np.uint16))
    assert main(command) == 1  # the second frame has taken depth from the first, the third has not
    assert "The files of 2 frames have changed" in capsys.readouterr().err
    cli(*command[: -len(FLAGS) - 1], "0", *FLAGS, status=2)


def test_steady_depth_keeps_the_pose(tmp_path, begun, capsys):
    source, out = write_frames(tmp_path / "in", 2), tmp_path / "out"
    pose = np.eye(4)
    pose[0, 3] = 10
    for number in range(2):
        np.savetxt(source / "depth" / f"{number:04}.pose.txt", pose)
    command = ["batch", str(source), "--out", str(out), "--quiet", "--static-camera", "1", *FLAGS[:-1]]
    assert main([*command, "--intrinsics", "30,30,16,12", "--axes", "world"]) == 0
    assert read_record(out / "rgb__0001" / "run.json").pose == tuple(map(tuple, pose.tolist()))
    assert main(["project", "export", str(out), "--to", "nerfstudio", "--out", str(tmp_path / "nerf")]) == 0


def test_frames_whose_cloud_cannot_be_in_the_world_fail_before_they_are_run(source, tmp_path, monkeypatch):
    monkeypatch.setattr(ilf.Run, "complete", lambda *_, **__: pytest.fail("was run"))
    first = replace(frames_in(source)[0], source=frames_in(source)[0].source.with_options(intrinsics="30,30,16,12"))
    batch = open_folder([first], tmp_path / "out", replace(SETTINGS, options=ExportOptions(axes="world")))
    outcome = complete_frame(batch, first)
    assert outcome.message.startswith("The pose of this frame's camera is not known")


def test_a_camera_that_moves_leaves_depth_as_measured(tmp_path, begun):
    source, rng = write_frames(tmp_path / "in", 3), np.random.default_rng(0)
    for number in range(3):
        image = rng.integers(0, 255, (24, 32, 3), np.uint8)
        cv2.imwrite(str(source / "rgb" / f"{number:04}.png"), image)
    assert main(["batch", str(source), "--out", str(tmp_path / "out"), "--quiet", "--static-camera", *FLAGS]) == 0
    told = manifest(tmp_path / "out")[1]["message"]
    assert "Depth is unchanged: none of 2 neighbouring frames shows the same view." in told
    assert "median" not in told


def test_other_views_and_damaged_neighbours_have_no_say(tmp_path):
    frame = ilf.RGBDFrame(np.full((20, 30, 3), 90, np.uint8), np.full((20, 30), 2.0))
    other_size = ilf.RGBDFrame(np.full((10, 30, 3), 90, np.uint8), np.full((10, 30), 3.0))
    rng = np.random.default_rng(0)
    other_view = ilf.RGBDFrame(rng.integers(0, 255, (20, 30, 3), np.uint8), np.full((20, 30), 3.0))
    steady = with_temporal_median(LoadedFrame(frame, (other_size, other_view), "", {}), tmp_path / "steady")
    assert np.all(steady.depth == 2.0)
    write_frames(tmp_path, 2)
    (tmp_path / "depth" / "0000.png").write_bytes(b"no image")
    second = frames_of_sources([ilf.open_source(tmp_path)], reach=2)[1]
    reading = read_frame(second)
    assert (len(second.neighbours), len(reading.neighbours)) == (1, 0)


def _far(source, numbers):
    """Holes of these frames hold 65535."""
    for number in numbers:
        path = str(source / "depth" / f"{number:04}.png")
        depth = cv2.imread(path, cv2.IMREAD_UNCHANGED)
        cv2.imwrite(path, np.where(depth == 0, 65535, depth).astype(np.uint16))


def test_each_doubt_is_told_once(source, tmp_path, begun, cli):
    _far(source, [0, 1])
    command = ["batch", str(source), "--out", str(tmp_path / "out"), *FLAGS]
    for _ in range(2):  # the second time all frames are there already
        told = cli(*command)
        (line,) = told.err.splitlines()
        assert line.startswith("ilf: warning: rgb/0000: 65535 fills ")
        assert "2 frames with plausibility warnings" in told.out
    assert ["65535 fills" in row["plausibility_warnings"] for row in manifest(tmp_path / "out")] == [True, True, False]
    assert len(begun) == 3


def test_strict_batches_let_doubted_frames_fail(source, tmp_path, begun, capsys, cli):
    _far(source, [1])
    command = ["batch", str(source), "--out", str(tmp_path / "out"), *FLAGS, "--quiet"]
    assert "1 of 3 frames failed. rgb/0001: 65535 fills" in cli(*command, "--strict", status=1).err
    assert [row["status"] for row in manifest(tmp_path / "out")] == ["completed", "failed", "completed"]
    assert main([*command, "--invalid", "65535", "--strict", "--rerun-changed"]) == 0
    cli(*command, "--rerun-changed")
    assert main([*command, "--strict"]) == 1, "what was completed without it is an error, too"
    assert "1 of 3 frames failed. rgb/0001: 65535 fills" in capsys.readouterr().err


def test_info_of_a_folder_names_the_doubts_of_its_frames(source, cli):
    assert "warning" not in cli("info", source, "--strict").out
    _far(source, [1, 2])
    told = cli("info", source).out
    assert re.search(r"^warning: +rgb/0001: 65535 fills", told, re.MULTILINE)
    assert told.count("warning:") == 1
    assert "ilf: error: rgb/0001: 65535 fills" in cli("info", source, "--strict", status=1).err
    (source / "depth/0000.png").write_bytes(b"nothing")
    assert re.search(r"^problem: +rgb/0000: .*not a PNG", cli("info", source).out, re.MULTILINE)
