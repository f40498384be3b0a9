"""
Point cloud, mesh and normals
=============================

Completed depth as points with scalars that CloudCompare and MeshLab show, and as a mesh that is cut where depth
jumps.
"""

import matplotlib.pyplot as plt
import numpy as np

import ilf
from ilf.cli import main

main(["sample", "room"])
frame = ilf.load_frame("room")
completion = ilf.complete(frame)

scalars = {"expected_error": ilf.expected_error(completion), "filled": completion.filled}
normals = ilf.surface_normals(completion.depth, frame.intrinsics)
cloud = ilf.point_cloud(completion.depth, frame.rgb, frame.intrinsics, normals=normals, scalars=scalars)
mesh = ilf.surface_mesh(completion.depth, frame.rgb, frame.intrinsics, normals=normals)
ilf.write_cloud("room.ply", cloud)
ilf.write_mesh("room.glb", mesh)
print(len(cloud), "points,", len(mesh), "triangles")

# %%
# The measured and the completed cloud from the left. With Open3D installed, ``cloud.to_open3d()`` and
# ``mesh.to_open3d()`` are its own objects.

figure, axes = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained", subplot_kw={"projection": "3d"})
measured = ilf.point_cloud(frame.depth, frame.rgb, frame.intrinsics)
for axis, (title, one) in zip(axes, {"measured": measured, "completed": cloud}.items(), strict=True):
    some = np.random.default_rng(0).choice(len(one), 15_000, replace=False)
    x, y, z = one.points[some].T
    axis.scatter(x, z, -y, c=one.colours[some] / 255, s=2, depthshade=False)
    axis.view_init(elev=18, azim=-62)
    axis.set_box_aspect((3, 3.2, 2.4), zoom=1.6)
    axis.set_title(title)
    axis.set_axis_off()

# %%
# Normals as colours.

_, axis = plt.subplots(figsize=(5.5, 4.2), layout="compressed")
axis.imshow((normals * (0.5, -0.5, -0.5) + 0.5).clip(0, 1))
axis.set(xticks=[], yticks=[], title="Normals of the completed depth")
