"""Digests that identify the state of a frame: over everything that a project stores of it."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from gui.state.document import Document
from ilf.data.blocks import BlockInfo, block_colour
from ilf.data.results import BlockResult
from ilf.project.frame_state import FrameState
from ilf.project.run_history import StoredRun


def digest_of_session(document: Document) -> str:
    """Digest of the current state of an open frame."""
    return digest(document.snapshot())


def digest(state: FrameState) -> str:
    """Digest of a frame's state, without its view."""
    found, notes = hashlib.sha1(), state.blocks
    infos = {
        label: [info.name, list(info.colour), info.visible, info.locked]
        for label, info in sorted(notes.infos.items())
        if info != BlockInfo(f"Block {label}", block_colour(label))
    }
    plain = [
        infos,
        {label: dict(own) for label, own in sorted(notes.own.items())},
        None if notes.extraction is None else notes.extraction.to_dict(),
        sorted(notes.kept),
        sorted(notes.handmade),
        state.common.to_dict(),
        state.next_number,
        state.extrapolate,
        state.own_parameters,
        state.note,
        sorted(state.to_check),
        [[run.number, run.name, run.note, run.how, sorted(run.done)] for run in state.runs],
    ]
    found.update(json.dumps(plain, default=str).encode())
    for array in (state.blocks.labels, notes.drawn, notes.extracted, state.frame.invalid_mask, state.frame.measured):
        _add(found, array)
    _add_results(found, state.results)
    for run in state.runs:
        _add_run(found, run)
    return found.hexdigest()


def _add_run(found: Any, kept: StoredRun) -> None:
    _add(found, kept.run.blocks.labels)
    _add_results(found, kept.results)


def _add_results(found: Any, results: Mapping[int, BlockResult]) -> None:
    for label, result in sorted(results.items()):
        found.update(f"{label} {result.outcome.iterations} {result.outcome.status}".encode())
        _add(found, result.depth)


def _add(found: Any, array: np.ndarray | None) -> None:
    if array is not None and array.any():
        found.update(str(array.shape).encode() + np.ascontiguousarray(array).tobytes())
