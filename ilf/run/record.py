"""run.json: the inputs and results of a run. The same run gives the same record, byte for byte."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import platform
from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_json
from .._runtime.installation import __version__
from .._runtime.networks.models import CORRECTION, DEPTH_EDGES, SPARSE_CORRECTION
from .._runtime.networks.network import device
from .._runtime.schema import PROGRAM, PlainName, check_schema, converted, json_file
from ..completion.correction import CorrectionNetwork
from ..completion.sparse_correction import SparseCorrectionNetwork
from ..data.blocks import Blocks
from ..data.camera import checked_transform
from ..data.declarations import Value
from ..data.frame import FrameInputs
from ..data.guide import Gives, GuideCard
from ..data.neighbours import Neighbour
from ..data.parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..data.results import BlockOutcome, Completion
from ..errors import FormatError, InputError, ParameterError, told_as
from ..io.encodings import encoding_of
from ..segmentation.edges.detectors import DepthEdgeNetwork, load_model
from . import files
from .options import ExportOptions

# What a result may depend on besides the run: libraries, and the processor.


def installed_version(*distributions: str) -> str | None:
    """The version of the first of some distributions that is installed; None if none is."""
    for name in distributions:
        try:
            return version(name)
        except PackageNotFoundError:
            continue
    return None


def library_versions() -> dict[str, str | None]:
    """Return versions of Python and of the libraries that a result may depend on; None if not installed."""
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": installed_version("scipy"),
        "onnxruntime": installed_version("onnxruntime", "onnxruntime-gpu", "onnxruntime-directml"),
        "opencv": cv2.__version__,
        "numba": installed_version("numba"),
    }


def processor() -> str:
    """Return the processor architecture and the SIMD extensions that numpy uses; they may change the last digits."""
    found = np.show_config(mode="dicts") or {}
    extensions = found.get("SIMD Extensions", {})
    return " ".join([platform.machine(), *extensions.get("baseline", []), *extensions.get("found", [])])


# The networks used by a run, by name.

Requested = tuple[str, ...]
"""Names of networks: the requested one, then its replacement if that does not work."""


def requested_networks(detector: str, model: str) -> Requested:
    """The networks that may produce the edges.

    Parameters
    ----------
    detector : str
        `BlockParameters.detector` or `Parameters.edges`.
    model : str
        The contour network selected with it.

    Examples
    --------
    >>> requested_networks("rgbd", "edges"), requested_networks("combined", "mine")
    (('depth-edges', 'edges'), ('mine',))
    """
    return {"canny": (), "rgbd": (DEPTH_EDGES, model)}.get(detector, (model,))


def used_network(sha256: str | None, requested: Requested) -> dict[str, str]:
    """Name -> SHA-256 of the network used: the requested one with that file, else the first; empty if none was used."""
    if sha256 is None or not requested:
        return {}
    return {next((name for name in requested[1:] if installed_sha256(name) == sha256), requested[0]): sha256}


def installed_sha256(name: str) -> str | None:
    """SHA-256 of the installed network of this name; None if there is none that works.

    Raises
    ------
    InstallationError
        If networks cannot be read in this installation.
    """
    try:
        kinds = (DepthEdgeNetwork, CorrectionNetwork, SparseCorrectionNetwork)
        kind = next((kind for kind in kinds if name == kind.NAME), None)
        return (load_model(name) if kind is None else kind.bundled()).sha256
    except InputError:
        return None


SCHEMA = 1
"""Version of the record's format."""


@dataclass(frozen=True)
class RecordedMask:
    """A mask of a run's inputs: the SHA-256 of its values (`array_sha256`), and its file beside the record."""

    sha256: str
    file: PlainName

    @classmethod
    def of(cls, array: NDArray[Any] | None, file: str, *more: Any) -> Self | None:
        """The record of an array in a file, with the values of further fields; None for none."""
        return None if array is None else cls(array_sha256(array), file, *more)


@dataclass(frozen=True)
class RecordedGuide(RecordedMask):
    """The guide of a run: the SHA-256 of its `array`, its file beside the record, its original path, the card of the
    network with a name that predicted it, with the hash of the network's file, and what it gives."""

    path: str | None
    network: GuideCard | None = field(default=None, metadata={"optional": True})
    gives: Gives | None = field(default=None, metadata={"optional": True})


@dataclass(frozen=True)
class RecordedByHand(RecordedMask):
    """Depth by hand of a run: the SHA-256 of its values, its file beside the record, and its weight."""

    weight: float


