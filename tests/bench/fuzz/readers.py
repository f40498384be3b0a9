"""Readers of all formats, as in the program: they raise IlfError for refused files and fail on wrong results."""

import contextlib
import os
import shutil
from pathlib import Path

import numpy as np

import ilf
import ilf.batch.folder_sink
from gui.features.frame_list.thumbnails import read_thumbnail
from ilf._runtime.files import read_file
from ilf._runtime.networks.models import models_folder
from ilf.batch.folder_sink import FolderSink, unchanged
from ilf.batch.frames import frames_of_sources
from ilf.batch.settings import BatchSettings, differences, read_settings
from ilf.cli.facts import facts_of_record
from ilf.data.presets import list_presets
from ilf.errors import InputError
from ilf.evaluation.bench.frames import load_bench_frame
from ilf.io.block_files import read_blocks
from ilf.io.cameras import depth_place, intrinsics_from
from ilf.io.frame_additions import low_confidence, read_confidence
from ilf.io.heic import heic_orientation
from ilf.io.images import read_colour
from ilf.project.file import save_project
from ilf.project.recovery import copy_frames, find_recoverable_work
from ilf.project.state_codec import load_state
from ilf.run.data_sets import write_data_set
from ilf.run.record import read_record
from ilf.segmentation.edges.importing import add_model
from ilf.sources.frame_folder import camera_pose
from ilf.sources.frame_ref import FrameRef, ReadingOptions
from ilf.sources.listing import list_frames
from ilf.sources.opening import close_all
from ilf.sources.reading import read_frame, stamp_of

from .seeds import SHAPE


def depth(path: Path) -> None:
    frame = ilf.load_frame(path.parent / "rgb.png", path)
    assert np.isfinite(frame.depth[frame.known]).all()


def viewer_table(path: Path) -> None:
    """The table beside a depth image of the RealSense Viewer."""
    depth(path.parent / "depth.raw")


def dataset(path: Path) -> None:
    frame = ilf.load_frame(path.parent / "rgb.png", f"{path}:/left/depth")
    assert np.isfinite(frame.depth[frame.known]).all()


def colour(path: Path) -> None:
    ilf.load_frame(path, path.parent / "depth.png")


def photo(path: Path) -> None:
    read_colour(path)
    heic_orientation(read_file(path))


def thumbnail(path: Path) -> None:
    read_thumbnail(FrameRef(str(path), "depth.png"))


def folder(path: Path) -> None:
    frame = ilf.load_frame(path.parent)
    if frame.intrinsics is not None:
        points = ilf.point_cloud(frame.depth, frame.rgb, frame.intrinsics).points
        assert np.isfinite(points).all(), "points without a position"


def guide(path: Path) -> None:
    ilf.load_guide(path, SHAPE)


def layout(path: Path) -> None:
    """A layout of a stranger, on a folder with frames."""
    list_frames(path.parent, ReadingOptions(layout=str(path)))


def intrinsics(path: Path) -> None:
    intrinsics_from(path, SHAPE)
    depth_place(path, path)


def blocks(path: Path) -> None:
    found = read_blocks(path, SHAPE, image=path.parent / "rgb.png")
    assert found.labels.shape == SHAPE


def project(path: Path) -> None:
    with ilf.open_project(path) as opened:
        for frame in opened.project.frames:
            try:
                opened.state(frame.id)
            except ilf.IlfError:
                continue
        save_project(path.with_name("again.ilf"), opened.project, base=[opened.parts], places=opened.places)


def listed(path: Path) -> None:
    for source in list_frames(path.parent).sources[:2]:
        read_frame(source)


def trajectory(path: Path) -> None:
    camera_pose(path.parent / "depth" / "0.5.png")


def pose(path: Path) -> None:
    camera_pose(path.parent / "frame-000000.depth.png")


