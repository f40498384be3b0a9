"""
Glass: depth that is measured, but wrong
========================================

Depth cameras see through glass and measure what is behind it. Such depth looks plausible, and is used unless it is
marked invalid. Here, a bottle stands before a wall: only its cap and its label are measured.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.ndimage import binary_closing, binary_erosion

import ilf

rows, columns = np.mgrid[:180, :160]
half_width = np.where(rows < 70, 9, np.where(rows < 95, 9 + (rows - 70) * 0.8, 29))
across = (columns - 80) / half_width
bottle = (rows > 25) & (rows < 160) & (np.abs(across) < 1)
opaque = bottle & ((rows < 40) | ((rows > 105) & (rows < 135)))
truth = np.where(bottle, 0.80 - 0.03 * np.sqrt(np.clip(1 - across**2, 0, 1)), 1.1)
rgb = np.full((180, 160, 3), (186, 176, 160), np.uint8)
rgb[bottle] = (128, 170, 150)
rgb[opaque] = (190, 60, 50)

measured = np.where(bottle & ~opaque, 1.1, truth)  # through the glass: the wall
measured = measured + np.random.default_rng(0).normal(0, 0.002, truth.shape)
frame = ilf.RGBDFrame(rgb=rgb, depth=measured, ground_truth=truth, intrinsics=(300, 300, 79.5, 89.5), name="bottle")

# %%
# The object is selected by points on its parts, as by the tool *Smart select*, and seams between them are closed. What
# was measured through the glass is marked invalid, as by *Mark invalid*; cap and label keep their depth. The
# object becomes a block of its own, and its outline a drawn border, which no depth crosses.

parts = [(80, 32), (80, 60), (80, 98), (80, 120), (80, 150)]
whole = binary_closing(ilf.select_region(frame, inside=parts, outside=[(20, 90)]), iterations=2)
glass = whole & (frame.depth > 1.0)
blocks = ilf.extract_blocks(frame)
blocks[whole] = blocks.max() + 1
outline = whole & ~binary_erosion(whole)

before = ilf.complete(frame)
after = ilf.complete(frame.with_invalid_mask(glass), blocks, drawn=outline)

_, axes = plt.subplots(1, 4, figsize=(11, 3.4), layout="compressed")
images = {"colour": rgb, "measured": frame.depth, "marked invalid": after.frame.depth, "completed": after.depth}
for axis, (title, image) in zip(axes, images.items(), strict=True):
    axis.imshow(image, cmap="turbo", vmin=0.7, vmax=1.15)
    axis.set(xticks=[], yticks=[], title=title, facecolor="0.7")

# %%
# The error over the whole bottle:

for name, completion in {"taken as measured": before, "marked invalid": after}.items():
    error = ilf.evaluate_completion(frame, completion, bottle, every=True)
    print(f"{name}: RMSE {1000 * error.rmse:.0f} mm, median {1000 * error.median:.0f} mm")
