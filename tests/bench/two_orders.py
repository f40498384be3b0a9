"""Fill first or align first: depth of two cameras completed in either order, against exact depth in the colour camera.

    python -m tests.bench.two_orders [FOLDER:KEY ...] [--rigs 3] [--scenes 2] [--scale 0.5]

A generated room is rendered into the cameras of each rig, without lens distortion and with the holes of a
structured-light camera; truth ends at its range. In frames of recordings (`FOLDER:KEY`) a quarter of the known depth,
in areas, is hidden. Errors are those of pixels that the depth camera has not measured, in view of it, and that all
orders fill. librealsense's align keeps a pixel's depth as it is along the depth camera's axis; `register` changes it to
that along the colour camera's.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf._runtime.installation import asset_path
from ilf.errors import InputError
from ilf.evaluation.hold_out import hidden_pixels
from ilf.sources.realsense import load_realsense
from ilf.sources.registration import RawPair, aligned, projected_depth, register

Depth = NDArray[np.float32]


@dataclass(frozen=True)
class Rig:
    """Sizes and focal lengths [px] of the depth and the colour camera, and the way between them [m, degrees]."""

    depth: tuple[int, int, float]
    colour: tuple[int, int, float]
    shift: float
    tilt: float = 0.0


RIGS = {
    "stereo, 15 mm": Rig((848, 480, 424.0), (1280, 720, 920.0), 0.015),
    "time of flight, 32 mm": Rig((640, 576, 504.0), (1280, 720, 610.0), 0.032, 6.0),
    "structured light, 75 mm": Rig((640, 480, 580.0), (640, 480, 525.0), 0.075),
}


@dataclass(frozen=True)
class Scene:
    """A raw pair, and true depth [m] in the colour camera, NaN = unknown."""

    pair: RawPair
    truth: Depth


def camera_of(size: tuple[int, int, float], scale: float) -> ilf.Camera:
    """Return a camera whose axis goes through the middle of its image."""
    width, height = round(scale * size[0]), round(scale * size[1])
    focal = scale * size[2]
    return ilf.Camera(focal, focal, (width - 1) / 2, (height - 1) / 2, size=(width, height))


def rendered(rig: Rig, number: int, scale: float) -> Scene:
    """Render the room of a number from a place of its own."""
    sys.path.insert(0, str(asset_path("samples")))
    import make_room
    from roomkit import picture, sensor

    rng = np.random.default_rng([number, 5])
    depth_camera, colour_camera = camera_of(rig.depth, scale), camera_of(rig.colour, scale)
    room = make_room.furnished(7 + number)
    placed = turned(room.camera, 0.0, rng.uniform(-10, 10))
    placed = replace(placed, position=placed.position + rng.uniform(-0.2, 0.2, 3))
    room = replace(room, camera=placed)
    tilted = turned(replace(placed, position=placed.position + rig.shift * placed.right), rig.tilt, 0.0)
    of_colour = replace(room, camera=tilted)
    rows = np.stack([tilted.right, tilted.down, tilted.forward]), np.stack([placed.right, placed.down, placed.forward])
    depth_to_colour = np.eye(4)
    depth_to_colour[:3, :3] = rows[0] @ rows[1].T
    depth_to_colour[:3, 3] = rows[0] @ (placed.position - tilted.position)

    hits, views = cast(room, depth_camera)
    shape = depth_camera.shape
    with np.errstate(invalid="ignore"):  # of rays that leave the room
        holes = np.any([*sensor.holes(room, hits, views, shape, rng).values()], axis=0)
        measured = sensor.measured(hits.distance.reshape(shape), depth_camera.numbers, rng)
    rgb = picture.developed(picture.render(of_colour, colour_camera.size, colour_camera.numbers, rng, finer=2), rng)
    truth = cast(of_colour, colour_camera)[0].distance.reshape(colour_camera.shape).astype(np.float32)
    pair = RawPair(rgb, np.where(holes, np.nan, measured), colour_camera, depth_camera, depth_to_colour)
    return Scene(pair, np.where(truth < sensor.FARTHEST, truth, np.float32(np.nan)))


def turned(camera: Any, down: float, right: float) -> Any:
    """Turn a camera of the room by angles [degrees]."""
    turn, _ = cv2.Rodrigues(np.radians([-down, right, 0.0]))
    axes = turn @ np.stack([camera.right, camera.down, camera.forward])
    return replace(camera, right=axes[0], down=axes[1], forward=axes[2])


def cast(room: Any, camera: ilf.Camera) -> tuple[Any, NDArray[np.float64]]:
    """Return what the rays through a camera's pixels hit, and these rays."""
    rows, columns = np.indices(camera.shape)
    views = room.camera.directions(columns.ravel(), rows.ravel(), camera.numbers)
    return room.scene.cast(np.broadcast_to(room.camera.position, views.shape), views), views


