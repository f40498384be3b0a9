"""Recognition of depth encodings: python -m tests.bench.encodings FOLDER...

The depth of every frame folder is read by its meta.json, stored again in every encoding that can be recognised, and
read without the encoding. Prints a line for each frame, and the number of recognised encodings; unchanged depth must
not cause a plausibility warning.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.io.depth import read_depth_values
from ilf.io.depth_reading import PlausibilityWarning, plausibility_warnings_of
from ilf.io.encodings import DepthEncoding, encoding_of
from ilf.sources.frames import frame_folder

NOTHING_SEEN = 2047


def stored(metres: NDArray[np.float32]) -> dict[str, NDArray[np.uint16]]:
    """Return depth [m] in the values of each encoding, by the encoding that should be proposed."""
    known = np.isfinite(metres)
    depth = np.where(known, metres, 1)
    mm = np.where(known, np.rint(1000 * depth), 0).astype(np.uint16)
    disparity = np.where(known, np.rint(1092.5 - 351.3 / depth).clip(0), NOTHING_SEEN).astype(np.uint16)
    return {
        **{str(mark): np.where(known, mm, mark).astype(np.uint16) for mark in (8191, 10_000, 65535)},
        "kitti": np.where(known, np.rint(256 * depth), 0).astype(np.uint16),
        "sun": (mm << 3) | (mm >> 13),
        "mm-swapped": mm.byteswap(),
        "nyu-raw": disparity.byteswap(),
        "kinect-raw": disparity,
    }


def main(folders: list[str]) -> None:
    """Print the table."""
    right, frames = Counter[str](), 0
    for folder in folders:
        try:
            files = frame_folder(folder)
        except Exception as error:
            print(f"{Path(folder).name}: skipped ({error})")
            continue
        frames += 1
        values, own = read_depth_values(files.depth), encoding_of(files.options.depth_encoding or 1000.0)
        found = {"plain": _proposed(_doubts(values, own)) or "plain"}
        metres = own.metres(values)
        for name, file in stored(metres).items():
            found[name] = _proposed(_doubts(file, encoding_of("mm")))
        for name, product in (("inverse depth", 1.0), ("disparity", 52.5)):
            found[name] = _proposed(_doubts(np.nan_to_num(product / metres), encoding_of("m"))).replace("?", name)
        right.update(name for name, what in found.items() if what == name)
        wrong = {name: what for name, what in found.items() if what != name}
        print(f"{files.name}: {wrong or 'all recognised'}")
    print(", ".join(f"{name} {count} of {frames}" for name, count in right.items()))


def _doubts(values: NDArray[Any], encoding: DepthEncoding) -> tuple[PlausibilityWarning, ...]:
    return plausibility_warnings_of(values, encoding.metres(values), encoding, is_named=False)


def _proposed(plausibility_warnings: tuple[PlausibilityWarning, ...]) -> str:
    return ",".join(
        doubt.encoding or ("?" if doubt.invalid is None else f"{doubt.invalid:.9g}") for doubt in plausibility_warnings
    )


if __name__ == "__main__":
    main(sys.argv[1:])
