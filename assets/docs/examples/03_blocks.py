"""
Blocks, large and small
=======================

Depth never crosses the border of a block. *Granularity* sets how finely colour and depth are divided; a block needs
some known depth, and should contain one surface.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main
from ilf.drawing.blocks import block_overlay

main(["sample", "room"])
frame = ilf.load_frame("room")

# %%
# A label map is an integer array, 0 = no block. `ilf.Run` shows it over the colour.

_, axes = plt.subplots(1, 3, figsize=(12, 3.4), layout="compressed")
for axis, granularity in zip(axes, (0.1, 0.5, 0.9), strict=True):
    blocks = ilf.extract_blocks(frame, granularity=granularity)
    axis.imshow(block_overlay(frame.rgb, blocks))
    axis.set(xticks=[], yticks=[], title=f"granularity {granularity}: {blocks.max()} blocks")

# %%
# Blocks can be edited as an array. Here, an object is selected by a point on it and becomes a block of its own.

blocks = ilf.extract_blocks(frame)
vase = ilf.select_region(frame, inside=[(350, 322)])
blocks[vase] = blocks.max() + 1
print(np.count_nonzero(vase), "pixels selected")
ilf.Run.of(frame, blocks).plot()