def network(path: Path) -> None:
    try:
        add_model(path, "fuzzed", replace=True)
    except ilf.IlfError:
        assert not (models_folder() / "fuzzed.onnx").exists(), "a refused network was written"
        raise
    (models_folder() / "fuzzed.onnx").unlink()


def recording(path: Path) -> None:
    try:
        source = ilf.open_source(path)
        for key in source.keys[:2]:
            source.read(key)
            source.pose(key)
    finally:
        close_all()


def folder_around(path: Path) -> None:
    recording(path.parent)


def arkit_camera(path: Path) -> None:
    recording(path.parent.parent)


def unregistered(path: Path) -> None:
    """A raw pair of a folder or recording."""
    try:
        source = ilf.open_source(path.parent)
        source.read_pair(source.keys[0])
    finally:
        close_all()


def names(path: Path) -> None:
    """Images with the names in a file: only the names determine which belong together."""
    folder = path.parent / "named"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for line in path.read_bytes().splitlines():
        parts = [part for part in line.split(b"/") if part not in {b"", b".", b".."}]
        if not parts:
            continue
        target = os.path.join(os.fsencode(folder), *parts)
        kind = "depth" if b"depth" in line or line.startswith(b"d-") else "rgb"
        with contextlib.suppress(OSError, ValueError):  # invalid file names
            os.makedirs(os.path.dirname(target), exist_ok=True)
            os.link(path.parent / f"{kind}.png", target)
    list_frames(folder)


def confidence(path: Path) -> None:
    depth = np.full(SHAPE, 2.0, np.float32)
    low_confidence(read_confidence(path, SHAPE), 1, depth)


def masks(path: Path) -> None:
    read_blocks(path.parent, SHAPE)


def presets(path: Path) -> None:
    """All presets of the user's folder, including this one."""
    _, problems = list_presets()
    if problems:
        raise InputError(problems[0])


def replayed(path: Path) -> None:
    """Replay of a recorded run."""
    again = ilf.replay(path)
    again.verdict(again.run.complete())


def result(path: Path) -> None:
    """A run's folder: summary, and export to another format."""
    record = read_record(path.parent / "run.json")
    facts_of_record(path.parent / "run.json")
    if record.inputs is not None:
        stamp_of(record.inputs)
    ilf.load_frame(path.parent)
    again = path.parent.parent / "again"
    shutil.rmtree(again, ignore_errors=True)
    write_data_set(again, [path.parent])


def bench_frame(path: Path) -> None:
    load_bench_frame(path.parent)


def batch(path: Path) -> None:
    """State of a batch from its folder."""
    folder = path.parent if path.name == "batch.json" else path.parent.parent
    before = read_settings(folder)
    if before is None:
        raise InputError("There are no settings.")
    differences(before[0], BatchSettings().facts())
    frames = frames_of_sources([ilf.open_source(folder.parent / "frames")])
    sha256 = (folder.parent / "sha256").read_text()
    sink = FolderSink(settings=BatchSettings(), folder=folder, sha256=sha256, levels=before[1], frames=tuple(frames))
    ilf.batch.folder_sink.run_in_processes = lambda work, items, **_: ((item, work(item)) for item in items)
    unchanged({frame: sink.record_of(frame) for frame in frames})
    sink.close()


def window(path: Path) -> None:
    from .window import read_settings  # creates a window

    read_settings(path)


def autosave(path: Path) -> None:
    """Work in a window's autosave."""
    folder = path.parent
    for file in (folder.parent / "sound").iterdir():
        if file.name != path.name:
            shutil.copy(file, folder)
    for left in find_recoverable_work(folder.parent):
        try:
            if left.problem:
                raise InputError(left.problem)
            copied = copy_frames([left.parts], {frame.id: frame.id for frame in left.read.project.frames})
            for frame in left.read.project.frames:
                load_state(frame.id, left.parts)
            for problem in copied.problems.values():
                raise InputError(problem)
        finally:
            left.release()
