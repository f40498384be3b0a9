"""Point cloud and mesh of a run's result, with what is known of every point."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cloud import flying_points, in_world, point_cloud, surface_mesh, surface_normals
from ..errors import InputError
from ..frame import RGBDFrame
from ..io import write_cloud, write_mesh
from ..outcomes import Completion
from ..stopping import check_stopped
from .options import CLOUD_FILES, MESH_FILES, WORLD, ExportOptions
from .run import Run


def check_space(frame: RGBDFrame, options: ExportOptions) -> None:
    """Raise InputError if a cloud or a mesh is asked for of a frame without intrinsics, or in the world without a
    pose."""
    if options.axes == WORLD and frame.pose is None and (options.cloud or options.mesh):
        raise InputError("Where the camera was is not known of this frame: choose other axes than those of the world.")
    if frame.intrinsics is None and (options.cloud or options.mesh):
        raise InputError(
            f"A {'point cloud' if options.cloud else 'mesh'} needs the camera's intrinsics, and this frame has none. "
            "Give them as a preset (such as nyu-kinect-v1), as fx,fy,cx,cy or as a JSON file; or leave it out."
        )


def write_space(
    folder: Path,
    run: Run,
    completion: Completion,
    options: ExportOptions,
    error: NDArray[np.float32] | None,
    doubtful: NDArray[np.bool_] | None,
) -> list[str]:
    """Write the cloud and the mesh that are chosen; returns notes.

    Parameters
    ----------
    folder : Path
    run, completion, options
        As `write` takes them; the frame's camera is known.
    error, doubtful : ndarray, optional
        Expected error [m] and what nothing vouches for, both (H, W), if they are to be told of every point.
    """
    camera, depth, rgb = run.frame.intrinsics, completion.depth, run.frame.rgb
    if camera is None or not (options.cloud or options.mesh):
        return []
    notes = []
    only = ~flying_points(depth, camera) if options.drop_flying else None
    if only is not None and (count := np.count_nonzero(~only)):
        notes.append(f"Left out of cloud and mesh: {count} points in mid-air. The depth files have them.")
    if options.normals and options.cloud in {"xyz", "xyzrgb"}:
        notes.append(f"{CLOUD_FILES[options.cloud]} has no place for normals: choose PLY or PCD.")
    known: dict[str, Any] = {
        "only": only,
        "normals": surface_normals(depth, camera) if options.normals else None,
        "scalars": _scalars(run, completion, error, doubtful),
    }
    pose = run.frame.pose if options.axes == WORLD else None
    axes = options.axes if pose is None else "camera"
    if options.cloud is not None:
        cloud = point_cloud(depth, rgb, camera, **known)
        if pose is not None:
            cloud = in_world(cloud, pose)
        path = folder / CLOUD_FILES[options.cloud]
        write_cloud(path, cloud, axes=axes, unit=options.cloud_unit, ascii=options.cloud == "ply-ascii")
        del cloud  # a mesh is as large
        check_stopped()
    if options.mesh is not None:
        mesh = surface_mesh(depth, rgb, camera, **known)
        check_stopped()
        if pose is not None and options.mesh != "glb":
            mesh = replace(mesh, vertices=in_world(mesh.vertices, pose))
        write_mesh(folder / MESH_FILES[options.mesh], mesh, axes=axes, unit=options.cloud_unit)
    return notes


def _scalars(
    run: Run, completion: Completion, error: NDArray[np.float32] | None, doubtful: NDArray[np.bool_] | None
) -> dict[str, NDArray[Any]]:
    """What is known of every pixel beside where it is."""
    scalars: dict[str, NDArray[Any]] = {}
    if error is not None:
        scalars["expected_error"] = error
    scalars["filled"] = completion.filled
    scalars["block"] = run.blocks
    if doubtful is not None:
        scalars["unvouched"] = doubtful
    return scalars
