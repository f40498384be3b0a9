"""
Figure 7: real frames, raw and completed
========================================

Figures 7 and 8 of the paper are pictures of real frames before and after the filter. They are not published. Here,
frames of your own are completed (``--frames FOLDER``: whatever `ilf.open_source` reads), and without them the bundled
sample, a generated room with a simulated sensor.
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main

parser = argparse.ArgumentParser()
parser.add_argument("--frames", help="a folder of frames, a data set or a recording")
parser.add_argument(
    "--full", action="store_true", help="8 frames with all pixels, not 2 with every second row and column"
)
options = parser.parse_args()
every, count = (1, 8) if options.full else (2, 2)

# %%
# Frames are taken evenly from all. A frame without intrinsics gets the focal length of a Kinect for its cloud.

if options.frames is None:
    main(["sample", "room"])
source = ilf.open_source(options.frames or "room")
frames = []
for place in sorted({round(place) for place in np.linspace(0, len(source) - 1, count)}):
    whole = source[place]
    height, width = whole.shape
    camera = whole.intrinsics or ilf.Camera(0.82 * width, 0.82 * width, (width - 1) / 2, (height - 1) / 2)
    camera = ilf.Camera(camera.fx / every, camera.fy / every, camera.cx / every, camera.cy / every)
    rgb, depth = whole.rgb[::every, ::every], whole.depth[::every, ::every]
    frames.append(ilf.RGBDFrame(rgb=rgb, depth=depth, intrinsics=camera, name=whole.name))

# %%
# Colour, raw depth (black: missing), and depth completed by the presets.

presets = ("paper", "released-code", "best")
completed = []
figure, axes = plt.subplots(
    len(frames),
    5,
    figsize=(13, 0.5 + 1.7 * len(frames)),
    squeeze=False,
    layout="compressed",
    subplot_kw={"facecolor": "black"},
)
for row, frame in zip(axes, frames, strict=True):
    blocks = ilf.extract_blocks(frame, detector="hed")  # contours of the colour image, as in the paper
    depths = {name: ilf.complete(frame, blocks, name).depth for name in presets}
    completed.append(depths)
    near, far = np.nanpercentile(frame.depth, (2, 98))
    row[0].imshow(frame.rgb)
    for axis, depth in zip(row[1:], (frame.depth, *depths.values()), strict=True):
        picture = axis.imshow(depth, cmap="viridis_r", vmin=near, vmax=far)
    figure.colorbar(picture, ax=row, label="Depth [m]")
    row[0].set_ylabel(frame.name)
    filled = {name: np.isfinite(depth[~frame.known]).mean() for name, depth in depths.items()}
    print(f"{frame.name}: {frame.missing_share:.1%} missing; completed of it:", end=" ")
    print(", ".join(f"{share:.1%} by {name}" for name, share in filled.items()))
for axis, title in zip(axes[0], ("colour", "raw", *presets), strict=True):
    axis.set_title(title)
for axis in axes.flat:
    axis.set(xticks=[], yticks=[])

# %%
# Depth that lies in no block, or in a block with too little known depth, stays missing. That depth is complete says
# nothing about its accuracy: for that, see Table 1.
#
# The same as point clouds, from the side and above.

_, axes = plt.subplots(
    len(frames), 3, figsize=(12, 4 * len(frames)), squeeze=False, layout="constrained", subplot_kw={"projection": "3d"}
)
for row, frame, depths in zip(axes, frames, completed, strict=True):
    shown = {"raw": frame.depth, "paper": depths["paper"], "best": depths["best"]}
    for axis, (title, depth) in zip(row, shown.items(), strict=True):
        cloud = ilf.point_cloud(depth, frame.rgb, frame.intrinsics)
        some = np.random.default_rng(0).permutation(len(cloud))[:15_000]
        x, y, z = cloud.points[some].T
        axis.scatter(x, z, -y, c=cloud.colours[some] / 255, s=2, depthshade=False)
        axis.view_init(elev=18, azim=-62)
        axis.set_box_aspect((np.ptp(x), np.ptp(z), np.ptp(y)), zoom=1.4)
        axis.set_title(f"{frame.name}: {title}")
        axis.set_axis_off()
plt.show()
