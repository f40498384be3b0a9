"""Make samples to train the correction network on: generated pictures and real frames, as the filter completes them.

    python assets/models/make_correction_samples.py --data PICTURES --frames FRAME... --out FOLDER

Of every frame (rgb.jpg, depth.png, meta.json) some measured depth is hidden, in several ways; one that is path traced
(meta.json's `sensor` begins with "rendered") is first measured by a simulated depth camera. PICTURES is what
assets/models/make_scenes.py has made. Of every third picture one sample is made as it is; all others are enlarged to
twice their size, completed, and two details are cut out, so that the network sees what frames of 640 x 480 look like.
Each sample is one NUMBER-K.npz: rgb uint8 (H, W, 3); known and completed depth float32 (H, W) [m], NaN = missing;
contours uint8 (H, W), strength times 255; exact float32 (H, W) [m]; lines uint8 (H, W, 2), jumps and creases, 255 = not
known. A sample depends on its picture or frame alone. Those that exist are kept, so that a training run may read the
folder while it grows.
"""

from __future__ import annotations

import argparse
import os
import sys
import zlib
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from recipes.contour_samples import SIDES
from recipes.correction_samples import UNKNOWN_LINES
from recipes.hiding import hide
from recipes.pictures import random_colour, read_picture, with_hidden_depth
from recipes.simulated import RENDERED, simulated

from ilf.completion.correction import UNCORRECTED
from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError
from ilf.evaluation.bench.frames import load_bench_frame
from ilf.run.run import complete
from ilf.segmentation.edges.frame_edges import edges_for
from ilf.segmentation.extraction import extract_blocks

SEED = 41
REAL, FROM_EACH = 900000, 4
"""Number of the first sample of real frames, and how many are made of each."""

AS_IT_IS = 3
"""Every so many-th picture is."""

DETAILS, TRIED, STEP = 2, 12, 32
"""Details cut out of an enlarged picture, of so many places, which lie so many pixels apart."""

LEAST, MOST = 0.02, 0.98
"""Share of known depth within which there is something to learn."""

Window = tuple[slice, slice]


def make_one(numbered: tuple[int, Path], out: Path) -> None:
    """The samples of a picture or a real frame with a number."""
    cv2.setNumThreads(1)
    (make_real if numbered[0] >= REAL else make)(*numbered, out)


def make(number: int, path: Path, out: Path) -> None:
    """The samples of a picture."""
    rng = np.random.default_rng((SEED, number))
    picture = read_picture(path)
    if rng.random() < 0.5:
        picture = picture.mirrored
    size = picture.part.shape
    if number % AS_IT_IS:
        picture = picture.enlarged
    rgb = np.round(random_colour(picture.rgb, rng) * 255).astype(np.uint8)
    frame = RGBDFrame(rgb, with_hidden_depth(picture, rng))
    write(out, number, frame, picture.exact, picture.lines, size if number % AS_IT_IS else None, rng)


def make_real(number: int, folder: Path, out: Path) -> None:
    """Samples of a measured or path-traced frame, with some of its measured depth hidden."""
    rng = np.random.default_rng((SEED, number))
    real = load_bench_frame(folder)
    rgb, exact = real.frame.rgb, real.frame.depth
    measured = simulated(real.frame, rng) if real.sensor.startswith(RENDERED) else exact
    if rng.random() < 0.5:
        rgb, exact, measured = (np.ascontiguousarray(one[:, ::-1]) for one in (rgb, exact, measured))
    rgb = np.round(random_colour(rgb, rng) * 255).astype(np.uint8)
    surfaces = extract_blocks(RGBDFrame(rgb, measured))
    while not (hidden := hide(measured, surfaces, rng)).any():
        pass
    frame = RGBDFrame(rgb, np.where(hidden, np.float32(np.nan), measured))
    write(out, number, frame, exact, np.full((*exact.shape, 2), UNKNOWN_LINES, np.uint8), SIDES, rng)


def details(frame: RGBDFrame, size: tuple[int, ...], rng: np.random.Generator) -> list[Window]:
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
    out: Path,
    number: int,
    frame: RGBDFrame,
    exact: NDArray[np.float32],
    lines: NDArray[np.uint8],
    size: tuple[int, ...] | None,
    rng: np.random.Generator,
) -> None:
    """The samples of a frame with true depth and lines: details of a size, or the whole; each file appears whole."""
    if not frame.known.any():
        return
    completed = complete(frame, extract_blocks(frame), UNCORRECTED, threads=1).depth
    edges = edges_for(frame, UNCORRECTED)
    assert edges is not None
    windows = [(slice(None), slice(None))] if size is None else details(frame, size, rng)
    for k, window in enumerate(windows):
        if not LEAST < frame.known[window].mean() < MOST:
            continue
        arrays: dict[str, NDArray[Any]] = {
            "rgb": frame.rgb[window],
            "depth": frame.depth[window],
            "completed": completed[window],
            "contours": np.round(255 * edges.probability[window]).astype(np.uint8),
            "exact": exact[window],
            "lines": lines[window],
        }
        path = out / f"{number:06d}-{k}.npz"
        unfinished = path.with_suffix(".new")
        with unfinished.open("wb") as file:
            np.savez_compressed(file, **arrays)
        unfinished.replace(path)


def main() -> int:
    """Make samples of all pictures of a folder, and of real frames; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of generated pictures, <number>.npz")
    parser.add_argument("--out", type=Path, required=True, help="folder of the samples")
    parser.add_argument("--frames", type=Path, nargs="*", default=[], help="folders of real frames")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="default: all cores (%(default)s)")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    numbered = [(int(path.stem), path) for path in sorted(arguments.data.glob("*.npz"))]
    numbered += [(REAL + k, folder) for k, folder in enumerate(FROM_EACH * arguments.frames)]
    missing = [(number, path) for number, path in numbered if not (arguments.out / f"{number:06d}-0.npz").exists()]
    # in an order of their numbers' hashes, so that those of all kinds are made from the beginning
    missing.sort(key=lambda one: zlib.crc32(str(one[0]).encode()))
    try:
        with ProcessPoolExecutor(arguments.jobs) as pool:
            for done, _ in enumerate(pool.map(partial(make_one, out=arguments.out), missing, chunksize=4), 1):
                print(f"\r{done} of {len(missing)} pictures", end="", flush=True)
    except IlfError as error:
        print(f"\nmake_correction_samples: error: {error}", file=sys.stderr)
        return 1
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
