"""Real frames, Fig. 7 and 8: raw, completed, and as clouds; and a halogen-like spot cut out of known depth."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import read_json
from ...completion.completion import prepare
from ...completion.interpolation import nearest
from ...data.camera import CameraIntrinsics
from ...data.frame import RGBDFrame
from ...data.parameters import PAPER_BLOCKS, PRESETS
from ...data.points import point_cloud
from ...drawing.clouds import Look, OrbitCamera, splat
from ...errors import FormatError, IlfError, InputError
from ...evaluation.bench.methods import METHODS
from ...evaluation.metrics import measure_errors
from ...run.run import complete
from ...segmentation.extraction import extract_blocks
from ...sources.frames import META_NAME
from .experiment import (
    METHOD_PRESETS,
    Comparison,
    Drawing,
    OnProgress,
    Result,
    Row,
    Settings,
    preset_parameters,
    run_counted,
)
from .plots import colour_of, counted, legend, millimetres, named, panels, percent
from .sources import QUICK_FRAMES, FrameSource, find_sources, load_source, spread
from .spots import DIAMETER, NOMINAL_FOCAL, find_spot, with_spot
from .table import PEERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Pictures of depth and of point clouds.

_MISSING = np.array([38, 38, 42], np.uint8)
_EMPTY = (250, 250, 250)

_YAW, _PITCH = math.radians(22), math.radians(14)
"""Angles of the view of the cloud."""

_NEAR_SHARE, _FAR_SHARE = 2.0, 98.0
"""Percentiles of the depth at the ends of the colour range."""


def depth_range(depth: NDArray[np.floating]) -> tuple[float, float]:
    """Return the colour range, nearest and farthest depth [m]."""
    near, far = np.nanpercentile(depth, [_NEAR_SHARE, _FAR_SHARE])
    return float(near), float(max(far, near + 1e-3))


def depth_picture(depth: NDArray[np.floating], between: tuple[float, float]) -> NDArray[np.uint8]:
    """Colour-code depth, uint8 (H, W, 3); missing depth is nearly black."""
    import matplotlib

    share = (depth - between[0]) / (between[1] - between[0])
    colours = matplotlib.colormaps["viridis_r"](np.nan_to_num(np.clip(share, 0, 1)), bytes=True)[..., :3]
    return np.where(np.isfinite(depth)[..., None], colours, _MISSING)


def thumbnail(picture: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """Reduce a picture to a maximum width by subsampling, because depth colours must not be mixed."""
    step = max(1, math.ceil(picture.shape[1] / width))
    return np.ascontiguousarray(picture[::step, ::step])


def cloud_picture(frame: RGBDFrame, depth: NDArray[np.floating], focal: float, width: int) -> NDArray[np.uint8]:
    """Render the cloud of a depth image from the side and above, nearest points in front.

    Parameters
    ----------
    frame : RGBDFrame
        Gives the colours; the view is fitted to its known depth, whatever `depth` is.
    depth : ndarray of float, shape (H, W)
        [m], NaN = missing.
    focal : float
        Focal length [px].
    width : int
        Of the picture [px].
    """
    height = round(width * frame.shape[0] / frame.shape[1])
    rows, columns = frame.shape
    lens = CameraIntrinsics(focal, focal, (columns - 1) / 2, (rows - 1) / 2)
    given = point_cloud(frame.depth, frame.rgb, lens)
    camera = OrbitCamera(yaw=-_YAW, pitch=_PITCH).fitted(given.points, width / height)
    cloud = point_cloud(depth, frame.rgb, lens)
    return splat(cloud.points, cloud.colours, Look(camera, width, height, _EMPTY)).picture


_FRAMES = 8
"""Number of frames shown, of as many sensors as possible."""

_RENDERED = "synthetic"
"""Part of the sensor's name if a frame is not real."""

_WIDTH = 240
"""Width of the pictures [px]."""

COMPLETED, SPOT = "completed", "spot"
GIVEN = "given"
SPOT_PICTURE = "/spot/"

_Picture = NDArray[np.uint8]


@dataclass
class _Part:
    rows: list[Row] = field(default_factory=list)
    pictures: dict[str, _Picture] = field(default_factory=dict)
    skip_reason: str = ""