@dataclass(frozen=True)
class RecordedBlocks:
    """The blocks of a run.

    Attributes
    ----------
    sha256 : str
        SHA-256 of the label map as int32 (`array_sha256`).
    shape : (int, int)
        (H, W) of the label map.
    edited : bool
        Whether the blocks differ from the result of the extraction.
    file : str or None
        Name of the label map beside the record, None if it was not written.
    """

    sha256: str
    shape: tuple[int, int]
    edited: bool
    file: PlainName | None

    @classmethod
    def of(cls, blocks: Blocks, file: str | None) -> Self:
        """The record of blocks whose label map is written into a file."""
        rows, columns = blocks.labels.shape
        return cls(array_sha256(blocks.labels), (rows, columns), blocks.edited, file)


@dataclass(frozen=True)
class RecordedNetworks:
    """Name of every network used by the extraction, and by the filter and later steps -> SHA-256 of its file."""

    extraction: dict[str, str]
    filter: dict[str, str]


@dataclass(frozen=True, kw_only=True)
class RunRecord:
    """The inputs and results of a run, independent of time, place and speed of its execution: the content of run.json.

    Attributes
    ----------
    version : str
        Version of this program.
    versions : dict
        Library -> version, None if it was not installed.
    processor : str
        Features of the processor that results may depend on.
    device : str
        Device that ran the networks.
    name : str
        Name of the frame.
    inputs : FrameInputs or None
        None if the frame was not read from files.
    invalid_mask, drawn : RecordedMask or None
        The invalid mask and the mask of drawn borders; None for none.
    outside_view : RecordedMask or None
        The mask of pixels outside the depth camera's view, if the frame has it from a file; None for none.
    by_hand : RecordedByHand or None
    guide : RecordedGuide or None
    pose : tuple of tuple of float, or None
        Pose of the frame's camera, as rows of a matrix; None if unknown.
    neighbours : tuple of Neighbour
    extraction : BlockParameters or None
        None if the blocks were not extracted.
    blocks : RecordedBlocks
    networks : RecordedNetworks
    parameters : Parameters
        Parameters of most blocks.
    block_parameters : dict
        Label of every block with other parameters -> the values that differ.
    extrapolate : bool
        Whether the remaining depth was extrapolated.
    export : ExportOptions
    blocks_outcome : tuple of BlockOutcome
        Of every block that was run.
    depth_sha256 : str
        SHA-256 of the completed depth as float32 (`array_sha256`).
    outputs : dict
        Name of every other file of the set -> SHA-256.
    """

    version: str = __version__
    versions: dict[str, str | None] = field(default_factory=library_versions)
    processor: str = field(default_factory=processor)
    device: str = field(default_factory=device)
    name: str
    inputs: FrameInputs | None
    invalid_mask: RecordedMask | None
    drawn: RecordedMask | None = None
    by_hand: RecordedByHand | None = None
    outside_view: RecordedMask | None = None
    guide: RecordedGuide | None = None
    pose: tuple[tuple[float, ...], ...] | None = None
    neighbours: tuple[Neighbour, ...] = ()
    extraction: BlockParameters | None
    blocks: RecordedBlocks
    networks: RecordedNetworks
    parameters: Parameters
    block_parameters: dict[int, dict[str, Value]]
    extrapolate: bool
    export: ExportOptions
    blocks_outcome: tuple[BlockOutcome, ...]
    depth_sha256: str
    outputs: dict[PlainName, str] = field(default_factory=dict)

    @cached_property
    def own_parameters(self) -> dict[int, Parameters]:
        """Label of every block that was run -> its parameters."""
        own = {label: self.parameters.replace(**values) for label, values in self.block_parameters.items()}
        return {outcome.label: own.get(outcome.label, self.parameters) for outcome in self.blocks_outcome}


