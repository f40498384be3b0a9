"""
Choose a parameter by hold-out
==============================

Without a ground truth, known depth is hidden by a pattern, completed, and compared. *Areas* are holes as large as
those of cameras. The window does the same by *Run > Sweep a parameter*, the command line by ``ilf evaluate room
--hold-out areas --sweep slope_weight=0.001,0.03,1``.
"""

import matplotlib.pyplot as plt

import ilf
from ilf.cli import main

main(["sample", "room"])
frame = ilf.load_frame("room")
blocks = ilf.extract_blocks(frame)

test = ilf.HoldOutTest("areas", seeds=(0, 1))
values = (0.001, 0.03, 1.0, 30.0, 300.0)
results = [ilf.evaluate_hold_out(ilf.Run.of(frame, blocks, slope_weight=value), test) for value in values]

_, axis = plt.subplots(figsize=(6, 3.4), layout="constrained")
for name in ("rmse", "mae", "median"):
    axis.loglog(values, [1000 * getattr(result.whole, name) for result in results], "o-", label=name)
axis.set(xlabel="Slope weight (default 0.03)", ylabel="Error on hold-out [mm]")
axis.legend()
print(
    *(f"{value:g}: RMSE {1000 * result.whole.rmse:.1f} mm" for value, result in zip(values, results, strict=True)),
    sep="\n",
)

# %%
# The errors hardly change over decades, which is usual for ``best``, and grow at the end. The errors of single
# blocks: a value that is good for the frame need not be good for each block, so that a block can have its own
# parameters.

chosen = results[1]
for label in (1, 2, 3):
    print(
        f"block {label}: median {1000 * chosen.blocks[label].median:.1f} mm over {chosen.blocks[label].pixels} pixels"
    )
completion = ilf.complete(frame, blocks, own={2: ilf.preset(smoothness=10.0)})
print(completion)