def run_real(settings: Settings, on_progress: OnProgress) -> Result:
    """Complete frames, and measure the error in a spot cut out of each."""
    sources = find_sources(settings)
    chosen = _by_sensor(sources.frames, QUICK_FRAMES if settings.quick else _FRAMES)
    methods = METHOD_PRESETS if settings.quick else (*METHOD_PRESETS, *PEERS)
    units = [(source, sensor, methods) for source, sensor in chosen]
    parts = run_counted(_run_unit, units, settings.jobs, on_progress)
    rows = [row for part in parts for row in part.rows]
    if not rows:
        raise InputError(f"No frame could be completed. {'; '.join(part.skip_reason for part in parts)}")
    notes = [
        f"{source.name}: {part.skip_reason}"
        for (source, _), part in zip(chosen, parts, strict=True)
        if part.skip_reason
    ]
    nominal = sorted({row["frame"] for row in rows if row.get("nominal_focal")})
    if nominal:
        notes.append(
            f"{', '.join(nominal)}: no intrinsics, so a nominal focal length of {NOMINAL_FOCAL:g} image widths is used."
        )
    return Result(
        rows=rows,
        parameters={
            "frames": [source.name for source, _ in chosen],
            "sample": settings.data is None,
            "spot_diameter_m": DIAMETER,
            "extraction": PAPER_BLOCKS.to_dict(),
            "presets": preset_parameters(),
            "chosen": "The paper's frames are not published. Here: the first frame of every sensor, up to "
            f"{_FRAMES}. The spot lies where the depth is known and smoothest; of places about as smooth, at the one "
            "nearest to the camera. Colour is unchanged, and for the presets also saturated as by a lamp (glare). "
            "Blocks are extracted from the frame with the spot.",
        },
        notes=[*sources.notes, *notes],
        pictures={name: picture for part in parts for name, picture in part.pictures.items()},
    )


def _by_sensor(sources: Sequence[FrameSource], count: int) -> list[tuple[FrameSource, str]]:
    """Select frames with their sensors: the first of every sensor, then others evenly up to `count`."""
    sensors = {source: _sensor(source) for source in sources}
    if any(_RENDERED not in sensor for sensor in sensors.values()):
        sensors = {source: sensor for source, sensor in sensors.items() if _RENDERED not in sensor}
    sources = list(sensors)
    first = {sensor: source for source, sensor in reversed(sensors.items())}
    chosen = spread([source for source in sources if first[sensors[source]] == source], count)
    rest = [source for source in sources if source not in chosen]
    if rest and len(chosen) < count:
        chosen += spread(rest, count - len(chosen)) if count - len(chosen) > 1 else rest[:1]
    return [(source, sensors[source]) for source in chosen]


def _sensor(source: FrameSource) -> str:
    """The sensor in meta.json, without text in brackets."""
    if source.index is not None:
        return "Kinect v1"
    try:
        meta = read_json(source.path / META_NAME)
    except (InputError, FormatError):
        return "unknown sensor"  # reading the frame reports the error
    sensor = meta.get("sensor") if isinstance(meta, dict) else None
    return str(sensor or "unknown sensor").split("(")[0].strip()


def _run_unit(source: FrameSource, sensor: str, methods: Sequence[str]) -> _Part:
    part = _Part()
    try:
        frame = load_source(source).frame
    except IlfError as error:
        part.skip_reason = str(error)
        return part
    nominal = frame.intrinsics is None
    focal = NOMINAL_FOCAL * frame.shape[1] if frame.intrinsics is None else frame.intrinsics.fx
    common = {"frame": source.name, "sensor": sensor, "nominal_focal": nominal}
    _complete(part, frame, focal, common)
    try:
        _measure_spot(part, frame, methods, common)
    except IlfError as error:
        part.skip_reason = f"No spot. {error}"
    return part


def _complete(part: _Part, frame: RGBDFrame, focal: float, common: Row) -> None:
    """Complete the unchanged frame by every preset: rows, and pictures "frame/what/method"."""
    labels = extract_blocks(frame, PAPER_BLOCKS)
    between = depth_range(frame.depth)
    name = common["frame"]
    part.pictures[f"{name}/colour/"] = thumbnail(frame.rgb, _WIDTH)
    part.pictures[f"{name}/depth/{GIVEN}"] = thumbnail(depth_picture(frame.depth, between), _WIDTH)
    part.pictures[f"{name}/cloud/{GIVEN}"] = cloud_picture(frame, frame.depth, focal, _WIDTH)
    for method in METHOD_PRESETS:
        prepare(frame, PRESETS[method])
        started = time.perf_counter()
        completion = complete(frame, labels, PRESETS[method])
        seconds = time.perf_counter() - started
        missing = np.count_nonzero(~frame.known)
        part.rows.append({
            "method": method, "part": COMPLETED, **common, "defect_rate": frame.missing_share,
            "recovered": float(np.count_nonzero(completion.filled) / missing) if missing else None,
            "blocks": len(completion.outcomes), "seconds": seconds,
        })  # fmt: skip
        part.pictures[f"{name}/depth/{method}"] = thumbnail(depth_picture(completion.depth, between), _WIDTH)
        part.pictures[f"{name}/cloud/{method}"] = cloud_picture(frame, completion.depth, focal, _WIDTH)