def make_record(completion: Completion, options: ExportOptions) -> RunRecord:
    """Make the record of a completion's run, with the parameters that the blocks were actually run with.

    Parameters
    ----------
    completion : Completion
    options : ExportOptions
        Options of the written files.
    """
    run, results, frame = completion.run, completion.results, completion.frame
    by_hand, guide = run.blocks.by_hand, frame.guide
    # for recordings, the replay registers the depth again
    is_of_files = frame.inputs is not None and frame.inputs.frame is None
    used = Counter(result.parameters for result in results.values())
    common = used.most_common(1)[0][0] if used else run.parameters
    extraction = run.blocks.extraction
    asked = () if extraction is None else requested_networks(extraction.detector, extraction.model)
    return RunRecord(
        name=frame.name,
        inputs=frame.inputs,
        invalid_mask=RecordedMask.of(frame.invalid_mask, files.INVALID_MASK),
        drawn=RecordedMask.of(run.blocks.drawn, files.DRAWN),
        by_hand=None if by_hand is None else RecordedByHand.of(by_hand.depth, files.DEPTH_BY_HAND, by_hand.weight),
        outside_view=RecordedMask.of(frame.outside_view if is_of_files else None, files.OUTSIDE),
        guide=None
        if guide is None
        else RecordedGuide.of(guide.array, files.GUIDE, guide.path, guide.network, guide.gives),
        pose=None if frame.pose is None else tuple(map(tuple, frame.pose.tolist())),
        neighbours=() if frame.neighbours is None else frame.neighbours.neighbours,
        extraction=extraction,
        blocks=RecordedBlocks.of(run.blocks, files.LABELS if options.labels else None),
        networks=RecordedNetworks(used_network(run.blocks.network, asked), _networks(completion)),
        parameters=common,
        block_parameters={
            label: result.parameters.differences_from(common)
            for label, result in results.items()
            if result.parameters != common
        },
        extrapolate=run.extrapolate,
        export=options,
        blocks_outcome=tuple(result.outcome for result in results.values()),
        depth_sha256=array_sha256(completion.depth),
    )


def array_sha256(values: NDArray[Any]) -> str:
    """SHA-256 of an array's values, row by row: integers as little-endian int32, others as little-endian float32.

    Missing depth always has the same bit pattern.
    """
    if values.dtype.kind == "f":
        known = np.where(np.isnan(values), np.float32(np.nan), values)
        return hashlib.sha256(np.ascontiguousarray(known, "<f4").tobytes()).hexdigest()
    return hashlib.sha256(np.ascontiguousarray(values, "<i4").tobytes()).hexdigest()


def to_json(record: RunRecord) -> bytes:
    """Content of run.json, with null for NaN."""
    return json_file(SCHEMA, dataclasses.asdict(record))


def _networks(completion: Completion) -> dict[str, str]:
    # extrapolation uses the preset "best"
    used = [(PRESETS[DEFAULT_PRESET], completion.extrapolation_network)]
    used += [(result.parameters, result.network) for result in completion.results.values()]
    networks: dict[str, str] = {}
    for result in completion.results.values():
        networks |= zip((CORRECTION, SPARSE_CORRECTION), result.correction, strict=False)
    for parameters, sha256 in dict.fromkeys(used):
        networks |= used_network(sha256, requested_networks(parameters.edges, parameters.model))
    return networks


# Reading: every value is checked, with a clear error message.


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
    with told_as(FormatError, f"{Path(path).absolute()}: {{error}}", (InputError, ParameterError)):
        check_schema(data, SCHEMA, "run record")
        return _parsed(data)


def modes_in(path: str | os.PathLike[str]) -> frozenset[str]:
    """The modes (`Parameters.mode`) in a run record; nothing else in it is checked, which would take a hundred times as
    long. Raises as `read_record`."""
    data = read_json(path)
    try:
        common = data["parameters"]["mode"]
        return frozenset({common, *(own.get("mode", common) for own in data["block_parameters"].values())})
    except (KeyError, TypeError, AttributeError) as error:
        raise FormatError(f"{Path(path).absolute()} is not a run record: give the run.json of an export.") from error


def _parsed(data: dict[str, Any]) -> RunRecord:
    for key, kind in (("parameters", Parameters), ("extraction", BlockParameters)):
        if isinstance(data.get(key), dict):
            data[key] = kind.from_dict(data[key])
    if isinstance(data.get("blocks_outcome"), list):
        data["blocks_outcome"] = [_without_null_deviation(outcome) for outcome in data["blocks_outcome"]]
    record = converted({"neighbours": [], **data}, RunRecord, "run record")
    record.own_parameters  # noqa: B018 - refuses unknown names and values out of range
    if record.pose is not None:
        checked_transform(record.pose, "'pose' in the run record")
    for neighbour in record.neighbours:
        checked_transform(neighbour.motion, "'motion' of a neighbour in the run record")
    inputs = record.inputs
    if inputs is None or inputs.encoding is None:
        return record
    with told_as(FormatError, f"There is no depth encoding {inputs.encoding!r:.60}.", ParameterError):
        return replace(record, inputs=replace(inputs, depth_units=encoding_of(inputs.encoding).units))


def _without_null_deviation(outcome: object) -> object:
    """Leave a deviation of null out: it is NaN, the default."""
    if isinstance(outcome, dict) and outcome.get("sigma_i", 0) is None:
        return {name: value for name, value in outcome.items() if name != "sigma_i"}
    return outcome
