"""`ilf info`: what there is in a frame's files or in a run record."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..declarations import ParameterSet
from ..errors import InputError
from ..frame import CameraIntrinsics, check_depth_scale
from ..io import default_depth_units, frame_folder, read_colour, read_depth_values
from ..io.camera_files import intrinsics_from
from ..io.depth_files import depth_in_metres
from ..parameters import PRESETS, BlockParameters
from ..run.record import RunRecord, read_run_record
from .parsing import Commands, UsageError, add_frame
from .report import outcome_lines


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "info",
        help="show what is in a frame or in a run record",
        usage="ilf info (RGB [DEPTH] | FOLDER | run.json) [options]",
        description="Show sizes, depth range, missing share, units and intrinsics of a frame, or a run record.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    add_frame(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    inputs = [Path(path) for path in arguments.inputs]
    if len(inputs) == 1 and inputs[0].suffix.lower() == ".json":
        record = read_run_record(inputs[0])
        _print_facts(_record_facts(record))
        print("", *outcome_lines(record.outcomes), sep="\n")
    elif len(inputs) == 1 and inputs[0].is_dir():
        files = frame_folder(inputs[0])
        units = arguments.depth_units or files.depth_units
        _print_facts([
            ("name", files.name),
            ("colour", _colour(files.rgb)),
            *_depth_facts(files.depth, units, arguments.intrinsics or files.intrinsics),
        ])  # fmt: skip
    elif len(inputs) in {1, 2}:
        facts = [("colour", _colour(inputs[0]))]
        if len(inputs) == 2:
            facts += _depth_facts(inputs[1], arguments.depth_units, arguments.intrinsics)
        _print_facts(facts)
    else:
        raise UsageError("Give a colour and a depth file, one folder, or a run.json.")


def _colour(path: Path) -> str:
    rgb = read_colour(path)
    return f"{path}, {rgb.shape[1]} x {rgb.shape[0]}"


def _depth_facts(path: Path, units: float | None, camera: str | CameraIntrinsics | None) -> list[tuple[str, str]]:
    values = read_depth_values(path)
    scale = default_depth_units(values) if units is None else units
    metres = depth_in_metres(values, scale)
    known = metres[np.isfinite(metres)]
    facts = [
        ("depth", f"{path}, {values.shape[1]} x {values.shape[0]}, {values.dtype}"),
        ("depth units", f"{scale:g} per metre" + (" (assumed; --depth-units sets it)" if units is None else "")),
        ("missing", f"{1 - known.size / metres.size:.1%}"),
    ]
    if known.size:
        low, high = float(known.min()), float(known.max())
        facts.append(("range", f"{low:.3f} to {high:.3f} m, median {float(np.median(known)):.3f} m"))
    intrinsics = intrinsics_from(camera, metres.shape)
    facts.append(("intrinsics", _camera(intrinsics)))
    try:
        check_depth_scale(metres)
    except InputError as error:
        facts.append(("problem", str(error)))
    return facts


def _camera(camera: CameraIntrinsics | None) -> str:
    if camera is None:
        return "not known"
    name = f" ({camera.name})" if camera.name else ""
    return f"fx {camera.fx:g}, fy {camera.fy:g}, cx {camera.cx:g}, cy {camera.cy:g}{name}"


def _print_facts(facts: Iterable[tuple[str, str]]) -> None:
    for name, fact in facts:
        print(f"{name + ':':13} {fact}")


def _record_facts(record: RunRecord) -> list[tuple[str, str]]:
    facts = [
        ("made with", f"ILF Studio {record.version}, " + ", ".join(f"{k} {v}" for k, v in record.versions.items()))
    ]
    if record.inputs is None:
        facts.append(("frame", "not read from files, so the run cannot be replayed"))
    else:
        facts += [
            ("colour", record.inputs.rgb.path),
            ("depth", record.inputs.depth.path),
            ("depth units", f"{record.inputs.depth_units:g} per metre"),
            ("intrinsics", _camera(intrinsics_from(record.inputs.intrinsics))),
        ]
    origin = "given as a label map" if record.extraction is None else "edited" if record.edited else "extracted"
    facts.append(("blocks", f"{len(record.outcomes)} run, {record.shape[1]} x {record.shape[0]}, {origin}"))
    if record.extraction is not None:
        facts.append(("extraction", _changes(record.extraction, BlockParameters()) or "defaults"))
    name, changes = min(
        ((name, _changes(record.common, values)) for name, values in PRESETS.items()), key=lambda item: len(item[1])
    )
    facts.append(("parameters", f"preset {name}" + (f" with {changes}" if changes else "")))
    facts += [
        (f"block {label}", _changes(own, record.common))
        for label, own in record.parameters.items()
        if own != record.common
    ]
    return [*facts, ("files", ", ".join(record.options.filenames()))]


def _changes(values: ParameterSet, base: ParameterSet) -> str:
    usual = base.to_dict()
    return ", ".join(f"{name} {value}" for name, value in values.to_dict().items() if value != usual[name])
