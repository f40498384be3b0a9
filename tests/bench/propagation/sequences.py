"""Sequences of frames with known motion: the generated room, and rotated views of real frames."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.camera import CameraIntrinsics
from ilf.data.frame import RGBDFrame

sys.path.insert(0, str(Path(__file__).parents[3] / "assets" / "samples"))
from make_room import intrinsics_at
from roomkit import light, picture, sensor
from roomkit.furniture import OAK, Parts, placed
from roomkit.meshes import box
from roomkit.room import Camera, Room, build, camera
from roomkit.scene import Hits

SIZE = (640, 480)
LENGTH = 31
SMALLEST_SURFACE = 100
"""Minimum number of pixels in the first frame for a surface of the room to be a block."""

_SHELL = 5
"""Parts of the room that are floor, ceiling and walls, each side of which is a surface."""

_SHADOW_RAYS = 2
"""Samples per lamp, fewer than in the bundled sample because there are many pictures."""

_AMBIENT = np.array([0.62, 0.60, 0.56])
"""Ambient light [irradiance] in place of bounces."""


@dataclass(frozen=True, eq=False)
class Moment:
    """A frame of a sequence with its ground truth.

    Attributes
    ----------
    frame : RGBDFrame
    surface : ndarray of int32, shape (H, W)
        Number of the surface at a pixel, the same in all frames of the sequence; 0 for no block.
    first : ndarray of int32, shape (H, W)
        Index of the pixel of the first frame that shows the same point; -1 without one.
    pose : ndarray of float64, shape (4, 4)
        World to camera.
    exact : ndarray of float32, shape (H, W), or None
        Exact depth [m], NaN without a surface; None if not known.
    """

    frame: RGBDFrame
    surface: NDArray[np.int32]
    first: NDArray[np.int64]
    pose: NDArray[np.float64]
    exact: NDArray[np.float32] | None = None


def orbit(step: int) -> Camera:
    """Orbit around the middle of the room by 1 degree per frame, with a hand's tremor."""
    turn = np.radians(1.0 * step)
    middle = np.array([0.0, 0.9, 2.6])
    start = camera()
    about = _turned(turn)
    return _moved(start, middle + about @ (start.position - middle), about, step)


def dolly(step: int) -> Camera:
    """Move forward by 3 cm per frame and slightly sideways, with a hand's tremor."""
    start = camera()
    place = start.position + np.array([0.004, -0.004, 0.03]) * step
    return _moved(start, place, _turned(np.radians(-0.1 * step)), step)


def still(step: int) -> Camera:
    """Stand still."""
    return camera()


def hand(step: int) -> Camera:
    """Held in the hand of someone who walks slowly: forward, swaying, and looking around."""
    start = camera()
    place = start.position + np.array([0.03 * np.sin(0.4 * step), 0.012 * np.sin(0.9 * step), 0.015 * step])
    return _moved(start, place, _turned(np.radians(4.0 * np.sin(0.25 * step))), 3 * step)


def moving_box(step: int) -> Parts:
    """A box that moves across the room by 4 cm per frame."""
    return placed([(box((0.35, 0.55, 0.35)).moved(y=0.275), OAK)], -0.75 + 0.04 * step, 0.0, 1.95)


def rendered(path: str, cache: Path, length: int = LENGTH, seed: int = 7) -> list[Moment]:
    """Render a sequence of the generated room; pictures are cached, because each takes seconds.

    Parameters
    ----------
    path : str
        "orbit", "dolly", "hand", "still", or "moving": in the hand, with a box that moves.
    cache : Path
        Cache folder.
    length : int
        Number of frames.
    seed : int
        Of the room.
    """
    cache.mkdir(parents=True, exist_ok=True)
    scene: Room | None = None
    light_seen: NDArray[np.float32] | None = None
    raw = []
    for step in range(length):
        file = cache / f"{path}-{seed}-{step:02d}.npz"
        if not file.exists():
            scene = build(seed, moving_box(step)) if path == MOVING else scene or build(seed)
            print(f"rendering {path} {step}", file=sys.stderr)
            room = replace(scene, camera=PATHS[path](step))
            rng = np.random.default_rng([seed, 5, step])
            if light_seen is None or path != "still":
                light_seen = _radiance(room, rng)
            partial = file.with_suffix(".part.npz")
            np.savez_compressed(partial, rgb=picture.developed(light_seen, rng), **_sensed(room, rng))
            partial.replace(file)
        with np.load(file) as content:
            raw.append({name: content[name] for name in content.files})
    areas = np.bincount(raw[0]["surface"].ravel())
    blocks = np.zeros(max(int(one["surface"].max()) for one in raw) + 1, np.int32)
    # surfaces that appear later count, too
    blocks[1:] = np.arange(1, blocks.size)
    small = np.flatnonzero((areas > 0) & (areas < SMALLEST_SURFACE))
    blocks[small] = 0
    poses = [_pose(PATHS[path](step)) for step in range(length)]
    intrinsics = CameraIntrinsics(*intrinsics_at(SIZE))
    return [
        Moment(
            RGBDFrame(one["rgb"], one["depth"], intrinsics, name=f"{path} {step}"),
            blocks[one["surface"]],
            _seen_first(one["exact"], pose, raw[0]["exact"], poses[0], intrinsics),
            pose,
            one["exact"],
        )
        for step, (one, pose) in enumerate(zip(raw, poses, strict=True))
    ]


