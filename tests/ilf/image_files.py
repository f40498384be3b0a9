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


def write_pair(folder: Path, depth: Any, name: str = "depth.png", colour: Any = (48, 64)) -> tuple[Path, Path]:
    """Write rgb.png, grey where only its shape is given, and depth; returns their paths."""
    grey = np.full((*colour, 3), 90, np.uint8) if isinstance(colour, tuple) else colour
    return write_file(folder / "rgb.png", grey), write_file(folder / name, depth)
