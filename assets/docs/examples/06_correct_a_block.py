"""
Correct two surfaces in one block
=================================

Where a hole covers a weak edge, two surfaces can become one block, and depth flows from one to the other. A drawn
border divides them: no depth crosses it. In the window, the tool *Border* does this.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf

rows, columns = np.mgrid[:120, :160]
near = columns < 80
truth = np.where(near, 1.5, 1.9)
rgb = np.full((120, 160, 3), 140, np.uint8)  # the same colour on both sides: there is no edge to find
depth = truth.copy()
depth[20:100, 50:105] = np.nan
frame = ilf.RGBDFrame(rgb=rgb, depth=depth, ground_truth=truth, name="two panels")

merged = np.ones(frame.shape, np.int32)
divided = np.where(near, 1, 2)
border = np.zeros(frame.shape, bool)
border[:, 79:81] = True

before = ilf.complete(frame, merged)
after = ilf.complete(frame, divided, drawn=border)

_, axes = plt.subplots(1, 3, figsize=(12, 3.2), layout="compressed")
images = {"measured": frame.depth, "one block": before.depth, "two blocks, drawn border": after.depth}
for axis, (title, image) in zip(axes, images.items(), strict=True):
    axis.imshow(image, cmap="turbo", vmin=1.4, vmax=2.0)
    axis.set(xticks=[], yticks=[], title=title, facecolor="0.7")

# %%
# The errors of the filled pixels against the ground truth:

for name, completion in {"one block": before, "two blocks": after}.items():
    print(f"{name}: RMSE {1000 * ilf.evaluate_completion(frame, completion).rmse:.1f} mm")
