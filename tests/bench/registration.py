"""Accuracy of registration against exact depth: python -m tests.bench.registration [--seed 7]

The generated room is rendered for a depth camera and a colour camera beside it, each with its own lens, and the pair is
registered: by `ilf.sources.registration`, by one sample for each depth pixel with the same lenses, and by Open3D's
`project_to_depth_image`, which ignores distortion. The exact depth of every undistorted colour pixel determines whether
the depth camera saw its point: inside the image, as the nearest point of its ray, and at a pixel with depth. "more" is
the library's method with twice as many samples along rows and columns. Columns:

- known: share of the seen pixels that have depth after registration; the others are false holes.
- see-through: share of the seen pixels whose depth is that of a point at least 5 cm and 5 % farther away.
- error: median and 90th percentile of the error of all other seen pixels [mm]; jumps to the front count.
- outside: of the pixels whose points lie outside the depth image, the share marked as outside; and the share of the
  marked pixels that the depth camera did see.
- CPU: processor time per frame [s], the best of five; for Open3D only that of the call.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.camera import CameraIntrinsics
from ilf.data.open3d_images import load_open3d
from ilf.sources import registration as registering
from ilf.sources.registration import Camera, RawPair, register

sys.path.append(str(Path(__file__).parents[2] / "assets" / "samples"))
from roomkit.room import Room, build

SEEN_TOLERANCE = 0.01
"""Maximum distance of a point to the depth camera's nearest point on its ray to count as seen [share of depth]."""

FAR_M, FAR_SHARE = 0.05, 0.05
_TIMES = 5

Floats = NDArray[np.float64]
Way = Callable[[RawPair, Camera], NDArray[np.float32]]


@dataclass(frozen=True)
class Rig:
    """Two cameras, and the motion from depth to colour camera: rotation about x [degrees], and shift [m]."""

    name: str
    depth: Camera
    colour: Camera
    tilt: float
    shift: tuple[float, float, float]

    @property
    def depth_to_colour(self) -> Floats:
        """(4, 4)."""
        motion = np.eye(4)
        motion[:3, :3], _ = cv2.Rodrigues(np.array([np.radians(self.tilt), 0.0, 0.0]))
        motion[:3, 3] = self.shift
        return motion


RIGS = (
    Rig(
        "time of flight",
        Camera(
            CameraIntrinsics(504.0, 504.0, 328.0, 332.0), (640, 576), (0.55, -0.02, 0.0, 0.0, -0.003, 0.89, 0.09, -0.01)
        ),
        Camera(
            CameraIntrinsics(612.0, 612.0, 639.0, 366.0), (1280, 720), (0.33, -2.5, 0.0, 0.0, 1.45, 0.21, -2.3, 1.38)
        ),
        -5.0,
        (-0.032, -0.002, 0.004),
    ),
    Rig(
        "structured light",
        Camera(CameraIntrinsics(583.0, 583.0, 313.0, 238.0), (640, 480), (-0.1, 0.39, 0.002, -0.002, -0.51)),
        Camera(CameraIntrinsics(519.0, 519.0, 326.0, 254.0), (640, 480), (0.21, -0.59, 0.0007, 0.001, 0.5)),
        0.3,
        (-0.025, 0.0, -0.001),
    ),
    Rig(
        "stereo, no distortion",
        Camera(CameraIntrinsics(640.0, 640.0, 640.0, 360.0), (1280, 720)),
        Camera(CameraIntrinsics(910.0, 910.0, 640.0, 360.0), (1280, 720)),
        0.2,
        (0.015, 0.0, 0.0),
    ),
)


def rays_of(camera: Camera) -> Floats:
    """Return the ray of every pixel, (N, 3) with depth 1."""
    columns, rows = np.meshgrid(*map(np.arange, camera.size))
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1).astype(np.float64)
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-10)
    flat = cv2.undistortPoints(pixels[:, None], camera.matrix, camera.coefficients, None, None, None, criteria)
    return np.concatenate([flat[:, 0], np.ones((len(pixels), 1))], axis=1)


def seen(room: Room, rays: Floats, motion: Floats) -> Floats:
    """Return depth [m] along rays of a camera; `motion` maps its points to the room's camera."""
    eye = room.camera
    axes = np.stack([eye.right, eye.down, eye.forward])
    directions = rays @ motion[:3, :3].T @ axes
    hits = room.scene.cast(np.broadcast_to(eye.position + motion[:3, 3] @ axes, rays.shape), directions)
    return np.where(hits.found, hits.distance, np.nan).astype(np.float64)


def pair_of(room: Room, rig: Rig) -> RawPair:
    """Render the raw pair of the two cameras: depth in whole millimetres, grey colour."""
    depth = seen(room, rays_of(rig.depth), rig.depth_to_colour).reshape(rig.depth.shape)
    grey = np.full((*rig.colour.shape, 3), 128, np.uint8)
    return RawPair(grey, np.round(1000 * depth) / 1000, rig.colour, rig.depth, rig.depth_to_colour)


def registered(pair: RawPair, _: Camera) -> NDArray[np.float32]:
    """The library's registration."""
    return register(pair).depth


