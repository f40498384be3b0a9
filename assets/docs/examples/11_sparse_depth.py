"""
A few hundred points
====================

Points of a map or lines of a lidar are sparse depth: less than 5 % of the pixels. ``best`` completes it with the same
call, and a second network corrects it.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main

main(["sample", "room"])
sample = ilf.load_frame("room")

kept = np.zeros(sample.shape, bool)
places = np.flatnonzero(sample.known)
kept.flat[np.random.default_rng(0).choice(places, 500, replace=False)] = True
points = ilf.RGBDFrame(
    rgb=sample.rgb,
    depth=np.where(kept, sample.depth, np.nan),
    ground_truth=sample.ground_truth,
    intrinsics=sample.intrinsics,
    name="500 points",
)
completion = ilf.complete(points)

_, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="compressed")
axes[0].imshow(points.rgb)
y, x = np.nonzero(kept)
axes[0].scatter(x, y, c=points.depth[kept], s=5, cmap="turbo", vmin=2, vmax=4.4)
axes[1].imshow(completion.depth, cmap="turbo", vmin=2, vmax=4.4)
for axis, title in zip(axes, ("500 points", "completed"), strict=True):
    axis.set(xticks=[], yticks=[], title=title)

# %%
# Lines, as of a lidar with 16 beams:

lines = ilf.RGBDFrame(
    rgb=sample.rgb,
    depth=np.where(np.arange(sample.shape[0])[:, None] % 30 == 0, sample.depth, np.nan),
    ground_truth=sample.ground_truth,
    intrinsics=sample.intrinsics,
    name="16 lines",
)
ilf.complete(lines).plot()

# %%
# The expected error has a model of its own for sparse depth.

for frame in (points, lines):
    completion = ilf.complete(frame)
    error = ilf.evaluate_completion(frame, completion, expected=ilf.expected_error(completion))
    print(f"{frame.name}: median error {1000 * error.median:.0f} mm, {error.within:.0%} within the expected error")
