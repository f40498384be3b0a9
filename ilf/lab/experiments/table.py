"""The paper's table, Fig. 9 and Table 1: errors over all operation blocks, and the paper's selective mean."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...completion.completion import prepare
from ...completion.interpolation import nearest
from ...data.parameters import PAPER_BLOCKS, PRESETS
from ...errors import IlfError, InputError
from ...evaluation.bench.methods import GROUPS, METHODS
from ...evaluation.bench.patterns import PATTERNS, make_task
from ...evaluation.hold_out import RANDOM_KEPT
from ...segmentation.extraction import extract_blocks
from .experiment import (
    METHOD_PRESETS,
    PAPER_PRESETS,
    Comparison,
    Drawing,
    OnProgress,
    Result,
    Row,
    Settings,
    preset_parameters,
    run_counted,
)
from .plots import colour_of, compared_with_paper, counted, legend, lowest, millimetres, panels, percent
from .sources import FrameSource, find_sources, load_source

DENSE_PATTERNS = {name: PATTERNS[name] for name in ("random", "areas", "ground-truth")}
"""Name -> description of the patterns that leave dense depth."""

EXCLUDED_PEERS = frozenset({"soft-thin-plate"})
"""Peers that are left out because they need gigabytes of memory on large frames."""

PEERS = tuple(name for name in GROUPS["peers"] if name not in EXCLUDED_PEERS)
METHODS_COMPARED = (*METHOD_PRESETS, *PEERS)

_QUICK_PEERS = ("nearest", "linear", "navier-stokes", "dct-smoothing")

ALL_BLOCKS, SELECTIVE = "all blocks", "selective"


@dataclass(frozen=True)
class _Part:
    """Results of one frame under one pattern: rows of blocks and seconds by method, or why it was skipped."""

    blocks: tuple[Row, ...] = ()
    seconds: tuple[tuple[str, float], ...] = ()
    covered_share: float = math.nan
    skip_reason: str = ""


def run_table(settings: Settings, on_progress: OnProgress) -> Result:
    """Score all methods on every block of every frame."""
    sources = find_sources(settings)
    methods = (*METHOD_PRESETS, *_QUICK_PEERS) if settings.quick else METHODS_COMPARED
    units = [(source, pattern, methods, settings.seed) for pattern in DENSE_PATTERNS for source in sources.frames]
    parts = run_counted(_run_unit, units, settings.jobs, on_progress)
    blocks = [row for part in parts for row in part.blocks]
    if not blocks:
        reasons = "; ".join(dict.fromkeys(part.skip_reason for part in parts))
        raise InputError(f"No frame could be scored. {reasons}")
    rows: list[Row] = []
    for pattern in DENSE_PATTERNS:
        of_pattern = [part for unit, part in zip(units, parts, strict=True) if unit[1] == pattern and part.blocks]
        rows += _summaries(pattern, of_pattern, methods)
    frames = {pattern: len({row["frame"] for row in blocks if row["pattern"] == pattern}) for pattern in DENSE_PATTERNS}
    return Result(
        rows=rows,
        parameters={
            "frames": [source.name for source in sources.frames],
            "frames_scored": frames,
            "patterns": dict(DENSE_PATTERNS),
            "random_kept": RANDOM_KEPT,
            "extraction": PAPER_BLOCKS.to_dict(),
            "presets": preset_parameters(),
            "skip_reason": sorted(EXCLUDED_PEERS),
            "chosen": "Blocks are extracted from the frame without the held-out depth; pixels outside blocks do not "
            "count. Pixels that a method does not fill count with their nearest known depth. The paper's peer NLSPN, a "
            "learned network, is not run: the selective mean is computed against the classical peers of `ilf bench`.",
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
    """Explain why frames were skipped, except for missing ground truth, which most frames lack."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for (source, pattern, *_), part in zip(units, parts, strict=True):
        if part.skip_reason and pattern != "ground_truth":
            reasons.setdefault((pattern, part.skip_reason), []).append(source.name)
    return [f"Left out for {pattern}: {', '.join(names)}. {reason}" for (pattern, reason), names in reasons.items()]


