"""The paper's table, Fig. 9 and Table 1: errors over all operation blocks, and the paper's selective mean."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..bench.methods import GROUPS, METHODS
from ..bench.patterns import PATTERNS, make_task
from ..bench.peers.interpolation import nearest
from ..completion import prepare
from ..ebs import extract_blocks
from ..errors import IlfError, InputError
from ..judgement.hiding import RANDOM_KEPT
from ..parameters import PAPER_BLOCKS, PRESETS
from .experiment import METHOD_PRESETS, OnProgress, Result, Row, Settings, preset_parameters
from .sources import FrameSource, find_sources, load_source
from .units import run_counted
from .verdicts import counted

HEAVY = frozenset({"soft-thin-plate"})
"""Peers that are left out: they take gigabytes on large frames."""

PEERS = tuple(name for name in GROUPS["peers"] if name not in HEAVY)
METHODS_COMPARED = (*METHOD_PRESETS, *PEERS)

_QUICK_PEERS = ("nearest", "linear", "navier-stokes", "dct-smoothing")

ALL_BLOCKS, SELECTIVE = "all blocks", "selective"


@dataclass(frozen=True)
class _Part:
    """What one frame under one pattern gave: rows of blocks, seconds by method, or why it was left out."""

    blocks: tuple[Row, ...] = ()
    seconds: tuple[tuple[str, float], ...] = ()
    covered_share: float = math.nan
    left_out: str = ""


def run_table(settings: Settings, on_progress: OnProgress) -> Result:
    """Score all methods on every block of every frame."""
    sources = find_sources(settings)
    methods = (*METHOD_PRESETS, *_QUICK_PEERS) if settings.quick else METHODS_COMPARED
    units = [(source, pattern, methods, settings.seed) for pattern in PATTERNS for source in sources.frames]
    parts = run_counted(_run_unit, units, settings.jobs, on_progress)
    blocks = [row for part in parts for row in part.blocks]
    if not blocks:
        reasons = "; ".join(dict.fromkeys(part.left_out for part in parts))
        raise InputError(f"No frame could be scored: {reasons}")
    rows: list[Row] = []
    for pattern in PATTERNS:
        of_pattern = [part for unit, part in zip(units, parts, strict=True) if unit[1] == pattern and part.blocks]
        rows += _summaries(pattern, of_pattern, methods)
    frames = {pattern: len({row["frame"] for row in blocks if row["pattern"] == pattern}) for pattern in PATTERNS}
    return Result(
        rows=rows,
        parameters={
            "frames": [source.name for source in sources.frames],
            "frames_scored": frames,
            "patterns": dict(PATTERNS),
            "random_kept": RANDOM_KEPT,
            "extraction": PAPER_BLOCKS.to_dict(),
            "presets": preset_parameters(),
            "left_out": sorted(HEAVY),
            "chosen": "Blocks come from the frame with the hidden depth removed; pixels of no block do not count. A "
            "method's open pixels count with their nearest known depth. The paper's peer NLSPN, a learned network, is "
            "not run: the selective mean is shown against the classical peers of `ilf bench`.",
        },
        notes=[*sources.notes, *_frame_notes(frames, len(sources.frames)), *_left_out_notes(units, parts)],
        tables={"blocks": blocks},
    )


def _frame_notes(frames: dict[str, int], given: int) -> list[str]:
    counts = ", ".join(f"{pattern} {count}" for pattern, count in frames.items())
    return [f"{counted(given, 'frame')}; scored by pattern: {counts}."]


def _left_out_notes(
    units: Sequence[tuple[FrameSource, str, tuple[str, ...], int]], parts: Sequence[_Part]
) -> list[str]:
    """Why frames were left out; that most have no measured truth goes without saying."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for (source, pattern, *_), part in zip(units, parts, strict=True):
        if part.left_out and pattern != "truth":
            reasons.setdefault((pattern, part.left_out), []).append(source.name)
    return [f"Left out for {pattern}: {', '.join(names)}. {reason}" for (pattern, reason), names in reasons.items()]