def recorded(place: str) -> Scene:
    """Hide areas of the depth of a raw pair; what was hidden, brought to colour, is the truth."""
    path, _, key = place.rpartition(":")
    pair = undistorted(ilf.open_source(path).read_pair(key))
    hidden = hidden_pixels(register(pair, "depth"), "areas", 0)
    left, taken = (np.where(mask, np.nan, pair.depth) for mask in (hidden, ~hidden))
    truth = projected_depth(np.float32(taken), pair.depth_camera, pair.colour_camera, pair.depth_to_colour)
    return Scene(replace(pair, depth=left), truth)


def undistorted(pair: RawPair) -> RawPair:
    """Return a pair whose lenses do not distort, since librealsense's own models are others."""
    colour, depth = register(pair), register(pair, "depth")
    cameras = [replace(one.intrinsics, size=one.shape[::-1]) for one in (colour, depth)]
    view = None if depth.outside_view is None else ~depth.outside_view
    return RawPair(colour.rgb, depth.depth, *cameras, pair.depth_to_colour, pair.name, depth_view=view)


def by_librealsense(pair: RawPair, depth: Depth) -> Depth:
    """Align depth of a pair's depth camera to colour by librealsense, in steps of 0.1 mm."""
    library = load_realsense()
    device, syncer = library.software_device(), library.syncer()
    profiles, sensors, kept = [], [], []
    values = np.rint(10000 * np.nan_to_num(depth)).astype(np.uint16)
    for name, camera, kind, pixels, bytes_each in (
        ("depth", pair.depth_camera, library.format.z16, values, 2),
        ("color", pair.colour_camera, library.format.rgb8, pair.rgb, 3),
    ):
        seen, stream = library.intrinsics(), library.video_stream()
        (seen.height, seen.width), seen.fx, seen.fy = camera.shape, camera.fx, camera.fy
        seen.ppx, seen.ppy, seen.model, seen.coeffs = camera.cx, camera.cy, library.distortion.none, [0.0] * 5
        stream.type, stream.index, stream.uid, stream.fps = getattr(library.stream, name), 0, bytes_each, 30
        stream.width, stream.height, stream.bpp = seen.width, seen.height, bytes_each
        stream.fmt, stream.intrinsics = kind, seen
        sensor = device.add_sensor(name)
        if name == "depth":
            sensor.add_read_only_option(library.option.depth_units, 1e-4)
        profiles.append(sensor.add_video_stream(stream))
        sensors.append(sensor)
        kept.append(np.ascontiguousarray(pixels))  # the library does not copy them
    motion = library.extrinsics()
    motion.rotation = pair.depth_to_colour[:3, :3].T.ravel().tolist()  # column by column
    motion.translation = pair.depth_to_colour[:3, 3].tolist()
    profiles[0].register_extrinsics_to(profiles[1], motion)
    device.create_matcher(library.matchers.default)
    for sensor in sensors:
        sensor.open(sensor.get_stream_profiles())
        sensor.start(syncer)
    for number in range(2):
        for sensor, profile, pixels, bytes_each in zip(sensors, profiles, kept, (2, 3), strict=True):
            frame = library.software_video_frame()
            frame.pixels, frame.bpp, frame.stride = pixels, bytes_each, bytes_each * pixels.shape[1]
            frame.timestamp, frame.frame_number = 33.0 * number, number
            frame.domain, frame.profile = library.timestamp_domain.system_time, profile.as_video_stream_profile()
            if bytes_each == 2:
                frame.depth_units = 1e-4
            sensor.on_video_frame(frame)
    frames = syncer.wait_for_frames(2000)
    while not (frames.get_depth_frame() and frames.get_color_frame()):
        frames = syncer.wait_for_frames(2000)
    found = np.asanyarray(library.align(library.stream.color).process(frames).get_depth_frame().get_data()) / 10000
    for sensor in sensors:
        sensor.stop()
        sensor.close()
    return np.where(found > 0, found, np.nan).astype(np.float32)


