"""Complete generated pictures by the filter, to train the correction on.

    python assets/models/complete_pictures.py --data PICTURES --out FOLDER

PICTURES is what assets/samples/make_scenes.py has made. Two thirds of the pictures are first enlarged to twice their
size, so that the network sees what frames of 640 x 480 look like. Each becomes one NUMBER.npz with what the picture
has, but the colours of another camera, and less measured depth; and `completed`, float32 (H, W), that depth completed
[m], NaN = missing. It depends on its picture alone. Those that exist are kept, so that a training run may read the
folder while it grows.
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from ilf.run.run import complete
from ilf.completion.correction import UNCORRECTED
from ilf.data.frame import RGBDFrame
from ilf.lab.training.surfaces.pictures import random_colour, read_picture, with_hidden_depth
from ilf.segmentation.extraction import extract_blocks

SEED = 41
AS_IT_IS = 3
"""Every so many-th picture keeps its size."""


def make(path: Path, out: Path) -> None:
    """Complete a picture."""
    cv2.setNumThreads(1)
    number = int(path.stem)
    rng = np.random.default_rng((SEED, number))
    picture = read_picture(path)
    if number % AS_IT_IS:
        picture = picture.enlarged
    rgb = np.round(random_colour(picture.rgb, rng) * 255).astype(np.uint8)
    frame = RGBDFrame(rgb, with_hidden_depth(picture, rng))
    if not frame.known.any():
        return
    completed = complete(frame, extract_blocks(frame, detector="rgbd"), UNCORRECTED.replace(edges="rgbd"), threads=1).depth
    unfinished = out / f".{path.stem}.{os.getpid()}.npz"
    np.savez_compressed(
        unfinished,
        rgb=rgb,
        exact=picture.exact,
        measured=frame.depth,
        part=picture.part,
        object=picture.thing,
        jump=picture.lines[..., 0],
        crease=picture.lines[..., 1],
        completed=completed,
    )
    unfinished.replace(out / path.name)


def main() -> None:
    """Complete all pictures of a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of generated pictures, <number>.npz")
    parser.add_argument("--out", type=Path, required=True, help="folder of the completed ones")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="default: all cores (%(default)s)")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    paths = [path for path in sorted(arguments.data.glob("*.npz")) if not (arguments.out / path.name).exists()]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for done, _ in enumerate(pool.map(partial(make, out=arguments.out), paths, chunksize=4), 1):
            print(f"\r{done} of {len(paths)} pictures", end="", flush=True)
    print()


if __name__ == "__main__":
    main()
