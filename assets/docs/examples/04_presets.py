"""
The presets, and how they converge
==================================

``paper`` follows the paper's text, ``released-code`` the authors' program, and ``best`` is an edge-aware filter with
a learned correction. All three complete the same blocks here.
"""

import matplotlib.pyplot as plt

import ilf
from ilf.cli import main

main(["sample", "room"])
frame = ilf.load_frame("room")
blocks = ilf.extract_blocks(frame)

completions = {name: ilf.complete(frame, blocks, name) for name in ("best", "paper")}
completions["released-code"] = ilf.complete(frame, blocks, "released-code", max_iterations=200)

_, axes = plt.subplots(1, 3, figsize=(12, 3.4), layout="compressed")
for axis, (name, completion) in zip(axes, completions.items(), strict=True):
    error = ilf.evaluate_completion(frame, completion)
    axis.imshow(completion.depth, cmap="turbo", vmin=2, vmax=4.5)
    axis.set(xticks=[], yticks=[], title=f"{name}: median error {1000 * error.median:.0f} mm")

# %%
# sigma_i is the deviation between two iterations. In ``paper``, the pass band grows whenever it falls below 5 mm,
# which gives the steps of the curve; it stops after the last one.

completions["paper"].plot_curves([1, 2, 3])

# %%
# ``best`` starts on a coarse grid, ends on the finest, and then cuts edges at the jumps it has found.

completions["best"].plot_curves([1, 2, 3])
