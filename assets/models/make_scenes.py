"""Make pictures of random scenes with exact and measured depth, to train the networks on.

    python assets/models/make_scenes.py --out FOLDER --count 1000 --seed 1

Writes one NNNNNN.npz a picture: rgb uint8 (H, W, 3); exact and measured float32 (H, W) [m], NaN where there is
nothing and where the sensor gave nothing; normals float16 (H, W, 3) in camera coordinates; part int32 (H, W), the
smooth surface seen; object int32 (H, W), the object that this surface belongs to (a wall or a floor is one too), -1
where there is nothing; jump and crease uint8 (H, W), lines 1 px wide; K float32 (fx, fy, cx, cy). A picture depends on
the seed and its number alone. Those that exist are kept, and each appears whole, so that a training run may read the
folder while it grows.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from scenes.labels import label
from scenes.layouts import LAYOUTS
from scenes.scenes import picture
from scenes.sensing import sense

SIZE = (320, 256)


def record(seed: int, number: int, size: tuple[int, int] = SIZE, kinds: Sequence[str] = ()) -> dict[str, np.ndarray]:
    """The arrays of one picture."""
    taken, rng = picture(seed, number, size, kinds)
    intrinsics = np.array(taken.intrinsics, np.float32)
    measured = sense(taken.exact, taken.normals, taken.rgb, taken.flags, taken.behind, taken.unlit, intrinsics, rng)
    jump, crease = label(taken.exact, taken.normals, taken.part, intrinsics)
    return {
        "rgb": taken.rgb,
        "exact": taken.exact,
        "measured": measured,
        "normals": taken.normals.astype(np.float16),
        "part": taken.part,
        "object": taken.object,
        "jump": jump,
        "crease": crease,
        "K": intrinsics,
    }


def write(out: Path, seed: int, size: tuple[int, int], kinds: Sequence[str], number: int) -> None:
    """Write one picture into a folder, unless it is there."""
    path = out / f"{number:06d}.npz"
    if path.exists():
        return
    made = record(seed, number, size, kinds)
    unfinished = out / f".{number:06d}.{os.getpid()}.npz"
    np.savez(unfinished, **made)
    unfinished.replace(path)


def _size(text: str) -> tuple[int, int]:
    width, height = (int(number) for number in text.lower().split("x"))
    return width, height


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", type=int, default=0, help="number of the first picture")
    parser.add_argument("--size", type=_size, default=SIZE, metavar="WxH")
    names = [layout.__name__ for layout, _ in LAYOUTS]
    parser.add_argument("--kinds", nargs="+", choices=names, default=(), help="of scene (default: all)")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    numbers = range(options.start, options.start + options.count)
    one = partial(write, options.out, options.seed, options.size, options.kinds)
    if options.jobs == 1:
        for number in numbers:
            one(number)
        return
    with ProcessPoolExecutor(options.jobs) as pool:
        for _ in pool.map(one, numbers, chunksize=4):
            pass


if __name__ == "__main__":
    main()
