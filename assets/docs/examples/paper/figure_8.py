"""
Figure 8: a spot as of a halogen lamp
=====================================

A halogen lamp blinds a depth sensor in a round spot, which the paper shows filled, in pictures only. Here, a spot of
15 cm is cut out of known, smooth depth, so that the error is known: once with the colour image as it is, and once with
colour that is saturated as by a lamp. Frames of your own: ``--frames FOLDER``.
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import griddata

import ilf
from ilf.cli import main

parser = argparse.ArgumentParser()
parser.add_argument("--frames", help="a folder of frames, a data set or a recording")
parser.add_argument(
    "--full", action="store_true", help="8 frames with all pixels, not 2 with every second row and column"
)
options = parser.parse_args()
every, count = (1, 8) if options.full else (2, 2)

# %%
# The place: depth is known all around and smooth, which is judged by its deviation from a quadric; of places about as
# smooth as the smoothest, the nearest.


def distance(shape: tuple[int, int], row: int, column: int) -> NDArray[np.float64]:
    """Return the distance of every pixel from a place [px]."""
    rows, columns = np.indices(shape)
    return np.hypot(rows - row, columns - column)


def find_spot(depth: NDArray[np.float32], focal: float) -> tuple[int, int, float] | None:
    """Return row, column and radius [px] of the spot; None if there is no place for one."""
    height, width = depth.shape
    step, found = max(2, width // 40), []
    for row, column in np.ndindex(height // step, width // step):
        row, column = step * (row + 1), step * (column + 1)
        if row >= height - step or column >= width - step or not np.isfinite(depth[row, column]):
            continue
        middle = float(depth[row, column])
        radius = focal * 0.15 / 2 / middle
        reach = int(np.ceil(1.3 * radius))
        around = depth[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1]
        y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1] / reach
        if radius < 4 or around.shape != y.shape or not np.isfinite(around[np.hypot(y, x) <= 1]).all():
            continue
        y, x, values = (part[np.hypot(y, x) <= 1].astype(np.float64) for part in (y, x, around))
        terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
        rough = values - terms @ np.linalg.lstsq(terms, values)[0]
        found.append((float(rough.std()) / middle, middle, row, column, radius))
    if not found:
        return None
    _, row, column, radius = min(place[1:] for place in found if place[0] <= 1.5 * min(found)[0])
    return row, column, radius


# %%
# The error in the spot, by the presets and by linear interpolation from its rim. Blocks are extracted from the frame
# with the spot.

if options.frames is None:
    main(["sample", "room"])
source = ilf.open_source(options.frames or "room")
methods = ("paper", "released-code", "best", "linear interpolation")
errors: dict[tuple[str, bool], list[float]] = {(name, glare): [] for name in methods for glare in (False, True)}
pictures = []
for place in sorted({round(place) for place in np.linspace(0, len(source) - 1, count)}):
    whole = source[place]
    rgb, depth = whole.rgb[::every, ::every], whole.depth[::every, ::every]
    spot = find_spot(depth, (whole.intrinsics.fx if whole.intrinsics else 0.82 * whole.shape[1]) / every)
    if spot is None:
        print(f"{whole.name}: no place of 15 cm with all its depth known")
        continue
    away = distance(depth.shape, spot[0], spot[1])
    hole = away <= spot[2]
    for glare in (False, True):
        light = np.clip((1.15 - away / spot[2]) / 0.3, 0, 1)[..., None] * glare
        seen = np.round((1 - light) * rgb + light * 255).astype(np.uint8)
        frame = ilf.RGBDFrame(rgb=seen, depth=np.where(hole, np.nan, depth), name=whole.name)
        blocks = ilf.extract_blocks(frame, detector="hed")
        for name in methods:
            filled: NDArray[np.floating]
            if name in ilf.PRESETS:
                filled = ilf.complete(frame, blocks, name).depth[hole]
            else:
                rim = (away > spot[2]) & (away <= spot[2] + 2)
                filled = griddata(np.argwhere(rim), depth[rim], np.argwhere(hole))
            errors[name, glare].append(1000 * float(np.sqrt(np.nanmean((filled - depth[hole]) ** 2))))
    pictures.append((whole.name, frame.rgb))
for name in methods:
    plain, lit = np.mean(errors[name, False]), np.mean(errors[name, True])
    print(f"{name}: RMSE in the spot {plain:.2f} mm, with glare {lit:.2f} mm, mean of {len(pictures)} frames")

# %%

_, axes = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
axes[0].imshow(pictures[0][1])
axes[0].set(xticks=[], yticks=[], title=f"{pictures[0][0]}, with glare")
for glare, marker in ((False, "o"), (True, "x")):
    places = np.repeat(np.arange(len(methods)), len(pictures)) + (0.12 if glare else -0.12)
    values = np.ravel([errors[name, glare] for name in methods])
    axes[1].plot(values, places, marker, label="with glare" if glare else "colour as it is")
axes[1].set_yticks(range(len(methods)), methods)
axes[1].set(xlabel="RMSE in the spot [mm]", xlim=(0, None))
axes[1].legend()
plt.show()
