"""Speed of listing and reading sources: python -m tests.bench.sources [SOURCE...]

Without arguments, small recordings are written in the documented layouts, with images in the sizes of the devices.
Given sources (recordings, folders, data sets) are measured unchanged. Prints a line for each: processor time for
opening it, which lists its frames, and frames read and registered in turn per second.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

import ilf
from ilf.sources.opening import close_all
from tests.ilf.phone_files import Scene, colour, sens, write_arkit, write_nyu, write_record3d, write_stray

MAX_FRAMES = 30
COUNT = 20
PHONE, KINECT = (256, 192), (640, 480)

WRITTEN: dict[str, Callable[[Path], Path]] = {
    "Record3D, 960 x 720": lambda folder: write_record3d(folder / "a.r3d", Scene(PHONE, (960, 720), COUNT)),
    "Stray Scanner, 1920 x 1440, H.264": lambda folder: write_stray(folder / "s", Scene(PHONE, (1920, 1440), COUNT)),
    "ARKitScenes, 256 x 192": lambda folder: write_arkit(folder / "k", scene=Scene(PHONE, PHONE, COUNT)),
    "ARKitScenes, 1920 x 1440": lambda folder: write_arkit(folder / "w", "wide", Scene(PHONE, (1920, 1440), COUNT)),
    "ScanNet .sens, 1296 x 968 registered": lambda folder: _sens(folder / "a.sens"),
    "NYU labelled .mat, 640 x 480": lambda folder: write_nyu(folder / "a.mat", Scene(KINECT, KINECT, COUNT)),
    "folder of PNG, 640 x 480": lambda folder: _paired(folder / "png", ".png"),
    "folder of EXR, 640 x 480": lambda folder: _paired(folder / "exr", ".exr"),
    "folder of PFM, 640 x 480": lambda folder: _paired(folder / "pfm", ".pfm"),
}


def main(paths: list[str]) -> None:
    """Print the table."""
    print(f"{'source':40} {'origin':8} {'frames':>6} {'listing s':>9} {'frames/s':>8}")
    for path in paths:
        print(_line(Path(path).name, "given", Path(path)))
    if paths:
        return
    with tempfile.TemporaryDirectory() as folder:
        for name, write in WRITTEN.items():
            print(_line(name, "written", write(Path(folder))))
        close_all()


def _line(name: str, origin: str, path: Path) -> str:
    start = time.process_time()
    source = ilf.open_source(path)
    listing = time.process_time() - start
    source.read(source.keys[0])  # imports all modules
    keys = source.keys[:MAX_FRAMES]
    start = time.process_time()
    for key in keys:
        source.read(key)
    rate = len(keys) / (time.process_time() - start)
    return f"{name:40.40} {origin:8} {len(source):6} {listing:9.3f} {rate:8.1f}"


def _sens(path: Path) -> Path:
    path.write_bytes(sens(scene=Scene(KINECT, (1296, 968), COUNT)))
    return path


def _paired(folder: Path, suffix: str) -> Path:
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    mm = Scene(KINECT).mm.astype(np.uint16)
    for number in range(COUNT):
        cv2.imwrite(str(folder / "rgb" / f"{number}.png"), colour(number, KINECT))
        path = folder / "depth" / f"{number}{suffix}"
        if suffix == ".exr":
            _write_exr(path, mm / np.float32(1000))
        else:
            cv2.imwrite(str(path), mm if suffix == ".png" else mm / np.float32(1000))
    return folder


def _write_exr(path: Path, metres: np.ndarray) -> None:
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"Z": metres.astype(np.float32)}).write(str(path))


if __name__ == "__main__":
    main(sys.argv[1:])
