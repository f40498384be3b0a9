"""Reading run.json: every value checked, with a clear message for whatever may be wrong with it."""

from __future__ import annotations

import dataclasses
import math
import os
from pathlib import Path

from .._runtime.files import read_json
from .._runtime.schema import Section, is_plain
from ..data.camera import checked_motion
from ..data.frame import FrameInputs, InputFile, TruthFile
from ..data.parameters import BlockParameters, Parameters
from ..data.results import BlockOutcome, Status
from ..errors import FormatError, InputError, ParameterError
from ..io.encodings import encoding_of
from .options import DISTRUSTED_FILE, DRAWN_FILE, GUIDE_FILE, OUTSIDE_FILE, ExportOptions
from .record import PROGRAM, SCHEMA, RecordedGuide, RecordedMask, RunRecord


def read_record(path: str | os.PathLike[str]) -> RunRecord:
    """Read and check a run record. Sections and keys that this version does not know are passed over.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is not JSON, not a run record, of a later schema, lacks something, or has a value of the wrong kind.
        Unknown parameters too, because without them the run would be another one.
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise FormatError(f"{Path(path).absolute()} is no run record: give the run.json that an export has written.")
    try:
        return _parsed(Section("run record", data))
    except (InputError, ParameterError) as error:
        raise FormatError(f"{Path(path).absolute()}: {error} Was the record made by another version?") from error


def _parsed(record: Section) -> RunRecord:
    schema = record.get("schema", int) if "schema" in record.values else 0
    if not 0 <= schema <= SCHEMA:
        raise FormatError(
            f"The record has schema {schema}; this version reads up to {SCHEMA}. Install a newer ILF Studio."
        )
    blocks = record.section("blocks")
    shape = blocks.items("shape", int)
    if len(shape) != 2:
        raise FormatError(f"'shape' in the blocks must be [height, width], not {shape}.")
    extraction = record.get("extraction", dict, type(None))
    inputs = record.get("inputs", dict, type(None))
    common = Parameters.from_dict(record.get("parameters", dict))
    own = record.section("block_parameters")
    outcomes = tuple(
        parsed_outcome(Section("blocks_outcome", values)) for values in record.items("blocks_outcome", dict)
    )
    export = record.section("export")
    known = RunRecord(
        name="",
        inputs=None if inputs is None else parsed_inputs(Section("inputs", inputs)),
        distrusted=None,
        extraction=None if extraction is None else BlockParameters.from_dict(extraction),
        labels_sha256=blocks.get("sha256", str),
        shape=(shape[0], shape[1]),
        edited=blocks.get("edited", bool),
        labels_file=blocks.filename("file"),
        extraction_networks={},
        networks={},
        parameters={
            outcome.label: common.replace(**own.get(str(outcome.label), dict))
            if str(outcome.label) in own.values
            else common
            for outcome in outcomes
        },
        common=common,
        # in schema 0 this was a matter of the export, and before that there was none
        dense="dense" in export.values and export.get("dense", bool),
        options=_parsed_options(export),
        outcomes=outcomes,
        depth_sha256=None,
        version=record.get("version", str),
        versions=record.texts("versions", type(None)),
        processor="",
        schema=schema,
    )
    return known if schema == 0 else _with_what_schema_1_brought(known, record)


def _with_what_schema_1_brought(known: RunRecord, record: Section) -> RunRecord:
    networks, outputs = record.section("networks"), record.texts("outputs")
    if not all(map(is_plain, outputs)):
        raise FormatError("'outputs' must have plain file names.")
    return dataclasses.replace(
        known,
        name=record.get("name", str),
        distrusted=_parsed_mask(record, "distrusted", DISTRUSTED_FILE),
        # records of runs without them do not name them
        drawn=_parsed_mask(record, "drawn", DRAWN_FILE) if "drawn" in record.values else None,
        outside_view=_parsed_mask(record, "outside_view", OUTSIDE_FILE) if "outside_view" in record.values else None,
        guide=_parsed_guide(record),
        pose=_parsed_pose(record),
        extraction_networks=networks.texts("extraction"),
        networks=networks.texts("filter"),
        dense=record.get("dense", bool),
        depth_sha256=record.get("depth_sha256", str),
        outputs=outputs,
        processor=record.get("processor", str),
    )


def _parsed_mask(record: Section, key: str, usual_file: str) -> RecordedMask | None:
    if record.get(key, dict, type(None)) is None:
        return None
    mask = record.section(key)
    return RecordedMask(mask.get("sha256", str), mask.filename("file") or usual_file)


def _parsed_pose(record: Section) -> tuple[tuple[float, ...], ...] | None:
    if "pose" not in record.values:  # it was not known
        return None
    return tuple(map(tuple, checked_motion(record.get("pose", list), "'pose' in the run record").tolist()))


def _parsed_guide(record: Section) -> RecordedGuide | None:
    if "guide" not in record.values:  # the run had none
        return None
    guide = record.section("guide")
    file = guide.filename("file") or GUIDE_FILE
    return RecordedGuide(guide.get("sha256", str), file, guide.get("path", str, type(None)))


def parsed_inputs(inputs: Section) -> FrameInputs:
    """Inverse of `inputs_to_dict`; raises FormatError for what is missing or of the wrong kind."""
    rgb, depth = (
        InputFile(section.get("path", str), section.get("sha256", str))
        for section in (inputs.section("rgb"), inputs.section("depth"))
    )
    numbers = None if inputs.get("intrinsics", list, type(None)) is None else inputs.items("intrinsics", float)
    if numbers is not None and len(numbers) != 4:
        raise FormatError(f"'intrinsics' in the inputs must be [fx, fy, cx, cy], not {len(numbers)} numbers.")
    camera = None if numbers is None else (numbers[0], numbers[1], numbers[2], numbers[3])
    encoding = inputs.get("encoding", str) if "encoding" in inputs.values else None
    try:
        named = None if encoding is None else encoding_of(encoding)
    except ParameterError as error:
        raise FormatError(f"There is no depth encoding {encoding!r:.60}. Install a newer ILF Studio.") from error
    return FrameInputs(
        rgb,
        depth,
        inputs.get("depth_units", float) if named is None else named.units,
        camera,
        _parsed_truth(inputs),
        encoding,
        inputs.get("invalid", float) if "invalid" in inputs.values else None,
        inputs.get("frame", str) if "frame" in inputs.values else None,
    )


def _parsed_truth(inputs: Section) -> TruthFile | None:
    if "truth" not in inputs.values:  # the frame had none
        return None
    truth = inputs.section("truth")
    return TruthFile(truth.get("path", str), truth.get("sha256", str), truth.get("units", float))


def _parsed_options(options: Section) -> ExportOptions:
    return ExportOptions(
        depth_formats=tuple(options.items("depth_formats", str)),
        depth_units=options.get("depth_units", float),
        # records of before there was one do not name it, and it was not written
        expected_error="expected_error" in options.values and options.get("expected_error", bool),
        labels=options.get("labels", bool),
        curves=options.get("curves", bool),
        cloud=options.get("cloud", str, type(None)),
        axes=options.get("axes", str),
        cloud_unit=options.get("cloud_unit", str),
        run_record=options.get("run_record", bool),
        # records of before there were meshes do not name these
        mesh=options.get("mesh", str, type(None)) if "mesh" in options.values else None,
        normals="normals" in options.values and options.get("normals", bool),
        drop_flying="drop_flying" in options.values and options.get("drop_flying", bool),
    )


def parsed_outcome(outcome: Section) -> BlockOutcome:
    """Inverse of `outcome_to_dict`; raises FormatError for what is missing or of the wrong kind."""
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
        outside=outcome.get("outside", int) if "outside" in outcome.values else 0,
    )
