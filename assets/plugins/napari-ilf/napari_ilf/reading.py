"""Layers of a project, of the files of a run, and of a frame folder. Depth is float32 in metres, NaN = missing."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from napari.utils.notifications import show_warning
from numpy.typing import NDArray

import ilf
from ilf._runtime.files import read_file
from ilf._runtime.installation import asset_path
from ilf.drawing.colours import robust_depth_levels, robust_error_levels
from ilf.io.depth import read_depth
from ilf.project.exporting import run_and_completion
from ilf.run.options import ERROR_FILES
from ilf.sources.frame_ref import RECORD_FILE
from ilf.sources.naming import META_NAME

LayerData = tuple[Any, dict[str, Any], str]

INTRINSICS = "ilf_intrinsics"
"""Key in the metadata of a depth layer: its camera, if it is known."""


def get_reader(path: str | Sequence[str]) -> Callable[[str], list[LayerData]] | None:
    """Return what reads a path; None for other files, folders and stacks of several."""
    if not isinstance(path, str | os.PathLike):
        return None
    found = Path(path)
    if found.suffix.lower() == ".ilf":
        return project_layers
    if found.name == RECORD_FILE:
        return run_layers
    if (found / RECORD_FILE).is_file():
        return lambda folder: run_layers(os.path.join(folder, RECORD_FILE))
    if (found / META_NAME).is_file():
        return lambda folder: layers_of(ilf.load_frame(folder))
    return None


def project_layers(path: str) -> list[LayerData]:
    """Layers of the frames of a project with work on them; those of the frame that was opened last are visible."""
    layers = []
    with ilf.open_project(path) as opened:
        worked_on = [frame.id for frame in opened.project.frames if frame.has_state]
        if not worked_on:
            raise ilf.IlfError(f"{path} has no frame with work on it: open the folders of its frames.")
        shown = opened.project.present if opened.project.present in worked_on else worked_on[0]
        _warn(opened.problems)
        for frame_id in worked_on:
            decoded = opened.state(frame_id)
            _warn(decoded.problems)
            run, completion = run_and_completion(decoded.state)
            error = None if completion is None else ilf.expected_error(completion)
            depth = None if completion is None else completion.depth
            layers += layers_of(run.frame, depth, error, run.blocks.labels, visible=frame_id == shown)
    return layers


def run_layers(path: str) -> list[LayerData]:
    """Layers of the files of an export: the frame with its blocks, and the completed depth beside the record."""
    folder, replay = Path(path).parent, ilf.replay(path)
    _warn(replay.differences)
    written, options = replay.record.outputs, replay.options
    depth = ilf.load_frame(folder).depth if META_NAME in written else None
    error = None
    for depth_format, name in ERROR_FILES.items():
        if name in written:
            units = options.depth_units if depth_format == "png" else 1.0
            error = read_depth(read_file(folder / name), units).metres
    return layers_of(replay.run.frame, depth, error, replay.run.blocks.labels)


def sample_layers() -> list[LayerData]:
    """Layers of the bundled sample."""
    return layers_of(ilf.load_frame(asset_path("samples/room")))


def _warn(notes: Sequence[str]) -> None:
    for note in notes:
        show_warning(note)


def layers_of(
    frame: ilf.RGBDFrame,
    completed: NDArray[np.float32] | None = None,
    error: NDArray[np.float32] | None = None,
    blocks: NDArray[np.int32] | None = None,
    *,
    visible: bool = True,
) -> list[LayerData]:
    """Layers of a frame, in the order of drawing: colour, depth, completed depth, expected error (hidden), blocks."""
    name = frame.name
    layers: list[LayerData] = [(frame.rgb, {"name": f"{name} colour", "visible": visible}, "image")]
    layers.append(depth_layer(frame.depth, f"{name} depth", frame.intrinsics, visible=visible))
    if completed is not None:
        layers.append(depth_layer(completed, f"{name} completed", frame.intrinsics, visible=visible))
    if error is not None:
        layers.append(error_layer(error, f"{name} expected error", visible=False))
    if blocks is not None and blocks.any():
        layers.append((blocks, {"name": f"{name} blocks", "opacity": 0.4, "visible": visible}, "labels"))
    return layers


def depth_layer(depth: NDArray[np.float32], name: str, intrinsics: ilf.Camera | None, **how: Any) -> LayerData:
    """The layer of depth [m]."""
    levels = robust_depth_levels(depth)
    known = {} if intrinsics is None else {INTRINSICS: intrinsics}
    return depth, {"name": name, "colormap": "turbo", "contrast_limits": levels, "metadata": known, **how}, "image"


def error_layer(error: NDArray[np.float32], name: str, **how: Any) -> LayerData:
    """The layer of expected error [m]; NaN where nothing was filled."""
    return error, {"name": name, "colormap": "magma", "contrast_limits": robust_error_levels(error), **how}, "image"