def more_samples(pair: RawPair, _: Camera) -> NDArray[np.float32]:
    """The same with twice as many samples along rows and columns."""
    with mock.patch.object(registering, "SAMPLES_PER_PIXEL", 2 * registering.SAMPLES_PER_PIXEL):
        return register(pair).depth


def one_sample(pair: RawPair, view: Camera) -> NDArray[np.float32]:
    """Project every depth pixel's centre to one colour pixel."""
    points = rays_of(pair.depth_camera) * pair.depth.reshape(-1, 1)
    points = points[np.isfinite(points[:, 2])] @ pair.depth_to_colour[:3, :3].T + pair.depth_to_colour[:3, 3]
    columns, rows, _ = np.rint(points @ view.matrix.T / points[:, 2:]).astype(int).T
    inside = (columns >= 0) & (columns < view.size[0]) & (rows >= 0) & (rows < view.size[1])
    found = np.full(view.shape, np.inf, np.float32)
    np.minimum.at(found, (rows[inside], columns[inside]), points[inside, 2].astype(np.float32))
    return np.where(np.isfinite(found), found, np.float32(np.nan))


def by_open3d(pair: RawPair, view: Camera) -> NDArray[np.float32]:
    """Project the point cloud of the depth image by Open3D."""
    o3d = load_open3d()
    image = o3d.t.geometry.Image(np.nan_to_num(pair.depth))
    matrices = [o3d.core.Tensor(camera.matrix) for camera in (pair.depth_camera, view)]
    cloud = o3d.t.geometry.PointCloud.create_from_depth_image(image, matrices[0], depth_scale=1.0, depth_max=20.0)
    drawn = cloud.project_to_depth_image(
        *view.size, matrices[1], o3d.core.Tensor(pair.depth_to_colour), depth_scale=1.0, depth_max=20.0
    )
    depth = drawn.as_tensor().numpy()[..., 0].astype(np.float32)
    return np.where(depth > 0, depth, np.float32(np.nan))


WAYS: dict[str, Way] = {
    "ilf": registered,
    "more": more_samples,
    "one sample": one_sample,
    "open3d": by_open3d,
}


def visible(room: Room, pair: RawPair, points: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which points of the colour camera the depth camera saw, and which lie outside its image."""
    back = np.linalg.inv(pair.depth_to_colour)
    own = points @ back[:3, :3].T + back[:3, 3]
    camera = pair.depth_camera
    places, _ = cv2.projectPoints(own, np.zeros(3), np.zeros(3), camera.matrix, camera.coefficients)
    columns, rows = places[:, 0].T
    inside = (columns >= -0.5) & (columns < camera.size[0] - 0.5) & (rows >= -0.5) & (rows < camera.size[1] - 0.5)
    inside &= own[:, 2] > 0
    first = seen(room, own / own[:, 2:], pair.depth_to_colour)
    near = np.abs(first - own[:, 2]) < SEEN_TOLERANCE * own[:, 2]
    column, row = (np.rint(np.where(inside, place, 0)).astype(int) for place in (columns, rows))
    return inside & near & np.isfinite(pair.depth[row, column]), ~inside


def main() -> None:
    """Print a table for each rig."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=7, help="seed of the room (default: 7)")
    room = build(parser.parse_args().seed)
    for rig in RIGS:
        pair = pair_of(room, rig)
        frame = register(pair)
        assert frame.intrinsics is not None
        view = Camera(frame.intrinsics, rig.colour.size)
        rays = rays_of(view)
        exact = seen(room, rays, np.eye(4))
        could, outside = visible(room, pair, rays * exact[:, None])
        print(
            f"{rig.name}: {rig.depth.size[0]} x {rig.depth.size[1]} -> {rig.colour.size[0]} x {rig.colour.size[1]}, "
            f"seen {could.mean():.1%}, outside {outside.mean():.1%}"
        )
        for name, way in WAYS.items():
            depth, seconds = _timed(way, pair, view)
            print(f"  {name:<11} {_summary(depth.ravel(), exact, could)}, CPU {seconds:.3f} s")
        marked = np.zeros(outside.shape, bool) if frame.outside_view is None else frame.outside_view.ravel()
        print(
            f"  outside     marked {np.mean(marked[outside]) if outside.any() else 1:.2%}; "
            f"of the marked, seen {np.mean(could[marked]) if marked.any() else 0:.3%}"
        )


def _summary(depth: NDArray[np.float32], exact: Floats, could: NDArray[np.bool_]) -> str:
    known = np.isfinite(depth) & could
    beyond = known & (depth - exact > np.maximum(FAR_M, FAR_SHARE * exact))
    error = 1000 * np.abs(depth - exact)[known & ~beyond]
    return (
        f"known {known.sum() / could.sum():.2%}, see-through {beyond.sum() / could.sum():.3%}, "
        f"error {np.median(error):.2f} / {np.quantile(error, 0.9):.2f} mm"
    )


def _timed(way: Way, pair: RawPair, view: Camera) -> tuple[NDArray[np.float32], float]:
    """Return the depth, and the processor time [s]."""
    best = np.inf
    for _ in range(_TIMES):
        begun = time.process_time()
        depth = way(pair, view)
        best = min(best, time.process_time() - begun)
    return depth, best


if __name__ == "__main__":
    main()
