"""Make samples to train the correction network on: generated pictures, and what the filter makes of them.

    python assets/models/make_correction_samples.py --data PICTURES --out FOLDER

PICTURES is what assets/samples/make_scenes.py has made. Of every third picture one sample is made as it is; all others
are enlarged to twice their size, completed, and two details are cut out, so that the network sees what frames of
640 x 480 look like. Each sample is one NUMBER-K.npz: rgb uint8 (H, W, 3); known and completed depth float32 (H, W) [m],
NaN = missing; contours uint8 (H, W), strength times 255; exact float32 (H, W) [m]; lines uint8 (H, W, 2), jumps and
creases. A sample depends on its picture alone. Those that exist are kept, so that a training run may read the folder
while it grows.
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.completion.completion import complete
from ilf.completion.correction import UNCORRECTED
from ilf.completion.filter import edges_for
from ilf.data.frame import RGBDFrame
from ilf.lab.training.depth_edges.pictures import Picture, less_known, random_colour, read_picture
from ilf.segmentation.extraction import extract_blocks

SEED = 41
AS_IT_IS = 3
"""Every so many-th picture is."""

DETAILS, TRIED, STEP = 2, 12, 32
"""Details cut out of an enlarged picture, of so many places, which lie so many pixels apart."""

LEAST, MOST = 0.02, 0.98
"""Share of known depth within which there is something to learn."""

Window = tuple[slice, slice]


def make(path: Path, out: Path) -> None:
    """The samples of a picture."""
    cv2.setNumThreads(1)
    number = int(path.stem)
    rng = np.random.default_rng((SEED, number))
    picture = read_picture(path)
    if rng.random() < 0.5:
        picture = picture.mirrored
    height, width = picture.part.shape
    if number % AS_IT_IS:
        picture = picture.enlarged
    rgb = np.round(random_colour(picture.rgb, rng) * 255).astype(np.uint8)
    frame = RGBDFrame(rgb, less_known(picture, rng))
    if not frame.known.any():
        return
    completed = complete(frame, extract_blocks(frame), UNCORRECTED, threads=1).depth
    edges = edges_for(frame, UNCORRECTED)
    assert edges is not None
    windows = [(slice(None), slice(None))] if number % AS_IT_IS == 0 else details(frame, (height, width), rng)
    for k, window in enumerate(windows):
        if LEAST < frame.known[window].mean() < MOST:
            write(out / f"{number:06d}-{k}.npz", frame, completed, edges.detected, picture, window)


def details(frame: RGBDFrame, size: tuple[int, int], rng: np.random.Generator) -> list[Window]:
    """Of some windows those that hold most of both, known and missing depth."""
    rows, columns = (range(0, whole - side + 1, STEP) for whole, side in zip(frame.shape, size, strict=True))
    places = [(row, column) for row in rows for column in columns]
    rng.shuffle(places)
    windows = [(slice(row, row + size[0]), slice(column, column + size[1])) for row, column in places[:TRIED]]

    def worth(window: Window) -> float:
        known = frame.known[window].mean()
        return float(min(known, 1 - known, 0.3))

    return sorted(windows, key=worth, reverse=True)[:DETAILS]


def write(
    path: Path,
    frame: RGBDFrame,
    completed: NDArray[np.float32],
    contours: NDArray[np.float32],
    picture: Picture,
    window: Window,
) -> None:
    """One sample; it appears whole."""
    arrays: dict[str, NDArray[Any]] = {
        "rgb": frame.rgb[window],
        "depth": frame.depth[window],
        "completed": completed[window],
        "contours": np.round(255 * contours[window]).astype(np.uint8),
        "exact": picture.exact[window],
        "lines": picture.lines[window],
    }
    unfinished = path.with_suffix(".new")
    with unfinished.open("wb") as file:
        np.savez_compressed(file, **arrays)
    unfinished.replace(path)


def main() -> None:
    """Make samples of all pictures of a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of generated pictures, <number>.npz")
    parser.add_argument("--out", type=Path, required=True, help="folder of the samples")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="default: all cores (%(default)s)")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    paths = [
        path for path in sorted(arguments.data.glob("*.npz")) if not (arguments.out / f"{path.stem}-0.npz").exists()
    ]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for done, _ in enumerate(pool.map(partial(make, out=arguments.out), paths, chunksize=4), 1):
            print(f"\r{done} of {len(paths)} pictures", end="", flush=True)
    print()


if __name__ == "__main__":
    main()
