"""
Frames from your own arrays
===========================

Any colour and depth arrays of one size are a frame: a slanted wall behind a box, with a hole that both share.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf

rows, columns = np.mgrid[:120, :160]
box = (rows > 45) & (rows < 100) & (columns > 50) & (columns < 110)
truth = np.where(box, 1.2, 2.0 + 0.004 * columns)
rgb = np.where(box[..., None], (200, 120, 40), (90, 130, 150)).astype(np.uint8)

depth = truth + np.random.default_rng(0).normal(0, 0.003, truth.shape)
depth[60:85, 25:75] = np.nan  # NaN and 0 mean missing; values are in metres

frame = ilf.RGBDFrame(rgb=rgb, depth=depth, ground_truth=truth, name="box", intrinsics=(150, 150, 79.5, 59.5))
completion = ilf.complete(frame)
completion.plot()

# %%
# Depth along a row through the hole: the box ends where its colour ends, and the slope of the wall continues.

row = 72
_, axis = plt.subplots(figsize=(8, 3.2), layout="constrained")
axis.plot(truth[row], color="0.6", linewidth=4, label="ground truth")
axis.plot(frame.depth[row], ".", label="measured")
axis.plot(np.where(completion.filled, completion.depth, np.nan)[row], "-", color="tab:red", label="filled")
axis.set(xlabel="Column [px]", ylabel="Depth [m]")
axis.legend()

# %%
# With a ground truth, the errors of the filled pixels are known, in metres.

print(ilf.evaluate_completion(frame, completion))
