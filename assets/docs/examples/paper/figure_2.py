"""
Figure 2: the iteration becomes steady
======================================

Figures 2 and 3 of the paper follow one block through the iteration by two curves: sigma_i, the deviation between two
iterations, and the L1 norm of the block. The iteration ends when sigma_i stays below 5 mm, after at most 1500
iterations. The paper's block is not published. Here it is the sofa of the bundled sample, a generated room whose exact
depth is known, so that the error is a third curve.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main

# %%
# The middle half of the sofa's columns is hidden, in addition to what the simulated sensor has missed.

main(["sample", "room"])
room = ilf.load_frame("room")
assert room.ground_truth is not None
blocks = ilf.extract_blocks(room, detector="hed")  # contours of the colour image, as in the paper
sofa = int(blocks[350, 560])
rows, columns = np.nonzero(blocks == sofa)
first, last = np.quantile(columns, (0.25, 0.75))
middle = (columns >= first) & (columns < last)
depth = room.depth.copy()
depth[rows[middle], columns[middle]] = np.nan
frame = ilf.RGBDFrame(rgb=room.rgb, depth=depth, intrinsics=room.intrinsics, name=room.name)
truth, missing = room.ground_truth[rows, columns], np.isnan(depth[rows, columns])
print(f"Block of {rows.size} pixels, {missing.mean():.1%} of them missing")

# %%
# Each record of `ilf.iterate` is one iteration; ``surface`` is the filtered block at that moment.

_, axes = plt.subplots(3, 3, figsize=(11, 7.5), sharex="col", layout="constrained")
for column, name in zip(axes.T, ("paper", "released-code", "best"), strict=True):
    stepper = ilf.iterate(frame, blocks, sofa, name)
    records, errors = [], []
    for record in stepper:
        records.append(record)
        errors.append(1000 * np.abs(stepper.surface - truth)[missing].mean())
    iterations = [record.i for record in records]
    column[0].semilogy(iterations, [1000 * record.sigma_i for record in records])
    column[0].axhline(5, color="0.5", linestyle="--", label="S_criteria")
    column[1].plot(iterations, [record.l1 for record in records])
    column[2].plot(iterations, errors)
    column[2].set_yscale("log" if max(errors) > 10 * min(errors) else "linear")
    column[0].set_title(name)
    column[2].set_xlabel("Iteration")
    print(
        f"{name}: {len(records)} iterations, last sigma_i {1000 * records[-1].sigma_i:.2f} mm, mean error of the hole"
    )
    print(
        f"    {errors[-1]:.1f} mm at the end, least {min(errors):.1f} mm at iteration {iterations[np.argmin(errors)]}"
    )
for axis, label in zip(axes[:, 0], ("sigma_i [mm]", "L1 norm [m]", "Mean error of the hole [mm]"), strict=True):
    axis.set_ylabel(label)
axes[0, 0].legend()

# %%
# ``paper`` follows the text: the pass band grows whenever the iteration is steady, and it ends at the last band, far
# below 1500 iterations. ``released-code``, the authors' program, lets the band grow a little at each of 1500. A small
# sigma_i means that the iteration is steady, not that the depth is right: it is below 1 mm at the end of all three,
# with errors of 72, 90 and 19 mm. ``best`` is this program's default, not the paper's method.

plt.show()
