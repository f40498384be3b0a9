"""run.json: what a run was made of. The same run gives the same record, byte for byte."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.metadata
import math
import os
import platform
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..completion import BlockOutcome, Completion, Status
from ..errors import FormatError, InputError, ParameterError
from ..frame import RGBDFrame
from ..io.files import existing_file, read_json
from ..parameters import BlockParameters, Parameters
from .export import LABELS_FILE, ExportOptions

PROGRAM = "ilf-studio"

# what computes or writes the results -> the distributions that may hold it
_DISTRIBUTIONS = {
    "numpy": ("numpy",),
    "scipy": ("scipy",),
    "opencv": ("opencv-python-headless", "opencv-python", "opencv-contrib-python"),
    "scikit-image": ("scikit-image",),
    "open3d": ("open3d-cpu", "open3d"),
}


@dataclass(frozen=True)
class RecordedFile:
    """An input file: where it was, and the SHA-256 of its content."""

    path: str
    sha256: str


@dataclass(frozen=True)
class RecordedInputs:
    """The files of a frame and how they were read: file units per metre, and fx, fy, cx, cy [px] or None."""

    rgb: RecordedFile
    depth: RecordedFile
    depth_units: float
    intrinsics: tuple[float, float, float, float] | None


@dataclass(frozen=True)
class RunRecord:
    """A run record that has been read and checked.

    Attributes
    ----------
    version : str
        Of this program.
    versions : dict
        Library -> version, None where it was not installed.
    inputs : RecordedInputs or None
        None if the frame was not read from files.
    extraction : BlockParameters or None
        None if the blocks did not come from the extraction.
    labels_sha256 : str
        See `labels_sha256`.
    shape : (int, int)
        (H, W) of the label map.
    edited : bool
        Whether the blocks are not, or no longer, what the extraction gives.
    labels_file : str or None
        Name of the label map beside the record, None if it was not written.
    parameters : dict
        Label of every block that was run -> its parameters.
    common : Parameters
        Those of most blocks.
    options : ExportOptions
    outcomes : tuple of BlockOutcome
    """

    version: str
    versions: dict[str, str | None]
    inputs: RecordedInputs | None
    extraction: BlockParameters | None
    labels_sha256: str
    shape: tuple[int, int]
    edited: bool
    labels_file: str | None
    parameters: dict[int, Parameters]
    common: Parameters
    options: ExportOptions
    outcomes: tuple[BlockOutcome, ...]


def make_run_record(
    frame: RGBDFrame,
    labels: NDArray[np.int32],
    extraction: BlockParameters | None,
    edited: bool,
    completion: Completion,
    options: ExportOptions,
    *,
    inputs: RecordedInputs | None = None,
) -> dict[str, Any]:
    """What replays a run, ready for JSON. Nothing in it depends on when, where or how fast it was made.

    The parameters are those that the blocks were really run with, as `completion.results` holds them.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
        The label map that was run.
    extraction : BlockParameters or None
        What the blocks were extracted with; None if they were not.
    edited : bool
        Whether `labels` differs from what the extraction gives.
    completion : Completion
    options : ExportOptions
    inputs : RecordedInputs, optional
        Left out, they are those of the frame's files, which are read for their SHA-256.

    Raises
    ------
    InputError
        If the frame's files are no longer there.
    """
    results = {label: completion.results[label] for label in sorted(completion.results)}
    used = Counter(result.parameters for result in results.values())
    common = used.most_common(1)[0][0] if used else Parameters()
    inputs = inputs or inputs_of(frame)
    return {
        "program": PROGRAM,
        "version": __version__,
        "versions": library_versions(),
        "inputs": None if inputs is None else dataclasses.asdict(inputs),
        "extraction": None if extraction is None else extraction.to_dict(),
        "blocks": {
            "sha256": labels_sha256(labels),
            "shape": list(labels.shape),
            "edited": edited,
            "file": LABELS_FILE if options.labels else None,
        },
        "parameters": common.to_dict(),
        "block_parameters": {
            str(label): _differences(result.parameters, common)
            for label, result in results.items()
            if result.parameters != common
        },
        "export": dataclasses.asdict(options),
        "blocks_outcome": [outcome_to_dict(result.outcome) for result in results.values()],
    }


def outcome_to_dict(outcome: BlockOutcome) -> dict[str, Any]:
    """A block's outcome, ready for JSON: NaN becomes None."""
    values = dataclasses.asdict(outcome)
    sigma = None if math.isnan(outcome.sigma_i) else outcome.sigma_i
    return values | {"status": outcome.status.value, "sigma_i": sigma}


def inputs_of(frame: RGBDFrame) -> RecordedInputs | None:
    """The frame's files with their SHA-256; None if it was not read from files.

    Raises
    ------
    InputError
        If a file is no longer there.
    """
    if not {"rgb", "depth", "depth_units"} <= frame.sources.keys():
        return None
    rgb, depth = (
        RecordedFile(path, file_sha256(path)) for path in (str(frame.sources[role]) for role in ("rgb", "depth"))
    )
    camera = frame.intrinsics
    numbers = None if camera is None else (camera.fx, camera.fy, camera.cx, camera.cy)
    return RecordedInputs(rgb, depth, float(str(frame.sources["depth_units"])), numbers)


