"""
How far the expected error can be trusted
=========================================

The expected error is calibrated over many frames, not in each. With a ground truth, one frame can be checked: which
share of the true errors lies within it, and whether large expected errors are large errors.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main

main(["sample", "room"])
frame = ilf.load_frame("room")
completion = ilf.complete(frame)

expected = ilf.expected_error(completion)  # metres, NaN where nothing was filled
unsupported = ilf.unsupported(completion)  # where no measurement supports the depth
true = np.abs(completion.depth - frame.ground_truth)
judged = completion.filled & np.isfinite(true)
print(f"all filled pixels: {np.mean(true[judged] <= expected[judged]):.0%} within the expected error")
judged &= ~unsupported
print(f"supported pixels: {np.mean(true[judged] <= expected[judged]):.0%}")

# %%
# Pixels sorted by their expected error, in ten groups of the same size: the true error rises with the expected one.

order = np.argsort(expected[judged])
groups = [(np.median(expected[judged][part]), np.median(true[judged][part])) for part in np.array_split(order, 10)]
x, y = 1000 * np.transpose(groups)
_, axis = plt.subplots(figsize=(5, 4), layout="constrained")
axis.loglog(x, y, "o-")
axis.loglog(x, 0.67 * x, "--", color="0.6", label="as expected, if errors are normally distributed")
axis.set(xlabel="Expected error [mm]", ylabel="Median of the true error [mm]")
axis.legend()

# %%
# Depth that is good enough for a purpose: keep what is supported and expected to be within 2 cm.

good = frame.known | (judged & (expected < 0.02))
print(f"{frame.known.mean():.1%} measured, {good.mean():.1%} measured or good enough")
kept = np.where(good, completion.depth, np.nan)
ilf.RGBDFrame(rgb=frame.rgb, depth=kept, name="good enough").plot()