def results(scene: Scene) -> Iterator[tuple[str, Depth]]:
    """Complete a scene in every order; depth in the colour camera [m]."""
    pair = scene.pair
    in_colour, in_depth = register(pair), register(pair, "depth")
    yield "align, fill", ilf.complete(in_colour).depth
    filled = ilf.complete(in_depth).depth
    brought = aligned(filled, in_depth)
    yield "fill, align", brought
    both = ilf.RGBDFrame(pair.rgb, brought, in_colour.intrinsics, outside_view=in_colour.outside_view)
    yield "fill, align, fill", ilf.complete(both).depth
    try:
        theirs = ilf.RGBDFrame(pair.rgb, by_librealsense(pair, pair.depth), in_colour.intrinsics)
    except InputError as error:
        print(f"librealsense is left out: {error}", file=sys.stderr)
        return
    theirs = replace(theirs, outside_view=in_colour.outside_view)
    yield "librealsense's align, fill", ilf.complete(theirs).depth
    yield "fill, librealsense's align", by_librealsense(pair, filled)


def compare(what: str, scenes: list[Scene], say: Callable[[str], None]) -> None:
    """Print a line of the table for each order, over all scenes."""
    found: dict[str, list[tuple[float, float, float]]] = {}
    for scene in scenes:
        frame, depths = register(scene.pair), dict(results(scene))
        view = np.isfinite(scene.truth) & frame.missing
        shared = view & np.all([np.isfinite(depth) for depth in depths.values()], axis=0)
        for name, depth in depths.items():
            off = 1000 * np.abs(depth - scene.truth)[shared].astype(np.float64)
            missing = np.isnan(depth[view]).mean()
            found.setdefault(name, []).append((float(missing), float(np.median(off)), float(np.sqrt((off**2).mean()))))
    for name, figures in found.items():
        missing, median, rmse = np.mean(figures, axis=0)
        say(f"| {what} | {name} | {missing:.1%} | {median:.1f} / {rmse:.0f} |")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", nargs="*", metavar="FOLDER:KEY", help="raw pairs of recordings")
    parser.add_argument("--scenes", type=int, default=2, help="rendered scenes of each rig")
    parser.add_argument("--rigs", type=int, default=len(RIGS), help="number of rigs")
    parser.add_argument("--scale", type=float, default=0.5, help="of the rigs' images")
    options = parser.parse_args()
    print("| cameras | order | missing | error [mm], median / RMSE |\n|---|---|---|---|")
    for name, rig in list(RIGS.items())[: options.rigs]:
        scenes = [rendered(rig, number, options.scale) for number in range(options.scenes)]
        compare(name, scenes, lambda line: print(line, flush=True))
    for place in options.recordings:
        compare(place.rpartition("/")[2], [recorded(place)], lambda line: print(line, flush=True))


if __name__ == "__main__":
    main()