def file_sha256(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a file's content; raises InputError if it cannot be read."""
    with open(existing_file(path), "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def labels_sha256(labels: NDArray[np.integer]) -> str:
    """SHA-256 of a label map as little-endian int32, row by row."""
    return hashlib.sha256(np.ascontiguousarray(labels, "<i4").tobytes()).hexdigest()


def library_versions() -> dict[str, str | None]:
    """Versions of Python and of the libraries that a result may depend on; None for what is not installed."""
    versions: dict[str, str | None] = {"python": platform.python_version()}
    for library, distributions in _DISTRIBUTIONS.items():
        versions[library] = next(filter(None, map(_version, distributions)), None)
    return versions


def read_run_record(path: str | os.PathLike[str]) -> RunRecord:
    """Read and check a run record. Sections and keys that this version does not know are passed over.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is not JSON, not a run record, lacks something, or has a value of the wrong kind. Unknown parameters
        too, because without them the run would be another one.
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise FormatError(f"{Path(path).absolute()} is no run record: give the run.json that an export has written.")
    try:
        return _parsed(_Section("run record", data))
    except (InputError, ParameterError) as error:
        raise FormatError(f"{Path(path).absolute()}: {error} Was the record made by another version?") from error


@dataclass(frozen=True)
class _Section:
    """An object of the record, with a clear message for everything that may be wrong with its values."""

    name: str
    values: dict[str, Any]

    def get(self, key: str, *kinds: type) -> Any:
        """The value of a key, checked to be of one of these kinds."""
        if key not in self.values:
            raise FormatError(f"The {self.name} lacks {key!r}.")
        return _checked(self.values[key], kinds, f"{key!r} in the {self.name}")

    def items(self, key: str, kind: type) -> list[Any]:
        """A list of values of one kind."""
        return [_checked(value, (kind,), f"{key!r} in the {self.name}") for value in self.get(key, list)]

    def section(self, key: str) -> _Section:
        """An object inside this one."""
        return _Section(key, self.get(key, dict))


def _checked(value: Any, kinds: tuple[type, ...], what: str) -> Any:
    """`value` of one of these kinds: whole numbers pass as float, true and false never as numbers."""
    if float in kinds and type(value) is int:
        value = float(value)
    if type(value) in kinds and not (type(value) is float and not math.isfinite(value)):
        return value
    wanted = " or ".join("null" if kind is type(None) else kind.__name__ for kind in kinds)
    raise FormatError(f"{what} must be {wanted}, not {value!r:.60}.")


def _parsed(record: _Section) -> RunRecord:
    blocks = record.section("blocks")
    shape = blocks.items("shape", int)
    if len(shape) != 2:
        raise FormatError(f"'shape' in the blocks must be [height, width], not {shape}.")
    labels_file = blocks.get("file", str, type(None))
    if labels_file is not None and Path(labels_file).name != labels_file:
        raise FormatError(f"'file' in the blocks must be a plain file name, not {labels_file!r:.60}.")
    extraction = record.get("extraction", dict, type(None))
    inputs = record.get("inputs", dict, type(None))
    common = Parameters.from_dict(_renamed(record.get("parameters", dict)))
    own = record.section("block_parameters")
    outcomes = tuple(
        _parsed_outcome(_Section("blocks_outcome", values)) for values in record.items("blocks_outcome", dict)
    )
    versions = record.section("versions")
    return RunRecord(
        version=record.get("version", str),
        versions={name: versions.get(name, str, type(None)) for name in versions.values},
        inputs=None if inputs is None else _parsed_inputs(_Section("inputs", inputs)),
        extraction=None if extraction is None else BlockParameters.from_dict(extraction),
        labels_sha256=blocks.get("sha256", str),
        shape=(shape[0], shape[1]),
        edited=blocks.get("edited", bool),
        labels_file=labels_file,
        parameters={
            outcome.label: common.replace(**_renamed(own.get(str(outcome.label), dict)))
            if str(outcome.label) in own.values
            else common
            for outcome in outcomes
        },
        common=common,
        options=_parsed_options(record.section("export")),
        outcomes=outcomes,
    )


def _renamed(values: dict[str, Any]) -> dict[str, Any]:
    """Parameters of a record, with what has another name since as it is called now."""
    return values | {"edges": "hed"} if values.get("edges") == "network" else values


def _parsed_inputs(inputs: _Section) -> RecordedInputs:
    rgb, depth = (
        RecordedFile(section.get("path", str), section.get("sha256", str))
        for section in (inputs.section("rgb"), inputs.section("depth"))
    )
    numbers = None if inputs.get("intrinsics", list, type(None)) is None else inputs.items("intrinsics", float)
    if numbers is not None and len(numbers) != 4:
        raise FormatError(f"'intrinsics' in the inputs must be [fx, fy, cx, cy], not {len(numbers)} numbers.")
    camera = None if numbers is None else (numbers[0], numbers[1], numbers[2], numbers[3])
    return RecordedInputs(rgb, depth, inputs.get("depth_units", float), camera)


def _parsed_options(options: _Section) -> ExportOptions:
    return ExportOptions(
        depth_formats=tuple(options.items("depth_formats", str)),
        depth_units=options.get("depth_units", float),
        # records of before there were these two do not name them, and neither was written
        expected_error="expected_error" in options.values and options.get("expected_error", bool),
        dense="dense" in options.values and options.get("dense", bool),
        labels=options.get("labels", bool),
        curves=options.get("curves", bool),
        cloud=options.get("cloud", str, type(None)),
        axes=options.get("axes", str),
        cloud_unit=options.get("cloud_unit", str),
        run_record=options.get("run_record", bool),
    )


def _parsed_outcome(outcome: _Section) -> BlockOutcome:
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
    )


def _differences(parameters: Parameters, common: Parameters) -> dict[str, Any]:
    shared = common.to_dict()
    return {name: value for name, value in parameters.to_dict().items() if value != shared[name]}


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None
