"""Measure path-traced frames with simulated depth cameras, to see what methods make of holes as sensors leave them.

    python assets/models/make_measured_frames.py FRAMES... --out FOLDER
    ilf bench FOLDER --pattern ground-truth

FRAMES are folders of frames, or folders of such folders; those whose `sensor` in meta.json begins with "rendered" are
taken, two of each place (the name up to its last "_"). In FOLDER each has its colour, depth.png (measured) and gt.png
(exact) in mm. The camera of a frame depends on its name alone.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from recipes.simulated import RENDERED, simulated

from ilf.errors import IlfError
from ilf.evaluation.bench.frames import BenchFrame, find_frames, load_bench_frame
from ilf.io.images import encode_image

SEED = 3011
OF_A_PLACE = 2
MM = 1000.0
FARTHEST = 65.0
"""Depth [m] beyond which there is none in the files, which end at 65.535 m."""


def chosen(folders: list[Path]) -> list[tuple[Path, BenchFrame]]:
    """Path-traced frames, `OF_A_PLACE` of each place, apart in its list."""
    places: dict[str, list[tuple[Path, BenchFrame]]] = {}
    for folder in folders:
        frame = load_bench_frame(folder)
        if frame.sensor.startswith(RENDERED):
            places.setdefault(folder.name.rpartition("_")[0], []).append((folder, frame))
    return [one for of in places.values() for one in of[:: max(1, len(of) // OF_A_PLACE)][:OF_A_PLACE]]


def write(folder: Path, frame: BenchFrame, out: Path) -> None:
    """Write a frame as a camera measures it, and its exact depth."""
    rng = np.random.default_rng((SEED, zlib.crc32(folder.name.encode())))
    place = out / folder.name
    place.mkdir(parents=True, exist_ok=True)
    (colour,) = folder.glob("rgb.*")
    shutil.copy(colour, place)
    (place / "depth.png").write_bytes(encode_image(".png", in_mm(simulated(frame.frame, rng))))
    (place / "gt.png").write_bytes(encode_image(".png", in_mm(frame.frame.depth)))
    camera = frame.frame.intrinsics
    assert camera is not None
    stated = {"name": folder.name, "size": frame.frame.shape[::-1], "depth_units_per_m": MM, "sensor": frame.sensor}
    (place / "meta.json").write_text(json.dumps(stated | {"K": [camera.fx, camera.fy, camera.cx, camera.cy]}))


def in_mm(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Depth [m] as in 16-bit files, 0 = missing."""
    there = depth < FARTHEST
    return np.where(there, np.round(MM * np.where(there, depth, 0)), 0).astype(np.uint16)


def main() -> int:
    """Measure all frames; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", type=Path, nargs="+", help="folders of path-traced frames")
    parser.add_argument("--out", type=Path, required=True, help="folder of the measured frames")
    arguments = parser.parse_args()
    try:
        for folder, frame in chosen(find_frames(arguments.frames)):
            write(folder, frame, arguments.out)
            print(folder.name, flush=True)
    except IlfError as error:
        print(f"make_measured_frames: error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
