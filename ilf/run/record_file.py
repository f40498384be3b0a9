"""Reading of run.json: every value is checked, with a clear error message."""

from __future__ import annotations

import math
import os
from pathlib import Path

from .._runtime.files import read_json
from .._runtime.schema import Section, check_schema, is_plain
from ..data.camera import checked_transform
from ..data.frame import FrameInputs, GroundTruthFile, InputFile
from ..data.parameters import BlockParameters, Parameters
from ..data.results import BlockOutcome, Status
from ..errors import FormatError, InputError, ParameterError
from ..io.encodings import encoding_of
from .options import DRAWN_FILE, GUIDE_FILE, INVALID_MASK_FILE, OUTSIDE_FILE, ExportOptions
from .record import PROGRAM, SCHEMA, RecordedGuide, RecordedMask, RunRecord


def read_record(path: str | os.PathLike[str]) -> RunRecord:
    """Read and check a run record. Unknown sections and keys are ignored.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is not JSON, not a run record, of another schema, incomplete, or has a value of the wrong type. Also for
        unknown parameters, because without them the run would be different.
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise FormatError(f"{Path(path).absolute()} is not a run record: give the run.json of an export.")
    try:
        check_schema(data, SCHEMA, "run record")
        return _parsed(Section("run record", data))
    except (InputError, ParameterError) as error:
        raise FormatError(f"{Path(path).absolute()}: {error}") from error


def _parsed(record: Section) -> RunRecord:
    blocks, networks, outputs = record.section("blocks"), record.section("networks"), record.texts("outputs")
    shape = blocks.items("shape", int)
    if len(shape) != 2:
        raise FormatError(f"'shape' in the blocks must be [height, width], not {shape}.")
    if not all(map(is_plain, outputs)):
        raise FormatError("'outputs' must have plain file names.")
    extraction = record.get("extraction", dict, type(None))
    inputs = record.get("inputs", dict, type(None))
    common = Parameters.from_dict(record.get("parameters", dict))
    own = record.section("block_parameters")
    outcomes = tuple(
        parsed_outcome(Section("blocks_outcome", values)) for values in record.items("blocks_outcome", dict)
    )
    return RunRecord(
        name=record.get("name", str),
        inputs=None if inputs is None else parsed_inputs(Section("inputs", inputs)),
        invalid_mask=_parsed_mask(record, "invalid_mask", INVALID_MASK_FILE),
        extraction=None if extraction is None else BlockParameters.from_dict(extraction),
        labels_sha256=blocks.get("sha256", str),
        shape=(shape[0], shape[1]),
        edited=blocks.get("edited", bool),
        labels_file=blocks.filename("file"),
        extraction_networks=networks.texts("extraction"),
        networks=networks.texts("filter"),
        parameters={
            outcome.label: common.replace(**own.get(str(outcome.label), dict))
            if str(outcome.label) in own.values
            else common
            for outcome in outcomes
        },
        common=common,
        extrapolate=record.get("extrapolate", bool),
        options=_parsed_options(record.section("export")),
        outcomes=outcomes,
        depth_sha256=record.get("depth_sha256", str),
        drawn=_parsed_mask(record, "drawn", DRAWN_FILE),
        outside_view=_parsed_mask(record, "outside_view", OUTSIDE_FILE),
        pose=_parsed_pose(record),
        guide=_parsed_guide(record),
        outputs=outputs,
        version=record.get("version", str),
        versions=record.texts("versions", type(None)),
        processor=record.get("processor", str),
    )


def _parsed_mask(record: Section, key: str, usual_file: str) -> RecordedMask | None:
    if record.get(key, dict, type(None)) is None:
        return None
    mask = record.section(key)
    return RecordedMask(mask.get("sha256", str), mask.filename("file") or usual_file)


def _parsed_pose(record: Section) -> tuple[tuple[float, ...], ...] | None:
    pose = record.get("pose", list, type(None))
    return None if pose is None else tuple(map(tuple, checked_transform(pose, "'pose' in the run record").tolist()))


def _parsed_guide(record: Section) -> RecordedGuide | None:
    mask = _parsed_mask(record, "guide", GUIDE_FILE)
    if mask is None:
        return None
    return RecordedGuide(mask.sha256, mask.file, record.section("guide").get("path", str, type(None)))


def parsed_inputs(inputs: Section) -> FrameInputs:
    """Parse a frame's files from their fields; FormatError for missing or wrong values."""
    rgb, depth = (
        InputFile(section.get("path", str), section.get("sha256", str))
        for section in (inputs.section("rgb"), inputs.section("depth"))
    )
    numbers = None if inputs.get("intrinsics", list, type(None)) is None else inputs.items("intrinsics", float)
    if numbers is not None and len(numbers) != 4:
        raise FormatError(f"'intrinsics' in the inputs must be [fx, fy, cx, cy], not {len(numbers)} numbers.")
    camera = None if numbers is None else (numbers[0], numbers[1], numbers[2], numbers[3])
    encoding = inputs.get("encoding", str, type(None))
    try:
        units = inputs.get("depth_units", float) if encoding is None else encoding_of(encoding).units
    except ParameterError as error:
        raise FormatError(f"There is no depth encoding {encoding!r:.60}.") from error
    return FrameInputs(
        rgb,
        depth,
        units,
        camera,
        _parsed_ground_truth(inputs),
        encoding,
        inputs.get("invalid", float, type(None)),
        inputs.get("frame", str, type(None)),
    )


def _parsed_ground_truth(inputs: Section) -> GroundTruthFile | None:
    if inputs.get("ground_truth", dict, type(None)) is None:
        return None
    ground_truth = inputs.section("ground_truth")
    return GroundTruthFile(
        ground_truth.get("path", str), ground_truth.get("sha256", str), ground_truth.get("units", float)
    )


def _parsed_options(options: Section) -> ExportOptions:
    return ExportOptions(
        depth_formats=tuple(options.items("depth_formats", str)),
        depth_units=options.get("depth_units", float),
        expected_error=options.get("expected_error", bool),
        labels=options.get("labels", bool),
        curves=options.get("curves", bool),
        cloud=options.get("cloud", str, type(None)),
        axes=options.get("axes", str),
        cloud_unit=options.get("cloud_unit", str),
        run_record=options.get("run_record", bool),
        mesh=options.get("mesh", str, type(None)),
        normals=options.get("normals", bool),
        drop_flying=options.get("drop_flying", bool),
    )


def parsed_outcome(outcome: Section) -> BlockOutcome:
    """Inverse of `outcome_to_dict`; FormatError for missing or wrong values."""
    status = outcome.get("status", str)
    if status not in list(Status):
        raise FormatError(f"'status' of a block must be one of {', '.join(Status)}, not {status!r:.60}.")
    sigma = outcome.get("sigma_i", float, type(None))
    return BlockOutcome(
        label=outcome.get("label", int),
        status=Status(status),
        message=outcome.get("message", str),
        pixels=outcome.get("pixels", int),
        known=outcome.get("known", int),
        recovered=outcome.get("recovered", int),
        iterations=outcome.get("iterations", int),
        stages=outcome.get("stages", int),
        sigma_i=math.nan if sigma is None else sigma,
        outside=outcome.get("outside", int),
    )
