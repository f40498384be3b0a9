"""The completion of a recorded run, from the files beside its record instead of another run."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import file_sha256
from .._runtime.networks.models import CORRECTION, SPARSE_CORRECTION
from ..completion.block import BlockTask
from ..completion.correction import needs_correction
from ..data.blocks import Block, find_blocks
from ..data.parameters import Parameters
from ..data.presets import preset
from ..data.results import BlockOutcome, BlockResult, Completion, History, compose
from ..io.depth import read_depth_values
from ..io.encodings import encoding_of
from ..io.labels import read_mask
from ..segmentation.edges.frame_edges import edge_parameters
from . import files
from .curves import read_curves
from .options import DEPTH_FILES
from .record import RunRecord, array_sha256, requested_networks
from .run import Run


def recorded_depth(record: RunRecord, folder: Path) -> NDArray[np.float32] | None:
    """The recorded depth [m], (H, W), from a lossless file beside the record; None if there is none."""
    for name in (DEPTH_FILES["npy"], DEPTH_FILES["tiff"]):
        if _is_as_written(record, folder, name):
            return encoding_of(1.0).metres(read_depth_values(folder / name))
    return None


def recorded_completion(
    run: Run, record: RunRecord, folder: Path, depth: NDArray[np.float32] | None
) -> Completion | None:
    """The completion of a recorded run with its recorded depth; None if the files beside the record do not give it.

    Its curves have no seconds, and none at all without the file of the curves.
    """
    if depth is None or depth.shape != run.frame.shape:
        return None
    extrapolated = np.zeros(depth.shape, bool)
    if record.extrapolate:
        if not _is_as_written(record, folder, files.EXTRAPOLATED):
            return None
        extrapolated = read_mask(folder / files.EXTRAPOLATED, depth.shape)
    of_blocks = np.where(extrapolated, np.float32(np.nan), depth)
    curves = read_curves(folder / files.CURVES) if _is_as_written(record, folder, files.CURVES) else {}
    blocks = find_blocks(run.blocks.labels, run.only)
    results = {
        outcome.label: _result(run, record, blocks[outcome.label], outcome, of_blocks, curves.get(outcome.label, ()))
        for outcome in record.blocks_outcome
    }
    completion = compose(run, results)
    if record.extrapolate:
        completion = replace(
            completion,
            depth=np.where(extrapolated, depth, completion.depth),
            filled=completion.filled | extrapolated,
            extrapolated=extrapolated,
            extrapolation_network=_network(record, preset()),
        )
    return completion if array_sha256(completion.depth) == record.depth_sha256 else None


def _is_as_written(record: RunRecord, folder: Path, name: str) -> bool:
    path = folder / name
    return name in record.outputs and os.path.isfile(path) and file_sha256(path) == record.outputs[name]


def _result(
    run: Run, record: RunRecord, block: Block, outcome: BlockOutcome, depth: NDArray[np.float32], history: History
) -> BlockResult:
    """The result of a block, with what its run had; a block that was not iterated on has no network."""
    parameters = record.own_parameters[outcome.label]
    task = BlockTask.of(run.frame, block, parameters, run.blocks)
    edges = edge_parameters(parameters, task.extraction)
    found = depth[block.box][block.mask]
    result = BlockResult(block, found, outcome, history, parameters, edges=edges, drawn=task.drawn)
    if not outcome.iterations:
        return result
    used = (record.networks.filter.get(name) for name in (CORRECTION, SPARSE_CORRECTION))
    correction = tuple(sha256 for sha256 in used if sha256 is not None) if needs_correction(result) else ()
    return replace(result, network=_network(record, parameters), correction=correction, by_hand=task.by_hand)


def _network(record: RunRecord, parameters: Parameters) -> str | None:
    """SHA-256 of the recorded edge network that these parameters use; None if they use none."""
    if parameters.filter != "edge-aware":
        return None
    names = requested_networks(parameters.edges, parameters.model)
    return next((record.networks.filter[name] for name in names if name in record.networks.filter), None)
