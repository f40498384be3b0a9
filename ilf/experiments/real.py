"""Real frames, Fig. 7 and 8: raw, completed, their clouds; and a halogen-like spot punched into known depth."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..bench.methods import METHODS
from ..bench.peers.interpolation import nearest
from ..completion import complete, prepare
from ..ebs import extract_blocks
from ..errors import FormatError, IlfError, InputError
from ..frame import RGBDFrame
from ..io.files import read_json
from ..io.frames import META_NAME
from ..metrics import measure_errors
from ..parameters import PAPER_BLOCKS, PRESETS
from .experiment import METHOD_PRESETS, OnProgress, Result, Row, Settings, preset_parameters
from .rendering import cloud_picture, depth_picture, depth_range, thumbnail
from .sources import QUICK_FRAMES, FrameSource, find_sources, load_source, spread
from .spots import DIAMETER, NOMINAL_FOCAL, find_spot, with_spot
from .table import PEERS
from .units import run_counted

_FRAMES = 8
"""Frames that are shown, of as many sensors as there are."""

_RENDERED = "synthetic"
"""In the sensor's name where a frame is not real."""

_WIDTH = 240
"""Of the pictures [px]."""

COMPLETED, SPOT = "completed", "spot"
GIVEN = "given"
SPOT_PICTURE = "/spot/"

_Picture = NDArray[np.uint8]


@dataclass
class _Part:
    rows: list[Row] = field(default_factory=list)
    pictures: dict[str, _Picture] = field(default_factory=dict)
    left_out: str = ""


def run_real(settings: Settings, on_progress: OnProgress) -> Result:
    """Complete frames, and measure the error in a spot punched into each."""
    sources = find_sources(settings)
    chosen = _by_sensor(sources.frames, QUICK_FRAMES if settings.quick else _FRAMES)
    methods = METHOD_PRESETS if settings.quick else (*METHOD_PRESETS, *PEERS)
    units = [(source, sensor, methods) for source, sensor in chosen]
    parts = run_counted(_run_unit, units, settings.jobs, on_progress)
    rows = [row for part in parts for row in part.rows]
    if not rows:
        raise InputError(f"No frame could be completed: {'; '.join(part.left_out for part in parts)}")
    notes = [
        f"{source.name}: {part.left_out}" for (source, _), part in zip(chosen, parts, strict=True) if part.left_out
    ]
    nominal = sorted({row["frame"] for row in rows if row.get("nominal_focal")})
    if nominal:
        notes.append(
            f"No intrinsics come with {', '.join(nominal)}: a nominal focal length of {NOMINAL_FOCAL:g} image widths "
            "is used."
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
            "nearest to the camera. Once colour is left as it is; once, for the presets, it is saturated as by a lamp "
            "(glare). Blocks come from the frame with the spot.",
        },
        notes=[*sources.notes, *notes],
        pictures={name: picture for part in parts for name, picture in part.pictures.items()},
    )


def _by_sensor(sources: Sequence[FrameSource], count: int) -> list[tuple[FrameSource, str]]:
    """Frames and their sensors: the first of every sensor, then, if there is room, the others evenly."""
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
    """The sensor as meta.json names it, without what is in brackets."""
    if source.index is not None:
        return "Kinect v1"
    try:
        meta = read_json(source.path / META_NAME)
    except (InputError, FormatError):
        return "unknown sensor"  # the frame itself will say what is wrong
    sensor = meta.get("sensor") if isinstance(meta, dict) else None
    return str(sensor or "unknown sensor").split("(")[0].strip()


def _run_unit(source: FrameSource, sensor: str, methods: Sequence[str]) -> _Part:
    part = _Part()
    try:
        frame = load_source(source).frame
    except IlfError as error:
        part.left_out = str(error)
        return part
    nominal = frame.intrinsics is None
    focal = NOMINAL_FOCAL * frame.shape[1] if frame.intrinsics is None else frame.intrinsics.fx
    common = {"frame": source.name, "sensor": sensor, "nominal_focal": nominal}
    _complete(part, frame, focal, common)
    try:
        _measure_spot(part, frame, methods, common)
    except IlfError as error:
        part.left_out = f"No spot. {error}"
    return part


def _complete(part: _Part, frame: RGBDFrame, focal: float, common: Row) -> None:
    """The frame as it is, completed by every preset: rows, and pictures "frame/what/method"."""
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
    """The colour image with glare, the spot's rim drawn in."""
    rgb = frame.rgb.copy()
    rim = hole & ~(np.roll(hole, 3, 0) & np.roll(hole, -3, 0) & np.roll(hole, 3, 1) & np.roll(hole, -3, 1))
    rgb[rim] = (209, 73, 91)
    return thumbnail(rgb, _WIDTH)