def _run_unit(source: FrameSource, pattern: str, methods: Sequence[str], seed: int) -> _Part:
    try:
        task = make_task(load_source(source), pattern, seed)
    except IlfError as error:
        return _Part(skip_reason=str(error))
    labels = extract_blocks(task.frame, PAPER_BLOCKS)
    for name in set(methods) & set(PRESETS):
        prepare(task.frame, PRESETS[name])  # edges, computed once and not timed
    scored = task.scored & (labels > 0)
    if not scored.any():
        return _Part(skip_reason="No held-out pixel lies in a block.")
    fallback = nearest(task.frame)
    places, ground_truth = labels[scored], task.ground_truth[scored].astype(np.float64)
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
        off = dense - ground_truth
        squares, sizes, shares = (
            np.bincount(places, weights=values) for values in (off**2, np.abs(off), np.abs(off) / ground_truth)
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
    """Return rows over all blocks, one per method; then rows of the selective mean, one per preset and peer."""
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
    """Return the mean over only those blocks where the method's RMSE is below the peer's, as in the paper."""
    won = [(own, other) for own, other in zip(mine, theirs, strict=True) if own["rmse_mm"] < other["rmse_mm"]]
    of_peer = _means([other for _, other in won])
    return {
        "method": name, "pattern": pattern, "scope": SELECTIVE, "peer": peer, "frames": frames,
        **_means([own for own, _ in won]), "share_of_hidden": None, "share_won": len(won) / len(mine),
        "peer_rmse_mm": of_peer["rmse_mm"], "peer_mae_mm": of_peer["mae_mm"], "peer_rel": of_peer["rel"],
        "seconds": None,
    }  # fmt: skip


def _means(blocks: Iterable[Row]) -> Row:
    """Return errors over blocks, weighted by their pixels; None without blocks."""
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


# Figures and comparison texts of the table experiment.

_PAPER = {"rmse_mm": 300.224, "mae_mm": 173.014, "rel": 0.008}
_PAPER_PEER = {"rmse_mm": 1962.779, "mae_mm": 1935.296, "rel": 0.701}
_PAPER_BLOCKS = 9409


def draw_table(result: Result) -> list[Drawing]:
    """Draw bars of RMSE and MAE over all blocks, and the selective mean beside the fair one."""
    return [_draw_all(result.rows), _draw_selective(result.rows)]


def _draw_all(rows: list[Row]) -> Drawing:
    rows = [row for row in rows if row["scope"] == ALL_BLOCKS]
    patterns = list(dict.fromkeys(row["pattern"] for row in rows))
    figure, axes = panels(1, len(patterns), width=4.3, height=4.4)
    for ax, pattern in zip(axes, patterns, strict=True):
        mine = sorted((row for row in rows if row["pattern"] == pattern), key=lambda row: -row["rmse_mm"])
        places = range(len(mine))
        colours = [colour_of(row["method"]) if row["method"] in PRESETS else "#b8bec6" for row in mine]
        ax.barh([place + 0.2 for place in places], [row["rmse_mm"] for row in mine], 0.38, color=colours)
        ax.barh([place - 0.2 for place in places], [row["mae_mm"] for row in mine], 0.38, color=colours, alpha=0.5)
        for place, row in enumerate(mine):
            ax.annotate(
                f" {row['rmse_mm']:.0f} / {row['mae_mm']:.1f}", (row["rmse_mm"], place), fontsize=7, va="center"
            )
        ax.set_yticks(places, [row["method"] for row in mine])
        ax.set_xlim(0, 1.3 * mine[0]["rmse_mm"])
        ax.grid(False, axis="y")
        ax.set_xlabel("RMSE / MAE (paler) [mm]")
        ax.set_title(
            f"{pattern}: {counted(mine[0]['frames'], 'frame')}, {counted(mine[0]['blocks'], 'block')}", fontsize=9
        )
    caption = "RMSE and MAE over all operation blocks, weighted by pixels; the presets in colour, the peers in grey."
    return Drawing("all-blocks", caption, figure)


def _draw_selective(rows: list[Row]) -> Drawing:
    fair = {(row["pattern"], row["method"]): row for row in rows if row["scope"] == ALL_BLOCKS}
    pairs = [row for row in rows if row["scope"] == SELECTIVE and row["method"] == "paper" and row["blocks"]]
    patterns = list(dict.fromkeys(row["pattern"] for row in pairs))
    figure, axes = panels(1, max(len(patterns), 1), width=4.3, height=4.2)
    for ax, pattern in zip(axes, patterns, strict=False):
        mine = [row for row in pairs if row["pattern"] == pattern]
        places = range(len(mine))
        series = (
            ("paper, all blocks", [fair[pattern, "paper"]["rmse_mm"]] * len(mine), "#d1495b", 0.5),
            ("paper, blocks it wins", [row["rmse_mm"] for row in mine], "#d1495b", 1.0),
            ("peer, all blocks", [fair[pattern, row["peer"]]["rmse_mm"] for row in mine], "#7d8791", 0.5),
            ("peer, the same blocks", [row["peer_rmse_mm"] for row in mine], "#7d8791", 1.0),
        )
        for offset, (label, values, colour, alpha) in zip((0.3, 0.1, -0.1, -0.3), series, strict=True):
            ax.barh([place + offset for place in places], values, 0.18, color=colour, alpha=alpha, label=label)
        ax.set_yticks(places, [f"{row['peer']} ({row['share_won']:.0%} won)" for row in mine])
        ax.grid(False, axis="y")
        ax.set_xlabel("RMSE [mm]")
        ax.set_title(pattern, fontsize=9)
    legend(figure, axes[0], columns=4)
    caption = (
        "Effect of the paper's selection: the mean over all blocks (pale) beside the mean over only those blocks where "
        "the preset paper has the smaller RMSE (full)."
    )
    return Drawing("selective", caption, figure)


def compare_table(rows: list[Row]) -> list[Comparison]:
    """Compare the fair and the selective mean with the paper's table."""
    comparisons = []
    for pattern in dict.fromkeys(row["pattern"] for row in rows):
        fair = {row["method"]: row for row in rows if row["pattern"] == pattern and row["scope"] == ALL_BLOCKS}
        chosen = [row for row in rows if row["pattern"] == pattern and row["scope"] == SELECTIVE]
        for method in METHOD_PRESETS:
            comparisons.append(_fair(pattern, method, fair))
        for method in METHOD_PRESETS:
            comparisons.append(
                _selective_comparison(pattern, method, fair, [row for row in chosen if row["method"] == method])
            )
    return comparisons


def _values(row: Row, prefix: str = "") -> str:
    rmse, mae, rel = (row[prefix + name] for name in ("rmse_mm", "mae_mm", "rel"))
    return f"RMSE {millimetres(rmse)}, MAE {millimetres(mae)}, Rel {rel:.4f}"


def _published(values: Row) -> str:
    return f"RMSE {values['rmse_mm']} mm, MAE {values['mae_mm']} mm, Rel {values['rel']}"


def _fair(pattern: str, method: str, fair: dict[str, Row]) -> Comparison:
    row = fair[method]
    place = sorted(fair.values(), key=lambda other: other["rmse_mm"]).index(row) + 1
    winner = lowest((other for name, other in fair.items() if name != method), lambda other: other["rmse_mm"])
    relation = "behind" if winner["rmse_mm"] < row["rmse_mm"] else "ahead of"
    text = f"Number {place} of {len(fair)} methods by RMSE, {relation} {winner['method']} "
    text += f"({millimetres(winner['rmse_mm'])}). "
    if pattern == "random":
        text += (
            f"RMSE is {compared_with_paper(row['rmse_mm'], _PAPER['rmse_mm'])}, but the paper's numbers are over other "
            f"frames and over won blocks only: {_PAPER_BLOCKS} blocks there, {row['blocks']} here."
        )
        paper = f"{_published(_PAPER)} (won blocks only)"
    else:
        text += f"{counted(row['blocks'], 'block')} of {counted(row['frames'], 'frame')}; "
        text += "the paper's table does not have this pattern."
        paper = "not measured"
    return Comparison(f"All blocks, {pattern}, {method}", paper, _values(row), text)


def _selective_comparison(pattern: str, method: str, fair: dict[str, Row], pairs: list[Row]) -> Comparison:
    """Compare with the peer against which the selection gains most."""
    shares = [row["share_won"] for row in pairs]
    span = f"{percent(round(min(shares), 3))} (against {lowest(pairs, lambda row: row['share_won'])['peer']}) to "
    span += f"{percent(round(max(shares), 3))} (against {lowest(pairs, lambda row: -row['share_won'])['peer']})"
    where = [row for row in pairs if row["blocks"]]
    text = f"It wins {span} of the blocks. "
    ours = "no block won"
    if where:
        row = max(where, key=lambda item: _ratio(item) / _fair_ratio(item, fair))
        ours = f"{_values(row)} against {row['peer']}: {_values(row, 'peer_')} "
        ours += f"({row['blocks']} of {fair[method]['blocks']} blocks)"
        text += (
            f"The selection changes most against {row['peer']}: over all blocks the peer's RMSE is "
            f"{_fair_ratio(row, fair):.2f} times that of {method}, over the won blocks alone {_ratio(row):.2f} times. "
            "A mean over won blocks favours the method that selects them."
        )
        if method in PAPER_PRESETS and pattern == "random":
            text += f" Without the pixel weight, as in the paper, Rel would be {row['rel_unweighted']:.4f}."
    return Comparison(
        f"Selective mean as in the paper, {pattern}, {method}",
        f"ILF {_published(_PAPER)}; NLSPN {_published(_PAPER_PEER)} ({_PAPER_BLOCKS} blocks)"
        if pattern == "random"
        else "not measured",
        ours,
        text,
    )


def _ratio(row: Row) -> float:
    return float(row["peer_rmse_mm"] / max(row["rmse_mm"], 1e-9))


def _fair_ratio(row: Row, fair: dict[str, Row]) -> float:
    return float(fair[row["peer"]]["rmse_mm"] / max(fair[row["method"]]["rmse_mm"], 1e-9))