def _run_unit(source: FrameSource, pattern: str, methods: Sequence[str], seed: int) -> _Part:
    try:
        task = make_task(load_source(source), pattern, seed)
    except IlfError as error:
        return _Part(left_out=str(error))
    labels = extract_blocks(task.frame, PAPER_BLOCKS)
    for name in set(methods) & set(PRESETS):
        prepare(task.frame, PRESETS[name])  # the edges, once for all and outside the seconds
    scored = task.scored & (labels > 0)
    if not scored.any():
        return _Part(left_out="No hidden pixel lies in a block.")
    fallback = nearest(task.frame)
    places, truth = labels[scored], task.truth[scored].astype(np.float64)
    pixels = np.bincount(places)
    rows: list[Row] = []
    seconds = []
    for name in methods:
        started = time.perf_counter()
        try:
            depth = METHODS[name].run(task.frame, labels)
        except (IlfError, MemoryError):
            depth = task.frame.depth  # failing counts as filling nothing
        seconds.append((name, time.perf_counter() - started))
        dense = np.where(np.isfinite(depth) & (depth > 0), depth, fallback)[scored]
        off = dense - truth
        squares, sizes, shares = (
            np.bincount(places, weights=values) for values in (off**2, np.abs(off), np.abs(off) / truth)
        )
        rows += [
            {
                "pattern": pattern,
                "frame": source.name,
                "block": int(label),
                "method": name,
                "pixels": int(pixels[label]),
                "rmse_mm": 1000 * math.sqrt(squares[label] / pixels[label]),
                "mae_mm": 1000 * sizes[label] / pixels[label],
                "rel": shares[label] / pixels[label],
            }
            for label in np.flatnonzero(pixels)
        ]
    share = np.count_nonzero(scored) / np.count_nonzero(task.scored)
    return _Part(tuple(rows), tuple(seconds), share)


def _summaries(pattern: str, parts: Sequence[_Part], methods: Sequence[str]) -> list[Row]:
    """Rows over all blocks, one per method; then rows of the selective mean, one per preset and peer."""
    if not parts:
        return []
    by_method = {name: [row for part in parts for row in part.blocks if row["method"] == name] for name in methods}
    scored_share = float(np.mean([part.covered_share for part in parts]))
    rows: list[Row] = []
    for name in methods:
        seconds = [took for part in parts for method, took in part.seconds if method == name]
        rows.append({
            "method": name, "pattern": pattern, "scope": ALL_BLOCKS, "peer": None, "frames": len(parts),
            **_means(by_method[name]), "share_of_hidden": scored_share, "share_won": None,
            "peer_rmse_mm": None, "peer_mae_mm": None, "peer_rel": None, "seconds": float(np.median(seconds)),
        })  # fmt: skip
    for name in (method for method in methods if method in PRESETS):
        for peer in (method for method in methods if method not in PRESETS):
            rows.append(_selective(pattern, len(parts), by_method[name], by_method[peer], name, peer))
    return rows


def _selective(pattern: str, frames: int, mine: Sequence[Row], theirs: Sequence[Row], name: str, peer: str) -> Row:
    """The mean over only those blocks where the method's RMSE is below the peer's, as the paper takes it."""
    won = [(own, other) for own, other in zip(mine, theirs, strict=True) if own["rmse_mm"] < other["rmse_mm"]]
    of_peer = _means([other for _, other in won])
    return {
        "method": name, "pattern": pattern, "scope": SELECTIVE, "peer": peer, "frames": frames,
        **_means([own for own, _ in won]), "share_of_hidden": None, "share_won": len(won) / len(mine),
        "peer_rmse_mm": of_peer["rmse_mm"], "peer_mae_mm": of_peer["mae_mm"], "peer_rel": of_peer["rel"],
        "seconds": None,
    }  # fmt: skip


def _means(blocks: Iterable[Row]) -> Row:
    """Errors over blocks, weighted by their pixels; None where there is no block."""
    blocks = list(blocks)
    pixels = np.array([row["pixels"] for row in blocks], np.float64)
    if not blocks:
        return {"blocks": 0, "pixels": 0, "rmse_mm": None, "mae_mm": None, "rel": None, "rel_unweighted": None}
    rmse, mae, rel = (np.array([row[key] for row in blocks]) for key in ("rmse_mm", "mae_mm", "rel"))
    return {
        "blocks": len(blocks),
        "pixels": int(pixels.sum()),
        "rmse_mm": float(np.sqrt(np.average(rmse**2, weights=pixels))),
        "mae_mm": float(np.average(mae, weights=pixels)),
        "rel": float(np.average(rel, weights=pixels)),
        "rel_unweighted": float(rel.mean()),
    }
