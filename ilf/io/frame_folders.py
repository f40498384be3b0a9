"""RGBDFrame -> a frame folder that `ilf.load_frame` reads."""

from __future__ import annotations

import json
import os
from pathlib import Path

from ..errors import ExportError, cause
from ..frame import RGBDFrame
from .atomic import write_bytes
from .depth_files import write_depth
from .frames import META_NAME
from .images import encode_image

_COLOUR, _DEPTH = "rgb.png", "depth.tiff"


def new_frame_files(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """The files that `write_frame` writes: colour, depth and meta.json; raises ExportError if one is there already."""
    paths = tuple(Path(folder) / name for name in (_COLOUR, _DEPTH, META_NAME))
    for path in paths:
        if path.exists():
            raise ExportError(f"{path} is there already. Choose another folder.")
    return paths


def write_frame(folder: str | os.PathLike[str], frame: RGBDFrame) -> tuple[Path, ...]:
    """Write a frame into a folder of its own: rgb.png, depth.tiff (float32 [m], NaN = missing) and meta.json.

    Parameters
    ----------
    folder : path-like
        Made if missing; it must not hold a frame yet.
    frame : RGBDFrame
        Its measured depth is written, distrusted depth included.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    ExportError
        If there is a frame in the folder already, or a file cannot be written.
    """
    root, camera = Path(folder), frame.intrinsics
    meta = {
        "name": frame.name,
        "size": [frame.shape[1], frame.shape[0]],
        "depth_units_per_m": 1.0,
        "K": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy],
    }
    paths = new_frame_files(root)
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{root} cannot be made ({cause(error)}). Choose another folder.") from error
    write_bytes(paths[0], encode_image(".png", frame.rgb[..., ::-1]))
    write_depth(paths[1], frame.measured)
    write_bytes(paths[2], f"{json.dumps(meta, indent=2)}\n".encode())
    return paths
