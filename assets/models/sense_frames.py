"""Simulate depth cameras on path-traced frames, so that networks learn from noise and holes, too.

    python assets/models/sense_frames.py FRAME... --out FOLDER

FRAME is a folder with rgb.jpg or rgb.png, exact depth.png, and meta.json with `rendered`, `K` and `depth_units_per_m`.
FOLDER gets a folder of the same name for each: the colour image, depth.png as a camera of `scenekit.sensing`, drawn at
random, measures it, and gt.png, the exact depth. Other frames are left out.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "samples"))
from scenekit.sensing import sense

UNITS = 1000.0
"""Depth units per metre of the files."""


def sensed(rgb: np.ndarray, exact: np.ndarray, K: list[float], rng: np.random.Generator) -> np.ndarray:
    """Depth [m] as a camera measures a frame of exact depth [m], NaN = missing in both."""
    nothing = np.zeros(exact.shape, bool)
    flags = dict.fromkeys(("black", "glossy", "transparent", "emitting"), nothing)
    return sense(exact, normals(exact, K), rgb, flags, np.full_like(exact, np.nan), nothing, tuple(K), rng)


def normals(exact: np.ndarray, K: list[float]) -> np.ndarray:
    """Normals in camera coordinates from differences of neighbours; towards the camera where depth is missing."""
    fx, fy, cx, cy = K
    rows, columns = np.indices(exact.shape, np.float32)
    points = np.dstack([(columns - cx) / fx * exact, (rows - cy) / fy * exact, exact])
    found = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
    length = np.linalg.norm(found, axis=2, keepdims=True)
    certain = np.isfinite(length) & (length > 0)
    return np.where(certain, found / np.where(certain, length, 1), np.array([0, 0, 1])).astype(np.float32)


def main() -> None:
    """Write the frames as cameras measure them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    for folder in arguments.frames:
        meta = json.loads((folder / "meta.json").read_text())
        if not meta.get("rendered"):
            continue
        colour = next(folder.glob("rgb.*g"))
        stored = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED)
        exact = np.where(stored > 0, stored / np.float32(meta["depth_units_per_m"]), np.nan).astype(np.float32)
        rng = np.random.default_rng(zlib.crc32(folder.name.encode()))
        rgb = cv2.cvtColor(cv2.imread(str(colour)), cv2.COLOR_BGR2RGB)
        depth = sensed(rgb, exact, meta["K"], rng)
        out = arguments.out / folder.name
        out.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(colour, out / colour.name)
        for name, values in (("depth.png", depth), ("gt.png", exact)):
            whole = np.clip(np.round(np.nan_to_num(values) * UNITS), 0, np.iinfo(np.uint16).max)
            cv2.imwrite(str(out / name), whole.astype(np.uint16))
        named = {**meta, "depth_units_per_m": UNITS, "gt_units_per_m": UNITS, "gt": "exact", "sensor": "simulated"}
        (out / "meta.json").write_text(json.dumps(named, indent=1))


if __name__ == "__main__":
    main()