def _measure_spot(part: _Part, frame: RGBDFrame, methods: Sequence[str], common: Row) -> None:
    spot = find_spot(frame)
    hole = spot.inside(frame.shape)
    for glare in (False, True):
        gapped = with_spot(frame, spot, glare)
        labels = extract_blocks(gapped, PAPER_BLOCKS)
        for method in METHOD_PRESETS if glare else methods:
            started = time.perf_counter()
            try:
                depth = METHODS[method].run(gapped, labels)
            except (IlfError, MemoryError):
                depth = gapped.depth  # failing counts as filling nothing
            seconds = time.perf_counter() - started
            covered = np.isfinite(depth) & (depth > 0)
            errors = measure_errors(np.where(covered, depth, nearest(gapped)), frame.depth, hole)
            part.rows.append({
                "method": method, "part": SPOT, **common, "defect_rate": gapped.missing_share, "glare": glare,
                "acc_mm": 1000 * errors.acc, "prs_mm": 1000 * errors.prs, "rmse_mm": 1000 * errors.rmse,
                "mae_mm": 1000 * errors.mae, "rel": errors.rel, "covered": float(np.mean(covered[hole])),
                "spot_depth_m": spot.depth, "spot_radius_px": spot.radius, "roughness_mm": 1000 * spot.roughness,
                "seconds": seconds,
            })  # fmt: skip
        if glare:
            part.pictures[f"{common['frame']}{SPOT_PICTURE}"] = _spot_picture(gapped, hole)


def _spot_picture(frame: RGBDFrame, hole: NDArray[np.bool_]) -> _Picture:
    """The colour image with glare and the spot's rim."""
    rgb = frame.rgb.copy()
    rim = hole & ~(np.roll(hole, 3, 0) & np.roll(hole, -3, 0) & np.roll(hole, 3, 1) & np.roll(hole, -3, 1))
    rgb[rim] = (209, 73, 91)
    return thumbnail(rgb, _WIDTH)


# Figures and comparison texts of the experiment on real frames.

_ROWS_SHOWN, _SPOTS_A_ROW = 8, 4

_COMPLETE_SHARE = 0.9995
"""Share of recovered pixels from which a frame counts as complete."""


def draw_real(result: Result) -> list[Drawing]:
    """Draw frames and clouds, raw and completed, the spots, and the errors in them."""
    frames = list(dict.fromkeys(row["frame"] for row in result.rows))[:_ROWS_SHOWN]
    names = {row["frame"]: f"{row['frame']}\n{row['sensor']}" for row in result.rows}
    methods = [GIVEN, *METHOD_PRESETS]
    depths = ["colour/", *(f"depth/{method}" for method in methods)]
    clouds = [f"cloud/{method}" for method in methods]
    shows_data = not result.parameters["sample"]
    drawings = [
        Drawing(
            "depth",
            "Colour, raw depth (black: missing), and depth completed by the presets. Depth that no block could "
            "complete stays missing.",
            _grid(result, frames, depths, ["colour", *methods], names),
            shows_data,
        ),
        Drawing(
            "cloud",
            "The same as point clouds, seen from the side and above.",
            _grid(result, frames, clouds, methods, names),
            shows_data,
        ),
    ]
    rows = [row for row in result.rows if row["part"] == SPOT]
    if rows:
        drawings += [_draw_spot_places(result, shows_data), _draw_spot_errors(rows)]
    return drawings


def _grid(
    result: Result, frames: Sequence[str], keys: Sequence[str], titles: Sequence[str], names: dict[str, str]
) -> Figure:
    """Draw one row of pictures per frame, one column per key."""
    figure, axes = panels(len(frames), len(keys), width=1.9, height=1.5)
    for place, ax in enumerate(axes):
        line, column = divmod(place, len(keys))
        _show(ax, result.pictures[f"{frames[line]}/{keys[column]}"])
        if line == 0:
            ax.set_title(titles[column], fontsize=8)
        if column == 0:
            ax.set_ylabel(names[frames[line]], fontsize=6)
    return figure


def _show(ax: Axes, picture: NDArray[np.uint8]) -> None:
    ax.imshow(picture, interpolation="nearest")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)
    ax.grid(False)


