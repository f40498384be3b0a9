"""Writing a frame to a frame folder that `ilf.load_frame` reads."""

from __future__ import annotations

import json
import os
from pathlib import Path

from .._runtime.writing import write_bytes
from ..data.frame import RGBDFrame
from ..errors import ExportError, told_as
from ..io.depth import write_depth
from ..io.images import encode_image
from .naming import META_NAME

_COLOUR, _DEPTH = "rgb.png", "depth.tiff"


def new_frame_files(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """The files that `write_frame` writes: colour, depth and meta.json; raises ExportError if one exists."""
    paths = tuple(Path(folder) / name for name in (_COLOUR, _DEPTH, META_NAME))
    for path in paths:
        if path.exists():
            raise ExportError(f"{path} already exists. Choose another folder.")
    return paths


def write_frame(folder: str | os.PathLike[str], frame: RGBDFrame) -> tuple[Path, ...]:
    """Write a frame to a separate folder: rgb.png, depth.tiff (float32 [m], NaN = missing) and meta.json.

    Parameters
    ----------
    folder : path-like
        Created if missing; it must not contain a frame.
    frame : RGBDFrame
        Its measured depth is written, including invalid depth.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    ExportError
        If the folder already contains a frame, or a file cannot be written.
    """
    root, camera = Path(folder), frame.intrinsics
    meta = {
        "name": frame.name,
        "size": [frame.shape[1], frame.shape[0]],
        "depth_units_per_m": 1.0,
        "K": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy],
    }
    if frame.pose is not None:
        meta["pose"] = frame.pose.tolist()
    paths = new_frame_files(root)
    with told_as(ExportError, f"{root} cannot be created ({{error}}). Choose another folder.", OSError):
        root.mkdir(parents=True, exist_ok=True)
    write_bytes(paths[0], encode_image(".png", frame.rgb[..., ::-1]))
    write_depth(paths[1], frame.measured)
    write_bytes(paths[2], f"{json.dumps(meta, indent=2)}\n".encode())
    return paths
