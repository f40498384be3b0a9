"""Input frames of experiments: a folder of frames, an NYU labelled file, or the bundled sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from ..._runtime.installation import asset_path
from ...data.camera import CameraIntrinsics
from ...data.frame import RGBDFrame
from ...errors import InputError
from ...evaluation.bench.frames import HOLE_FILE, BenchFrame, as_measured, find_frames, load_bench_frame
from ...sources.frames import META_NAME
from ...sources.nyu import MAT_SUFFIX, SPLIT_FILE, NyuLabelled, frame_name, read_split
from .experiment import Settings

SAMPLE = "samples/room"
QUICK_FRAMES, _QUICK_EVERY = 3, 2

Item = TypeVar("Item")


@dataclass(frozen=True)
class FrameSource:
    """Location of one frame.

    Attributes
    ----------
    path : Path
        A frame folder, or an NYU labelled file.
    index : int or None
        Index of the frame in the file, from 0.
    name : str
    every : int
        Subsampling step of rows and columns.
    """

    path: Path
    index: int | None
    name: str
    every: int = 1


@dataclass(frozen=True)
class FrameSources:
    """Frames, with notes."""

    frames: tuple[FrameSource, ...]
    notes: tuple[str, ...]


def find_sources(settings: Settings) -> FrameSources:
    """Find the frames of the settings.

    Raises
    ------
    InputError
        If there are no frames, or a split is given without an NYU labelled file.
    FormatError
        If an NYU labelled file or its split cannot be read.
    """
    if settings.data is not None and settings.data.suffix.lower() == MAT_SUFFIX:
        frames, notes = _nyu(settings.data, settings.split)
    elif settings.split is not None:
        raise InputError("A split selects frames of nyu_depth_v2_labeled.mat. Give that file as the data.")
    elif settings.data is None:
        folder = asset_path(SAMPLE)
        frames = [FrameSource(folder, None, folder.name)]
        notes = [
            "Only the bundled sample was used, a generated room with a simulated sensor. For meaningful numbers, give "
            "a folder of frames or NYU Depth V2's labelled file as --data."
        ]
    else:
        frames, notes = _folders(settings.data)
    if settings.limit is not None:
        frames = frames[: settings.limit]
    if settings.quick:
        frames = [replace(frame, every=_QUICK_EVERY) for frame in spread(frames, QUICK_FRAMES)]
    return FrameSources(tuple(frames), tuple(notes))


def load_source(source: FrameSource) -> BenchFrame:
    """Read a frame, and its ground truth if it has one.

    For an NYU labelled file, the ground truth is the in-painted depth.

    Raises
    ------
    InputError, FormatError
        If the frame cannot be read.
    """
    if source.index is None:
        return _subsampled(load_bench_frame(source.path), source.every)
    with NyuLabelled(source.path) as labelled:
        frame = as_measured(labelled.frame(source.index))
        return _subsampled(BenchFrame(frame, labelled.filled(source.index)), source.every)


def _subsampled(whole: BenchFrame, every: int) -> BenchFrame:
    if every == 1:
        return whole
    frame, camera, part = whole.frame, whole.frame.intrinsics, slice(None, None, every)
    if camera is not None:
        camera = CameraIntrinsics(
            camera.fx / every, camera.fy / every, camera.cx / every, camera.cy / every, camera.name
        )
    thin = RGBDFrame(frame.rgb[part, part], frame.depth[part, part], camera, frame.name)
    return BenchFrame(thin, None if whole.ground_truth is None else whole.ground_truth[part, part])


def spread(items: Sequence[Item], count: int) -> list[Item]:
    """Return `count` items, evenly spread over all of them; all items if there are no more."""
    if len(items) <= count:
        return list(items)
    return [items[round(place * (len(items) - 1) / (count - 1))] for place in range(count)]


def _folders(path: Path) -> tuple[list[FrameSource], list[str]]:
    folders = find_frames([path])
    usable = [folder for folder in folders if any(folder.glob("depth.*")) or (folder / HOLE_FILE).is_file()]
    if not usable:
        raise InputError(f"No frame in {path} has raw depth (depth.*). Give frames with raw depth.")
    notes = []
    if len(usable) < len(folders):
        notes.append(
            f"{len(folders) - len(usable)} of {len(folders)} folders with {META_NAME} have no raw depth and are left "
            "out."
        )
    return [FrameSource(folder, None, folder.name) for folder in usable], notes


def _nyu(path: Path, split: Path | None) -> tuple[list[FrameSource], list[str]]:
    beside = path.with_name(SPLIT_FILE)
    chosen = split or (beside if beside.is_file() else None)
    with NyuLabelled(path) as labelled:
        count = len(labelled)
    indices = list(range(count)) if chosen is None else read_split(chosen)
    beyond = [index + 1 for index in indices if index >= count]
    if beyond:
        raise InputError(f"{chosen} lists frame {beyond[0]}, but {path} has {count}. Give the split of this file.")
    notes = [
        f"NYU Depth V2, {len(indices)} of {count} frames"
        + (f", selected by {chosen.name}." if chosen else f": all, because there is no {SPLIT_FILE} beside the file.")
        + " The ground truth in their own holes is the toolbox's in-painting, not a measurement."
    ]
    return [FrameSource(path, index, frame_name(index)) for index in indices], notes