def _draw_spot_places(result: Result, shows_data: bool) -> Drawing:
    shown = [name for name in result.pictures if name.endswith(SPOT_PICTURE)]
    columns = min(len(shown), _SPOTS_A_ROW)
    figure, axes = panels(math.ceil(len(shown) / columns), columns, width=2.4, height=2.0)
    for ax in axes[len(shown) :]:
        ax.set_visible(False)
    for ax, name in zip(axes, shown, strict=False):
        _show(ax, result.pictures[name])
        ax.set_title(name.removesuffix(SPOT_PICTURE), fontsize=8)
    return Drawing("spots", "The spots of 15 cm, here with glare; red: rim of the removed depth.", figure, shows_data)


def _draw_spot_errors(rows: list[Row]) -> Drawing:
    methods = sorted(
        dict.fromkeys(row["method"] for row in rows), key=lambda name: _mean(rows, name, False), reverse=True
    )
    figure, (ax,) = panels(1, 1, width=7.0, height=4.4)
    for place, method in enumerate(methods):
        colour = colour_of(method) if method in PRESETS else "#98a1ab"
        for glare, offset, marker in ((False, 0.17, "o"), (True, -0.17, "x")):
            values = [row["rmse_mm"] for row in rows if row["method"] == method and row["glare"] == glare]
            if not values:
                continue
            ax.plot(values, [place + offset] * len(values), marker, color=colour, markersize=3.5, alpha=0.6)
            ax.plot(_mean(rows, method, glare), place + offset, "|", color=colour, markersize=11, markeredgewidth=2)
    for marker, label in (("o", "colour as it is"), ("x", "with glare (presets only)")):
        ax.plot([], [], marker, color="#555555", markersize=4, label=label)
    ax.set_yticks(range(len(methods)), methods)
    ax.set_xscale("log")
    ax.set_xlabel("RMSE in the spot [mm]; bars: mean of the frames")
    legend(figure, ax)
    return Drawing("errors", "Error of the completed depth in a round spot of 15 cm: single frames and mean.", figure)


def _mean(rows: Sequence[Row], method: str, glare: bool) -> float:
    return float(np.mean([row["rmse_mm"] for row in rows if row["method"] == method and row["glare"] == glare]))


def compare_real(rows: list[Row]) -> list[Comparison]:
    """Report the recovered share and the error in the spot; the paper has only pictures here."""
    whole = [row for row in rows if row["part"] == COMPLETED]
    spots = [row for row in rows if row["part"] == SPOT]
    comparisons = [_recovered(whole, method) for method in METHOD_PRESETS]
    methods = list(dict.fromkeys(row["method"] for row in spots))
    return comparisons + [_spot(spots, methods, method) for method in METHOD_PRESETS if spots]


def _recovered(rows: list[Row], method: str) -> Comparison:
    mine = [row for row in rows if row["method"] == method and row["recovered"] is not None]
    if not mine:
        return Comparison(
            f"Missing depth recovered, {method}", "pictures only", "nothing was missing", "No frame has holes."
        )
    shares = [row["recovered"] for row in mine]
    least = min(mine, key=lambda row: row["recovered"])
    left = "No frame has missing depth left."
    if least["recovered"] < _COMPLETE_SHARE:
        left = (
            f"Minimum: {percent(round(least['recovered'], 3))} in {least['frame']}; the rest lies in no block, or in a "
        )
        left += "block without enough known depth."
    return Comparison(
        f"Missing depth recovered, {method}",
        "pictures only",
        f"{percent(round(float(np.mean(shares)), 3))} of the missing pixels, mean of {counted(len(mine), 'frame')}",
        f"{left} Pictures do not show its accuracy; see the table.",
    )


def _spot(rows: list[Row], methods: list[str], method: str) -> Comparison:
    plain, glare = _mean(rows, method, False), _mean(rows, method, True)
    frames = len({row["frame"] for row in rows})
    rivals = [name for name in methods if name != method]
    better = [name for name in rivals if _mean(rows, name, False) < plain]
    text = f"RMSE, mean of {counted(frames, 'frame')}. Without glare "
    if better:
        text += f"{named(better, len(rivals))} {'is' if len(better) == 1 else 'are'} more accurate."
    else:
        text += f"it is the lowest of {len(methods)} methods."
    change = glare / plain
    if change > 1.1:
        text += f" Glare in the colour image makes it {change:.1f} times as large, "
        text += "because colour edges such as the glare's rim become boundaries."
    elif change < 0.9:
        text += f" Glare in the colour image makes it smaller ({percent(round(1 - change, 3))})."
    else:
        text += " Glare in the colour image changes it little."
    return Comparison(
        f"15 cm spot, {method}",
        "pictures only",
        f"{millimetres(plain)}; with glare {millimetres(glare)}",
        text,
    )
