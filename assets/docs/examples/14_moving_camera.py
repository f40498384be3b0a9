"""
A moving camera
===============

`ilf.Stream` completes frame after frame. Blocks and edges are found every few frames and carried along in between,
and the filter starts from the frame before, so that filled depth does not flicker. Here, the camera moves over the
sample, and every frame has its own noise.
"""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main

main(["sample", "room"])
sample = ilf.load_frame("room")
rng = np.random.default_rng(0)


def seen(shift: int) -> ilf.RGBDFrame:
    """Return the part of the sample that the camera sees, with new noise and new holes."""
    view = np.s_[150:390, 150 + shift : 470 + shift]
    depth = sample.depth[view] + rng.normal(0, 0.005, (240, 320))
    depth[rng.random(depth.shape) < 0.1] = np.nan
    return ilf.RGBDFrame(rgb=sample.rgb[view].copy(), depth=depth, name=f"frame {shift}")


frames = [seen(2 * index) for index in range(12)]
with ilf.Stream() as stream:
    streamed = [stream.complete(frame) for frame in frames]
print(stream.statistics)
single = [ilf.complete(frame) for frame in frames]

# %%
# How much filled depth changes from frame to frame, at the same point of the room:


def flicker(completions: list[ilf.Completion]) -> list[float]:
    """Return the mean change of depth at pixels that were missing in both frames [mm], for each pair of frames."""
    changes = []
    for one, next_ in pairwise(completions):
        both = one.filled[:, 2:] & next_.filled[:, :-2]
        changes.append(1000 * float(np.abs(one.depth[:, 2:] - next_.depth[:, :-2])[both].mean()))
    return changes


_, axis = plt.subplots(figsize=(7, 3.2), layout="constrained")
axis.plot(flicker(single), "o-", label="frame by frame")
axis.plot(flicker(streamed), "o-", label="stream")
axis.set(xlabel="Frame", ylabel="Change [mm]", ylim=(0, None))
axis.legend(loc="center left")

# %%
streamed[-1].plot()
