"""Effect of other edges on hold-outs: `python -m tests.bench.edges_effect FRAME ... [--seeds 1 2 3] [--ways ...]`.

Depth of every frame is held out, and blocks are extracted and completed without it: with contours of the colour image
for blocks and filter, and in several other ways. For each way, prints the geometric mean over frames and seeds of its
hold-out error / the error with contours, and how often it is smaller.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from ilf.cli.parsing import value_from
from ilf.completion.interpolation import nearest
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import PAPER_BLOCKS, BlockParameters, Parameters
from ilf.data.presets import preset
from ilf.evaluation.bench.frames import BenchFrame, find_frames, load_bench_frame
from ilf.evaluation.bench.patterns import make_task
from ilf.run.run import complete
from ilf.segmentation.edges.depth_edges import DepthEdgeNetwork
from ilf.segmentation.edges.frame_edges import FrameEdges, find_edges, joined, relief_of
from ilf.segmentation.edges.relief import find_relief
from ilf.segmentation.extraction import extract

Array = NDArray[np.float32]

RGBD = BlockParameters(detector="rgbd")


@dataclass(frozen=True)
class Seen:
    """Inputs of a way: edges of both detectors and known jumps of the frame without the held-out depth, and the ground
    truth."""

    contours: FrameEdges
    rgbd: FrameEdges
    jumps: NDArray[np.bool_]
    ground_truth: RGBDFrame


@dataclass(frozen=True)
class Way:
    """Sources of the edges for blocks and filter, and changed parameters of the filter."""

    edges: Callable[[Seen], FrameEdges]
    blocks: BlockParameters = PAPER_BLOCKS
    changes: Mapping[str, object] = field(default_factory=dict)


def _with(seen: Seen, strength: Array) -> FrameEdges:
    return replace(seen.rgbd, strength=np.where(seen.jumps, np.float32(1), strength))


def _true_jumps(seen: Seen) -> FrameEdges:
    """Edges from the held-out depth, as an upper bound of the gain."""
    edges = find_relief(seen.ground_truth.depth, RGBD.depth_jump, RGBD.depth_jump_share).edges
    return replace(seen.contours, strength=edges.astype(np.float32))


BEFORE = "contours"
WAYS: dict[str, Way] = {
    BEFORE: Way(lambda seen: seen.contours),
    "filter": Way(lambda seen: seen.rgbd),
    "filter, no creases": Way(lambda seen: replace(seen.rgbd, crease=None)),
    "filter, crests alone": Way(lambda seen: _with(seen, joined(seen.rgbd.detected))),
    "filter, jumps alone": Way(lambda seen: _with(seen, seen.rgbd.detected)),
    "filter, larger of both": Way(lambda seen: _with(seen, np.maximum(seen.contours.detected, seen.rgbd.detected))),
    "filter, product of both": Way(lambda seen: _with(seen, np.sqrt(seen.contours.detected * seen.rgbd.detected))),
    "blocks": Way(lambda seen: seen.contours, RGBD),
    "blocks with creases": Way(lambda seen: seen.contours, RGBD.replace(use_creases=True)),
    "blocks and filter": Way(lambda seen: seen.rgbd, RGBD),
    "true jumps": Way(_true_jumps),
}


def errors(source: BenchFrame, ways: Mapping[str, Way], pattern: str, seed: int) -> dict[str, tuple[float, float]]:
    """Return RMSE and MAE [m] of every way; pixels that are not filled count with the nearest known depth."""
    task = make_task(source, pattern, seed)
    frame = task.frame
    jumps = relief_of(frame, RGBD).edges
    seen = Seen(find_edges(frame, PAPER_BLOCKS), find_edges(frame, RGBD), jumps, source.frame)
    if seen.rgbd.notes:
        raise SystemExit(" ".join(seen.rgbd.notes))
    fallback = nearest(frame)
    found = {}
    for name, way in ways.items():
        labels = extract(frame, way.blocks).blocks
        with patch("ilf.completion.filter.find_edges", return_value=way.edges(seen)):
            depth = complete(frame, labels, preset(**way.changes)).depth
        off = (
            np.where(np.isfinite(depth), depth, fallback)[task.scored].astype(np.float64)
            - task.ground_truth[task.scored]
        )
        found[name] = float(np.sqrt(np.mean(off**2))), float(np.mean(np.abs(off)))
    return found


def main() -> None:
    """Print the comparison of the ways."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("frames", nargs="+", type=Path)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--pattern", default="areas")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS), metavar="WAY")
    parser.add_argument("--network", type=Path, help="depth-edge network to use instead of the bundled one")
    parser.add_argument(
        "--set", nargs="+", default=[], metavar="NAME=VALUE", help="parameters of the filter, of all ways but the first"
    )
    arguments = parser.parse_args()
    known = Parameters.declarations()
    changes = {name: value_from(known[name], text) for name, text in (one.split("=") for one in arguments.set)}
    ways = {BEFORE: WAYS[BEFORE]}
    ways |= {name: replace(WAYS[name], changes=changes) for name in arguments.ways if name != BEFORE}
    ratios: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    network = arguments.network and DepthEdgeNetwork.load(arguments.network)
    with patch("ilf.segmentation.edges.frame_edges.load_depth_network", lambda: network) if network else patch.dict({}):
        for folder in find_frames(arguments.frames):
            source = load_bench_frame(folder)
            for seed in arguments.seeds:
                found = errors(source, ways, arguments.pattern, seed)
                rmse, mae = found[BEFORE]
                for name, (own_rmse, own_mae) in found.items():
                    ratios[name].append((own_rmse / rmse, own_mae / mae))
                row = "  ".join(f"{one:.3f}/{other:.3f}" for one, other in (ratios[name][-1] for name in ways))
                print(f"{source.frame.name:24} {seed}  {1000 * rmse:6.1f} {1000 * mae:6.1f}  {row}", flush=True)
    for name, of_way in ratios.items():
        means = np.exp(np.mean(np.log(of_way), axis=0))
        better = np.mean(np.less(of_way, 1), axis=0)
        print(
            f"{name:28} RMSE {means[0]:.3f}, MAE {means[1]:.3f} of that with contours; smaller in {better[0]:.0%} and "
            f"{better[1]:.0%} of {len(of_way)}"
        )


if __name__ == "__main__":
    main()
