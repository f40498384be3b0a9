"""run.json: what a run was made of and what came of it. The same run gives the same record, byte for byte."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import __version__
from .._runtime.machine import library_versions, processor
from .._runtime.networks.models import CORRECTION, DEPTH_EDGES, model_path
from ..completion.correction_network import load_correction_network
from ..data.frame import FrameInputs
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters, preset
from ..data.results import BlockOutcome, Completion
from ..errors import InputError
from ..segmentation.edges.depth_edges import DepthEdgeNetwork
from ..segmentation.edges.detectors import load_model
from .options import DISTRUSTED_FILE, DRAWN_FILE, GUIDE_FILE, LABELS_FILE, OUTSIDE_FILE, ExportOptions
from .setup import RunSetup

# Which network had a part in a run, by name.

Asked = tuple[str, ...]
"""Names of networks: the one that is asked for, and the one that stands in where that does not work."""


def asked_networks(detector: str, model: str) -> Asked:
    """The networks that edges may come from.

    Parameters
    ----------
    detector : str
        `BlockParameters.detector` or `Parameters.edges`.
    model : str
        The network of contours that is chosen beside it.

    Examples
    --------
    >>> asked_networks("rgbd", "edges"), asked_networks("combined", "mine"), asked_networks("canny", "edges")
    (('depth-edges', 'edges'), ('mine',), ())
    """
    return {"canny": (), "rgbd": (DEPTH_EDGES, model)}.get(detector, (model,))


def used_network(sha256: str | None, asked: Asked) -> dict[str, str]:
    """Name -> SHA-256 of the network that was used: of those asked for the one that has that very file, else the first;
    empty if none was."""
    if sha256 is None or not asked:
        return {}
    return {next((name for name in asked[1:] if present_sha256(name) == sha256), asked[0]): sha256}


def present_sha256(name: str) -> str | None:
    """SHA-256 of the network of a name as it is now; None if there is none that works.

    Raises
    ------
    InstallationError
        If no network can be read here.
    """
    try:
        if name == CORRECTION:
            return load_correction_network().sha256
        return (DepthEdgeNetwork.load(model_path(name)) if name == DEPTH_EDGES else load_model(name)).sha256
    except InputError:
        return None


PROGRAM = "ilf-studio"

SCHEMA = 1
"""Number of the form that a record has."""


@dataclass(frozen=True)
class RecordedMask:
    """A mask that a run was made with: the SHA-256 of its values (`array_sha256`), and its file beside the record."""

    sha256: str
    file: str


@dataclass(frozen=True)
class RecordedGuide(RecordedMask):
    """The guide that a run was made with: the SHA-256 of its `array`, its file beside the record, and where it is
    from."""

    path: str | None


@dataclass(frozen=True)
class RunRecord:
    """What a run was made of and what came of it. Nothing in it depends on when, where or how fast it was run.

    Attributes
    ----------
    name : str
        Of the frame.
    inputs : FrameInputs or None
        None if the frame was not read from files.
    distrusted, drawn : RecordedMask or None
        The masks of distrusted depth and of drawn borders; None where there is none.
    outside_view : RecordedMask or None
        The mask of what the depth camera could not see, of a frame that has it from a file; None where there is none.
    guide : RecordedGuide or None
    pose : tuple of tuple of float, or None
        Where the frame's camera was, as rows of a matrix; None where it is not known.
    extraction : BlockParameters or None
        None if the blocks did not come from the extraction.
    labels_sha256 : str
        Of the label map as int32 (`array_sha256`).
    shape : (int, int)
        (H, W) of the label map.
    edited : bool
        Whether the blocks are not, or no longer, what the extraction gives.
    labels_file : str or None
        Name of the label map beside the record, None if it was not written.
    extraction_networks, networks : dict
        Name of every network that had a part in the extraction, and in the filter and after it -> SHA-256 of its file.
    parameters : dict
        Label of every block that was run -> its parameters.
    common : Parameters
        Those of most blocks.
    dense : bool
        Whether the rest was guessed.
    options : ExportOptions
    outcomes : tuple of BlockOutcome
    depth_sha256 : str
        Of the completed depth as float32 (`array_sha256`).
    outputs : dict
        Name of every other file of the set -> SHA-256.
    version : str
        Of this program.
    versions : dict
        Library -> version, None where it was not installed.
    processor : str
        What the processor can do, as far as results may depend on it.
    """

    name: str
    inputs: FrameInputs | None
    distrusted: RecordedMask | None
    extraction: BlockParameters | None
    labels_sha256: str
    shape: tuple[int, int]
    edited: bool
    labels_file: str | None
    extraction_networks: dict[str, str]
    networks: dict[str, str]
    parameters: dict[int, Parameters]
    common: Parameters
    dense: bool
    options: ExportOptions
    outcomes: tuple[BlockOutcome, ...]
    depth_sha256: str
    drawn: RecordedMask | None = None
    outside_view: RecordedMask | None = None
    pose: tuple[tuple[float, ...], ...] | None = None
    guide: RecordedGuide | None = None
    outputs: dict[str, str] = field(default_factory=dict)
    version: str = __version__
    versions: dict[str, str | None] = field(default_factory=library_versions)
    processor: str = field(default_factory=processor)


def make_record(run: RunSetup, completion: Completion, options: ExportOptions) -> RunRecord:
    """The record of a run. Its parameters are those that the blocks were really run with.

    Parameters
    ----------
    run : RunSetup
    completion : Completion
    options : ExportOptions
        How its results are written.
    """
    results = completion.results
    # what registration finds out, it finds out again
    is_of_files = run.frame.inputs is not None and run.frame.inputs.frame is None
    used = Counter(result.parameters for result in results.values())
    return RunRecord(
        name=run.frame.name,
        inputs=run.frame.inputs,
        distrusted=_recorded(run.frame.distrusted, DISTRUSTED_FILE),
        extraction=run.extraction,
        labels_sha256=array_sha256(run.blocks),
        shape=run.frame.shape,
        edited=run.edited,
        labels_file=LABELS_FILE if options.labels else None,
        extraction_networks=_extraction_networks(run),
        networks=_networks(completion),
        parameters={label: result.parameters for label, result in results.items()},
        common=used.most_common(1)[0][0] if used else run.parameters,
        dense=run.dense,
        options=options,
        outcomes=tuple(result.outcome for result in results.values()),
        depth_sha256=array_sha256(completion.depth),
        drawn=_recorded(run.drawn, DRAWN_FILE),
        outside_view=_recorded(run.frame.outside_view if is_of_files else None, OUTSIDE_FILE),
        pose=None if run.frame.pose is None else tuple(map(tuple, run.frame.pose.tolist())),
        guide=_recorded_guide(run.frame.guide),
    )


def array_sha256(values: NDArray[Any]) -> str:
    """SHA-256 of an array's values, row by row: whole numbers as little-endian int32, others as little-endian float32.

    Missing depth has one pattern of bits, whatever made it.
    """
    if values.dtype.kind == "f":
        known = np.where(np.isnan(values), np.float32(np.nan), values)
        return hashlib.sha256(np.ascontiguousarray(known, "<f4").tobytes()).hexdigest()
    return hashlib.sha256(np.ascontiguousarray(values, "<i4").tobytes()).hexdigest()


def to_json(record: RunRecord) -> bytes:
    """Content of run.json."""
    common = record.common.to_dict()
    data = {
        "program": PROGRAM,
        "schema": SCHEMA,
        "version": record.version,
        "versions": record.versions,
        "processor": record.processor,
        "name": record.name,
        "inputs": None if record.inputs is None else dataclasses.asdict(record.inputs),
        "distrusted": _as_dict(record.distrusted),
        "drawn": _as_dict(record.drawn),
        "outside_view": _as_dict(record.outside_view),
        "guide": _as_dict(record.guide),
        "pose": record.pose,
        "extraction": None if record.extraction is None else record.extraction.to_dict(),
        "blocks": {
            "sha256": record.labels_sha256,
            "shape": list(record.shape),
            "edited": record.edited,
            "file": record.labels_file,
        },
        "networks": {"extraction": record.extraction_networks, "filter": record.networks},
        "parameters": common,
        "block_parameters": {
            str(label): {name: value for name, value in own.to_dict().items() if value != common[name]}
            for label, own in record.parameters.items()
            if own != record.common
        },
        "dense": record.dense,
        "export": dataclasses.asdict(record.options),
        "blocks_outcome": [outcome_to_dict(outcome) for outcome in record.outcomes],
        "depth_sha256": record.depth_sha256,
        "outputs": record.outputs,
    }
    return f"{json.dumps(data, indent=2, allow_nan=False)}\n".encode()


def _as_dict(mask: RecordedMask | None) -> dict[str, Any] | None:
    return None if mask is None else dataclasses.asdict(mask)


def _recorded(mask: NDArray[np.bool_] | None, file: str) -> RecordedMask | None:
    return None if mask is None else RecordedMask(array_sha256(mask), file)


def _recorded_guide(guide: Guide | None) -> RecordedGuide | None:
    return None if guide is None else RecordedGuide(array_sha256(guide.array), GUIDE_FILE, guide.path)


def outcome_to_dict(outcome: BlockOutcome) -> dict[str, Any]:
    """A block's outcome, ready for JSON: NaN becomes None."""
    sigma = None if math.isnan(outcome.sigma_i) else outcome.sigma_i
    return dataclasses.asdict(outcome) | {"status": outcome.status.value, "sigma_i": sigma}


def _extraction_networks(run: RunSetup) -> dict[str, str]:
    if run.extraction is None:
        return {}
    return used_network(run.network, asked_networks(run.extraction.detector, run.extraction.model))


def _networks(completion: Completion) -> dict[str, str]:
    # guesses are those of the preset "best"
    used = [(preset(), completion.guess_network)]
    used += [(result.parameters, result.network) for result in completion.results.values()]
    networks: dict[str, str] = {}
    for result in completion.results.values():
        if result.correction is not None:
            networks[CORRECTION] = result.correction
    for parameters, sha256 in dict.fromkeys(used):
        networks |= used_network(sha256, asked_networks(parameters.edges, parameters.model))
    return networks
