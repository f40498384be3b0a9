"""
Guide the filter by a network's depth
=====================================

Networks estimate depth from colour: its shape is good, its scale is not. As a *guide*, such depth is fitted to the
known depth and followed as far as a hold-out of known depth gets better with it. Here, the guide is made from the
ground truth: inverse depth without scale, bent and blurred.
"""

import cv2
import numpy as np

import ilf
from ilf.cli import main

main(["sample", "room"])
sample = ilf.load_frame("room")

rows, columns = np.mgrid[: sample.shape[0], : sample.shape[1]]
inverse = (1 / np.nan_to_num(sample.ground_truth, nan=6.0)) ** 1.1 + 2e-5 * columns
guide = cv2.GaussianBlur(inverse.astype(np.float32), (0, 0), 1.5)

# %%
# Large areas of the sample are hidden, so that there is something to guide.

depth = sample.depth.copy()
for top, left in ((60, 90), (250, 380), (300, 60)):
    depth[top : top + 130, left : left + 160] = np.nan
frame = ilf.RGBDFrame(
    rgb=sample.rgb, depth=depth, ground_truth=sample.ground_truth, intrinsics=sample.intrinsics, name="large holes"
)

blocks = ilf.extract_blocks(frame)
without, guided = ilf.complete(frame, blocks), ilf.complete(frame, blocks, guide=guide)
for name, completion in {"without": without, "with a guide": guided}.items():
    error = ilf.evaluate_completion(frame, completion)
    print(f"{name}: median error {1000 * error.median:.1f} mm, RMSE {1000 * error.rmse:.0f} mm")

# %%
guided.plot()
