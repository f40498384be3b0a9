"""Files of one frame, in the format that the end of their name says."""

import json
from pathlib import Path
from typing import Any

import cv2
import h5py
import numpy as np
import OpenEXR


def write_file(path: Path, values: Any) -> Path:
    """Write bytes, a text, an array (colour as blue, green, red) or JSON, and its folders; fractions become units."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(values, bytes):
        path.write_bytes(values)
    elif isinstance(values, str):
        path.write_text(values)
    elif path.suffix == ".npy":
        np.save(path, values)
    elif path.suffix == ".npz":
        np.savez(path, **values)
    elif not isinstance(values, np.ndarray):
        path.write_text(json.dumps(values))
    elif path.suffix == ".txt":
        np.savetxt(path, values)
    elif path.suffix == ".exr":
        kind = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(kind, {"RGB": np.dstack([values.astype(np.float32)] * 3)}).write(str(path))
    elif path.suffix == ".hdf5":
        with h5py.File(path, "w") as file:
            file["dataset"] = values
    elif values.dtype.kind == "f" and path.suffix not in (".tif", ".tiff"):
        cv2.imwrite(str(path), np.rint(values).astype(np.uint16))
    else:
        cv2.imwrite(str(path), values)
    return path


def write_rgbd(folder: Path, depth: Any, name: str = "depth.png", colour: Any = None) -> tuple[Path, Path]:
    """Write rgb.png, which is grey in the shape that is given or that of depth, and depth; returns their paths."""
    if not isinstance(colour, np.ndarray):
        colour = np.full((*(colour or depth.shape[:2]), 3), 90, np.uint8)
    return write_file(folder / "rgb.png", colour), write_file(folder / name, depth)
