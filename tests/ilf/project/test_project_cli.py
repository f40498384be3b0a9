"""`ilf project` on the command line."""

import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.data.blocks import Blocks
from ilf.project.file import open_project, save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.project.run_history import StoredRun
from ilf.run.run import Run
from ilf.sources.frame_ref import FrameRef

from ..small_frames import CAMERA, QUICK, write_small_frame


@pytest.fixture
def project(tmp_path, monkeypatch):
    """room.ilf with two frames of the same name that have been run, and one that nobody has touched."""
    monkeypatch.chdir(tmp_path)
    rgb, depth = map(str, write_small_frame(tmp_path / "room"))
    run = Run.of(ilf.load_frame(rgb, depth, intrinsics=CAMERA), preset=ilf.preset(**QUICK), extrapolate=True)
    completion = run.complete()
    kept = StoredRun(
        1, "quick", run, completion.results, 0.5, (0, 0, 0), ground_truth_error=0.0123, hold_out_error=np.nan
    )
    common = ilf.preset("paper")  # set since
    states = [
        FrameState(name, run.frame, Blocks(run.blocks.labels), common=common, results=completion.results, runs=(kept,))
        for name in ("a1", "b2")
    ]
    frames = [ProjectFrame(state.id, "room", None, FrameSummary(Stage.RUN, blocks=2), True) for state in states]
    frames.append(ProjectFrame("c3", "bare", FrameRef(rgb, depth)))
    save_project("room.ilf", Project(tuple(frames)), states)
    return tmp_path / "room.ilf", states


def test_a_new_project_has_the_frames_of_folders_or_two_files(tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        write_small_frame(tmp_path / "all" / name)
    assert main(["project", "new", "all.ilf", "all", "--intrinsics", CAMERA]) == 0
    assert "1 frame." in cli("project", "new", "one.ilf", "all/one/rgb.png", "all/one/depth.png", "--embed").out
    (tmp_path / "all").rename("moved")
    with open_project("all.ilf") as opened:
        assert [frame.name for frame in opened.project.frames] == ["one", "two"]
        assert opened.project.frames[0].source.options.intrinsics == CAMERA
    with open_project("one.ilf") as opened:
        assert opened.state(opened.project.frames[0].id).state.frame.shape == (60, 80)
    assert "already exists" in cli("project", "new", "all.ilf", "moved", status=1).err
    assert main(["project", "new", "x.zip", "moved"]) == 2
    assert main(["project", "new", "x.ilf", "moved", "moved/one/rgb.png"]) == 2


def test_info_tells_of_frames_runs_and_what_is_wrong(project, cli):
    path, _ = project
    out = cli("project", "info", path).out
    assert "3: 1 untouched, 2 run" in out
    assert "12.30" in out
    assert "per frame; defaults of the next frame: " in out
    assert "problem" not in out
    (path.parent / "room" / "depth.png").rename(path.parent / "gone.png")
    told = json.loads(cli("project", "info", path, "--json").out)
    assert sorted(told["frames"][0]["sources"].values()) == ["missing", "present"]
    assert told["frames"][0]["runs"][0]["hold_out_error"] is None
    assert told["frames"][2]["stage"] == "untouched"
    path.write_bytes(path.read_bytes()[:-100])
    assert "truncated" in cli("project", "info", path).out
    assert main(["project", "info", "none.ilf"]) == 1


def test_export_writes_what_is_stored_and_it_replays(project, cli):
    path, states = project
    assert main(["project", "export", str(path), "--out", "out"]) == 0
    for folder in ("room", "room-b2"):
        depth = np.load(path.parent / "out" / folder / "depth.npy")
        for result in states[0].results.values():
            np.testing.assert_array_equal(depth[result.block.box][result.block.mask], result.depth)
    assert "identical to the recorded one" in cli("complete", "--replay", "out/room/run.json", "--out", "again").out
    chosen = ["--frame", "a1", "--no-cloud", "--mesh", "glb", "--depth-formats", "tiff"]
    assert main(["project", "export", str(path), "--out", "chosen", *chosen]) == 0
    names = {file.name for file in (path.parent / "chosen" / "room").iterdir()}
    assert {"mesh.glb", "depth.tiff"} < names
    assert not {"cloud.ply", "depth.npy"} & names
    assert main(["project", "export", str(path), "--out", "out", "--frame", "c3"]) == 1
    assert "has no frame 'nobody'" in cli("project", "export", path, "--out", "out", "--frame", "nobody", status=1).err


def test_a_frame_that_cannot_be_read_is_named_and_the_others_are_exported(project, capsys, cli):
    path, _ = project
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (parts | {"frames/b2.json": parts["frames/b2.json"][:-9]}).items():
            archive.writestr(name, content)
    assert main(["project", "export", str(path), "--out", "out"]) == 0
    assert [folder.name for folder in (path.parent / "out").iterdir()] == ["room"]
    assert "cannot be read" in capsys.readouterr().err
    assert main(["project", "export", str(path), "--out", "out", "--frame", "b2"]) == 1
    assert "cannot be read" in cli("project", "info", path).out


def test_replay_says_whether_the_stored_results_come_out(project, cli):
    path, states = project
    assert "bit for bit" in cli("project", "replay", path, "--frame", "a1").out
    result = states[1].results[1]
    other = replace(result, depth=result.depth + np.float32(0.5))
    changed = replace(states[1], results={**states[1].results, 1: other})
    with open_project(path) as opened:
        save_project(path, opened.project, [changed], base=[opened.parts], places=opened.places)
    told = cli("project", "replay", path, status=1)
    assert "differs from the recorded one by up to 5.0e-01 m" in told.out
    assert "1 of 2 frames differ" in told.err


def test_frames_are_looked_for_where_it_is_said(project, tmp_path, cli):
    path, _ = project
    (tmp_path / "room").rename(tmp_path / "elsewhere")
    assert main(["project", "replay", str(path), "--frame", "a1"]) == 1
    assert main(["project", "replay", str(path), "--frame", "a1", "--look-in", "elsewhere"]) == 0
    (tmp_path / "elsewhere" / "rgb.png").write_bytes(b"another picture")
    assert "changed" in cli("project", "replay", path, "--frame", "a1", "--look-in", "elsewhere", status=1).err