def turned_views(folder: Path, length: int = LENGTH, seed: int = 0) -> list[Moment]:
    """Make views of a real frame in other directions from the same place: colour and depth.

    Each view has its own noise. Surfaces are unknown.

    Parameters
    ----------
    folder : Path
        Of the frame, with intrinsics.
    length : int
        Number of views.
    seed : int
        Of the noise.
    """
    import ilf
    from ilf.evaluation.bench.frames import as_measured

    whole = as_measured(ilf.load_frame(folder))
    found = whole.intrinsics
    assert found is not None
    height, width = (int(side * 0.7) // 2 * 2 for side in whole.shape)
    inner = CameraIntrinsics(found.fx, found.fy, (width - 1) / 2, (height - 1) / 2)
    matrix = np.array([[found.fx, 0, found.cx], [0, found.fy, found.cy], [0, 0, 1.0]])
    back = np.linalg.inv(np.array([[inner.fx, 0, inner.cx], [0, inner.fy, inner.cy], [0, 0, 1.0]]))
    rows, columns = np.indices((height, width))
    rays = back @ np.stack([columns.ravel(), rows.ravel(), np.ones(rows.size)])
    rng = np.random.default_rng(seed)
    moments: list[Moment] = []
    number = np.arange(whole.depth.size).reshape(whole.shape)
    for step in range(length):
        share = step / (length - 1) - 0.5
        turn = cv2.Rodrigues(np.array([0.10 * np.sin(5 * share), 0.16 * 2 * share, 0.04 * np.sin(9 * share)]))[0]
        x, y, z = matrix @ turn @ rays
        x, y = ((axis / z).reshape(height, width).astype(np.float32) for axis in (x, y))
        colour = cv2.remap(whole.rgb, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        noisy = colour + rng.normal(0, 2, colour.shape)
        depth = cv2.remap(whole.depth, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=np.nan)
        # depth along the axis of the turned camera
        depth = depth / (turn @ rays)[2].reshape(height, width)
        source = cv2.remap(
            number.astype(np.float64), x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=-1
        )
        pose = np.eye(4)
        pose[:3, :3] = turn.T
        frame = RGBDFrame(np.clip(np.round(noisy), 0, 255).astype(np.uint8), depth, inner, name=folder.name)
        moments.append(Moment(frame, np.zeros(frame.shape, np.int32), source.astype(np.int64), pose))
    return [replace(one, first=_index_in(moments[0].first, one.first)) for one in moments]


def _index_in(first: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the index in the first view of the pixel with the same source, or a neighbour; -1 without one."""
    where = np.full(int(max(first.max(), other.max())) + 2, -1, np.int64)
    where[first.ravel()] = np.arange(first.size)
    where[-1] = -1
    return where[other]


def _turned(angle: float) -> NDArray[np.float64]:
    """Rotation about the vertical."""
    return np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])


def _moved(start: Camera, place: NDArray[np.float64], turn: NDArray[np.float64], step: int) -> Camera:
    tremor = np.radians(0.15) * np.array([np.sin(2.1 * step), np.sin(1.3 * step + 1), np.sin(1.7 * step + 2)])
    tremor[1:] -= np.radians(0.15) * np.array([np.sin(1), np.sin(2)])
    whole = turn @ cv2.Rodrigues(tremor)[0]
    # axes must stay at right angles in the room's left-handed world
    right, down, forward = (whole @ axis for axis in (start.right, start.down, start.forward))
    return Camera(place, right, down, forward)


def _pose(seen: Camera) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, :3] = np.stack([seen.right, seen.down, seen.forward])
    pose[:3, 3] = -pose[:3, :3] @ seen.position
    return pose


def _radiance(room: Room, rng: np.random.Generator) -> NDArray[np.float32]:
    """Render linear colour with simpler light than the sample's: no bounces, fewer shadow rays."""
    width, height = SIZE
    finer = 2
    views, hits = _cast(room, 1)
    lamps = [replace(lamp, samples=_SHADOW_RAYS) if hasattr(lamp, "samples") else lamp for lamp in room.lights]
    lit = light.direct(room.scene, lamps, hits, rng).reshape(height, width, 3).astype(np.float32)
    normals, points = (one.reshape(height, width, 3).astype(np.float32) for one in (hits.normals, hits.points))
    lit = picture.smoothed(lit, normals, points, levels=3) + _AMBIENT * (0.8 + 0.2 * normals[..., 1:2])
    mirror, share = light.mirrored(room.scene, lamps, hits, views, rng, sky=room.sky, ambient=_AMBIENT, rays=2)
    _, fine = _cast(room, finer)
    lit, mirror, share = (
        np.repeat(np.repeat(one.reshape(height, width, -1), finer, 0), finer, 1).reshape(len(fine.found), -1)
        for one in (lit, mirror, share)
    )
    surface = room.scene.colour(fine, textured=True) * lit / np.pi + room.scene.of("emission", fine)
    seen = np.where(fine.found[:, None], surface * (1 - share) + mirror * share, room.sky)
    seen = np.minimum(seen * picture.EXPOSURE, 12.0).reshape(height, finer, width, finer, 3)
    return np.asarray(seen.mean(axis=(1, 3)), np.float32)


def _sensed(room: Room, rng: np.random.Generator) -> dict[str, NDArray[np.generic]]:
    """Return the sensor's depth, the exact depth, and surfaces."""
    shape = (SIZE[1], SIZE[0])
    views, hits = _cast(room, 1)
    exact = hits.distance.reshape(shape)
    holes = np.any(list(sensor.holes(room, hits, views, shape, rng).values()), axis=0)
    depth = np.where(holes, np.nan, sensor.measured(exact, intrinsics_at(SIZE), rng))
    return {
        "depth": depth.astype(np.float32),
        "exact": np.where(hits.found.reshape(shape), exact, np.nan).astype(np.float32),
        "surface": _surfaces(hits).reshape(shape),
    }


def _cast(room: Room, finer: int) -> tuple[NDArray[np.float64], Hits]:
    width, height = SIZE[0] * finer, SIZE[1] * finer
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    x, y = ((axis.ravel() + 0.5) / finer - 0.5 for axis in (columns, rows))
    views = room.camera.directions(x, y, intrinsics_at(SIZE))
    return views, room.scene.cast(np.broadcast_to(room.camera.position, views.shape), views)


def _surfaces(hits: Hits) -> NDArray[np.int32]:
    """Return surfaces: for the shell one for each part and side, else one for each part; rays without a hit are sky."""
    axis = np.abs(hits.flat).argmax(axis=1)
    side = 2 * axis + (np.take_along_axis(hits.flat, axis[:, None], axis=1)[:, 0] > 0)
    numbers = np.where(hits.part < _SHELL, 1 + 6 * hits.part + side, 6 * _SHELL + 2 + hits.part)
    return np.where(hits.found, numbers, 6 * _SHELL + 1).astype(np.int32)


def _seen_first(
    exact: NDArray[np.float32],
    pose: NDArray[np.float64],
    exact_first: NDArray[np.float32],
    pose_first: NDArray[np.float64],
    camera: CameraIntrinsics,
) -> NDArray[np.int64]:
    """Return the index of the first frame's pixel that shows the same point, by exact depth; -1 without one."""
    rows, columns = np.indices(exact.shape)
    points = camera.points(columns, rows, exact)
    motion = pose_first @ np.linalg.inv(pose)
    there = points @ motion[:3, :3].T + motion[:3, 3]
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = (
            camera.fx * there[..., 0] / there[..., 2] + camera.cx,
            camera.fy * there[..., 1] / there[..., 2] + camera.cy,
        )
        inside = (x > -0.5) & (y > -0.5) & (x < exact.shape[1] - 0.5) & (y < exact.shape[0] - 0.5)
        inside &= there[..., 2] > 0.05
    column, row = (np.where(inside, np.rint(np.nan_to_num(one)), 0).astype(np.int64) for one in (x, y))
    with np.errstate(invalid="ignore"):
        same = inside & (np.abs(exact_first[row, column] - there[..., 2]) < 0.015 * there[..., 2])
    return np.where(same, row * exact.shape[1] + column, -1)


MOVING = "moving"
PATHS = {"orbit": orbit, "dolly": dolly, "hand": hand, MOVING: hand, "still": still}
