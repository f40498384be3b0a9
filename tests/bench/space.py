"""Accuracy of clouds and meshes against exact depth, and cost of writing large ones: `python -m tests.bench.space`.

For the bundled room, completed by `best`: points omitted as flying, and their errors; links between neighbours that
bridge a jump of the exact depth or cut a continuous surface, for the library's links and for a plain threshold on the
step; and errors of normals. Then processor time and size of every format for a frame of 3840 x 2160.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ilf
from ilf._runtime.installation import asset_path
from ilf.completion.edge_aware.view import flying_pixels
from ilf.data import surface as links
from ilf.data import surface as normals
from ilf.data.points import point_cloud
from ilf.data.surface import flying_points, surface_links, surface_mesh, surface_normals
from ilf.io.clouds import write_cloud
from ilf.io.meshes import write_mesh

_AROUND = range(-3, 4)

Array = NDArray[np.float32]


def main() -> None:
    """Print all measures."""
    frame = ilf.load_frame(asset_path("samples/room"))
    depth = ilf.complete(frame, ilf.extract_blocks(frame)).depth
    ground_truth, camera = frame.ground_truth, frame.intrinsics
    assert ground_truth is not None
    assert camera is not None
    print("points        left out   off > 4 %   off < 2 %   of those in mid-air")
    lost = _in_mid_air(depth, ground_truth)
    with np.errstate(invalid="ignore"):
        off = np.abs(depth - ground_truth) / ground_truth
    alone = flying_pixels(ilf.RGBDFrame(frame.rgb, depth))
    for name, found in (("flying_points", flying_points(depth, camera)), ("flying_pixels", alone)):
        share = np.count_nonzero(found & lost) / np.count_nonzero(lost)
        wrong, right = np.count_nonzero(found & (off > 0.04)), np.count_nonzero(found & (off < 0.02))
        print(f"{name} {np.count_nonzero(found):9} {wrong:11} {right:11} {share:11.0%}")
    print("links         bridge   of jumps   cut surfaces       of links")
    exact = surface_links(ground_truth, camera).right
    known = (off[:, 1:] < 0.02) & (off[:, :-1] < 0.02)
    with np.errstate(invalid="ignore"):
        step = np.abs(np.diff(depth, axis=1)) / np.minimum(depth[:, 1:], depth[:, :-1])
    for name, found in (
        ("as they are", surface_links(depth, camera).right),
        *((f"{t:.0%}", step < t) for t in (0.04, 0.02)),
    ):
        bridges, cuts = (np.count_nonzero(known & pairs) for pairs in (found & ~exact, ~found & exact))
        jumps, others = np.count_nonzero(known & ~exact), np.count_nonzero(known & exact)
        print(f"{name:12} {bridges:7} {jumps:10} {cuts:13} {others:15}")
    print(f"error of normals {_normals_off(depth, ground_truth, off < 0.03, camera):.1f} degrees in the median")
    rounds, normals._ROUNDS = normals._ROUNDS, 0
    print(f"without averaging by {_normals_off(depth, ground_truth, off < 0.03, camera):.1f}")
    normals._ROUNDS = rounds
    _write_large()


def _in_mid_air(depth: Array, ground_truth: Array) -> NDArray[np.bool_]:
    """Return completed pixels between the exact depths around them, and near none of these."""
    shifted = [np.roll(ground_truth, (dy, dx), (0, 1)) for dy in _AROUND for dx in _AROUND]
    with np.errstate(invalid="ignore"):
        near = np.any([np.abs(depth - other) < 0.03 * ground_truth for other in shifted], axis=0)
        between = (depth > 1.04 * np.nanmin(shifted, axis=0)) & (depth < 0.96 * np.nanmax(shifted, axis=0))
    return np.asarray(between & ~near)


def _normals_off(depth: Array, ground_truth: Array, known: NDArray[np.bool_], camera: ilf.CameraIntrinsics) -> float:
    """Return the median angle [degrees] to the normals of the exact depth, away from its jumps."""
    rounds, normals._ROUNDS = normals._ROUNDS, 0
    exact = surface_normals(ground_truth, camera)
    normals._ROUNDS = rounds
    linked, inside = links.surface_links(ground_truth, camera), known.copy()
    inside[:, 1:] &= linked.right
    inside[:, :-1] &= linked.right
    inside[1:] &= linked.down
    inside[:-1] &= linked.down
    angle = np.arccos(np.clip((surface_normals(depth, camera) * exact).sum(2), -1, 1))
    return float(np.degrees(np.median(angle[inside])))


def _write_large() -> None:
    rng, shape = np.random.default_rng(0), (2160, 3840)
    rows, columns = np.indices(shape, np.float32, sparse=True)
    depth = 2 + 0.3 * np.sin(columns / 200) + 0.2 * np.cos(rows / 150) + 0.8 * (columns > 1920)
    rgb = rng.integers(0, 256, (*shape, 3), dtype=np.uint8)
    camera = ilf.CameraIntrinsics(3000, 3000, 1919.5, 1079.5)
    scalars = {"expected_error": rng.random(shape, np.float32), "filled": depth > 2, "block": np.ones(shape, np.int32)}
    known = {"normals": surface_normals(depth, camera), "scalars": scalars}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("cloud.ply", "cloud.pcd", "mesh.ply", "mesh.glb", "mesh.obj"):
            make, write = (point_cloud, write_cloud) if name.startswith("cloud") else (surface_mesh, write_mesh)
            space = make(depth, rgb, camera, **known)
            begun = time.process_time()
            write(Path(folder, name), space)
            seconds = time.process_time() - begun
            print(f"{name}: {len(space)} of them, {Path(folder, name).stat().st_size / 1e6:.0f} MB in {seconds:.1f} s")
            Path(folder, name).unlink()
            del space


if __name__ == "__main__":
    main()
