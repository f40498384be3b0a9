"""Export of many frames: what is written, what is skipped as unchanged, and that one failure does not end it."""

import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf._runtime.long_work import cancelled_by
from ilf.cli import main
from ilf.data.blocks import BlockInfo
from ilf.project.exporting import ExportStatus, FrameToExport, export_frames
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import Project, ProjectFrame
from ilf.run.options import ExportOptions
from ilf.sources.frame_ref import FrameRef

from ..small_frames import CAMERA, QUICK, write_small_frame

OPTIONS = ExportOptions(depth_formats=("npy",), cloud=None, expected_error=False)


@pytest.fixture
def run(tmp_path):
    frame = ilf.load_frame(*write_small_frame(tmp_path / "room"), intrinsics=CAMERA)
    labels = np.tile(np.where(np.arange(80) < 40, 1, 2), (60, 1)).astype(np.int32)
    return ilf.Run(frame, labels, ilf.preset("paper", **QUICK))


def statuses(run: ilf.Run, folder: Path, options: ExportOptions = OPTIONS, completion=None) -> list[str]:
    frames = [FrameToExport("room", "room", lambda: (run, completion))]
    return [str(done.status) for done in export_frames(frames, folder, options)]


def test_frames_are_written_once_and_again_after_a_change(run, tmp_path):
    out = tmp_path / "out"
    assert statuses(run, out) == ["written"]
    assert np.array_equal(np.load(out / "room/depth.npy"), run.complete().depth, equal_nan=True)
    assert statuses(run, out) == statuses(run, out, completion=run.complete()) == ["unchanged"]
    other_blocks = np.where(run.blocks.labels == 2, 3, run.blocks.labels)
    for changed in (
        replace(run, parameters=run.parameters.replace(max_iterations=20)),
        run.with_parameters(run.parameters, {2: run.parameters.replace(max_iterations=20)}),
        replace(run, blocks=ilf.Blocks(other_blocks)),
        replace(run, extrapolate=True),
        replace(run, frame=run.frame.with_invalid_mask(run.blocks.labels == 2)),
    ):
        assert statuses(changed, out) == ["written"]
        assert statuses(changed, out) == ["unchanged"]
    assert statuses(run, out, replace(OPTIONS, curves=not OPTIONS.curves)) == ["written"]


def test_frames_whose_files_are_gone_or_changed_are_written_again(run, tmp_path):
    out = tmp_path / "out"
    assert statuses(run, out) == ["written"]
    (out / "room/blocks.png").unlink()
    assert statuses(run, out) == ["written"]
    (out / "room/depth.npy").write_bytes(b"")
    assert statuses(run, out) == ["written"]
    (out / "room/run.json").write_text("{}")
    assert statuses(run, out) == ["written"]
    assert statuses(run, out, replace(OPTIONS, run_record=False)) == ["written"]
    assert statuses(run, out, replace(OPTIONS, run_record=False)) == ["written"], "nothing to compare with"


def test_a_result_is_written_with_the_names_that_its_blocks_have_now(run, tmp_path):
    options, completion = replace(OPTIONS, exports=("labelme.json",)), run.complete()
    named = replace(run, blocks=replace(run.blocks, infos={1: BlockInfo("table", (250, 240, 10))}))
    assert statuses(named, tmp_path / "out", options, completion) == ["written"]
    assert '"table"' in (tmp_path / "out" / "room" / "blocks.labelme.json").read_text()
    assert statuses(named, tmp_path / "out", options, completion) == ["unchanged"]


def test_cancelling_ends_the_export_between_frames(run, tmp_path):
    event = threading.Event()
    with cancelled_by(event):
        frames = [FrameToExport(name, name, lambda: (run, None)) for name in ("one", "two")]
        export = export_frames(frames, tmp_path / "out", OPTIONS)
        assert next(export).status is ExportStatus.WRITTEN
        event.set()
        with pytest.raises(ilf.Cancelled):
            next(export)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["one"]


def test_the_command_completes_what_is_missing(run, tmp_path, capsys, cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rgb, depth = (str(tmp_path / "room" / name) for name in ("rgb.png", "depth.png"))
    results = run.complete().results
    state = FrameState("a1", run.frame, ilf.Blocks(run.blocks.labels), common=run.parameters, results={1: results[1]})
    frames = (ProjectFrame("a1", "room", None, has_state=True), ProjectFrame("c3", "bare", FrameRef(rgb, depth)))
    save_project("room.ilf", Project(frames, common=run.parameters), [state])
    assert [
        line.partition(",")[0]
        for line in cli("project", "export", "room.ilf", "--out", "out", "--complete").out.splitlines()
    ] == [
        "room: written",
        "bare: written",
    ]
    assert cli("project", "export", "room.ilf", "--out", "out", "--complete").out.count("unchanged") == 2
    Path(depth).unlink()
    assert main(["project", "export", "room.ilf", "--out", "out", "--complete"]) == 1
    assert "2 of 2 frames could not be exported" in capsys.readouterr().err
