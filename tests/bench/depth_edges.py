"""Detection of jumps in missing depth, on held-out generated pictures, or on frames with hidden areas.

    python -m tests.bench.depth_edges --pictures FOLDER
    python -m tests.bench.depth_edges --frames FRAME... --seed 1

Average precision and best F of lines, with tolerances of 1, 2 and 4 px, over all pixels whose depth is missing: for the
depth-edge network, the known depth alone (`find_relief`), the edge network of colour alone, and the known depth
together with either network. Also the mean error of the coarse depth as a share of the depth, beside that of the
nearest known pixel and of filling from the surroundings. Needs no PyTorch.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.installation import asset_path
from ilf._runtime.networks.models import BUNDLED
from ilf.data.parameters import BlockParameters
from ilf.evaluation.hold_out import frame_without, hidden_pixels
from ilf.lab.bench.frames import find_frames, load_bench_frame
from ilf.segmentation.edges.depth_edges import DepthEdgeNetwork, filled_log_depth
from ilf.segmentation.edges.detectors import load_model
from ilf.segmentation.edges.relief import filled_depth, find_relief

sys.path.insert(0, str(Path(__file__).parents[2] / "assets" / "models"))
from recipes.lines import LineScore
from recipes.pictures import PictureFolder, read_picture, with_hidden_depth

TOLERANCES = (1, 2, 4)
"""Tolerances of lines [px]; colour and depth of real frames are often some pixels apart."""

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Case:
    """Colour, depth with holes, and ground truth: depth [m], jumps and, if known, creases."""

    rgb: NDArray[np.uint8]
    depth: Array
    missing: Mask
    ground_truth: Array
    jump: Mask
    crease: Mask | None


def generated(folder: Path) -> Iterator[Case]:
    """Held-out pictures, with depth hidden as in training."""
    for k, picture in enumerate(map(read_picture, PictureFolder(folder).held_out)):
        depth = with_hidden_depth(picture, np.random.default_rng((1, k)))
        jump, crease = picture.lines[..., 0] > 0, picture.lines[..., 1] > 0
        yield Case(picture.rgb, depth, np.isnan(depth), picture.exact, jump, crease)


def real(folders: Sequence[Path], seed: int) -> Iterator[Case]:
    """Frames with hidden areas; jumps come from the full known depth."""
    for folder in find_frames(list(folders)):
        frame = load_bench_frame(folder).frame
        hidden = hidden_pixels(frame, "areas", seed)
        jump = find_relief(frame.depth, *_JUMP).edges
        yield Case(frame.rgb, frame_without(frame, "areas", seed).depth, hidden, frame.depth, jump, None)


_JUMP = (BlockParameters().depth_jump, BlockParameters().depth_jump_share)


def measure(cases: Iterator[Case], network: DepthEdgeNetwork) -> Iterator[str]:
    """Results as lines of a table."""
    jumps: dict[str, list[LineScore]] = {}
    creases = [LineScore(tolerance) for tolerance in TOLERANCES]
    errors: dict[str, list[Array]] = {}
    spreads: list[Array] = []
    contours = load_model(BUNDLED)
    for case in cases:
        found = network.look(case.rgb, case.depth)
        relief = find_relief(case.depth, *_JUMP).edges.astype(np.float32)
        colour = contours.strength(case.rgb)
        strengths = {
            "network": found.jump,
            "relief": relief,
            "contours": colour,
            "network and relief": np.maximum(relief, found.jump),
            "contours and relief": np.maximum(relief, colour),
        }
        for name, strength in strengths.items():
            for score in jumps.setdefault(name, [LineScore(tolerance) for tolerance in TOLERANCES]):
                score.add(strength, case.jump, case.missing)
        if case.crease is not None:
            for score in creases:
                score.add(found.crease, case.crease, case.missing)
        if found.coarse is None or found.spread is None:
            continue
        counted = case.missing & np.isfinite(case.ground_truth)
        ground_truth = np.log(case.ground_truth[counted])
        extrapolations = {
            "coarse": np.log(found.coarse),
            "nearest": np.log(filled_depth(case.depth)),
            "filled": filled_log_depth(case.depth)[0],
        }
        for name, guess in extrapolations.items():
            errors.setdefault(name, []).append(np.abs(guess[counted] - ground_truth))
        spreads.append(found.spread[counted])
    lines = {f"jump, {name}": scores for name, scores in jumps.items()}
    if creases[0].true:
        lines["crease, network"] = creases
    for name, scores in lines.items():
        figures = ", ".join(f"{one.average_precision:.3f} {one.best_f:.3f}" for one in scores)
        yield f"{name}: AP and F, tolerances {TOLERANCES} px: {figures}"
    for name, parts in errors.items():
        error = np.concatenate(parts)
        yield f"depth, {name}: mean {error.mean():.4f}, median {np.median(error):.4f}"
    within = np.mean(np.concatenate(errors["coarse"]) <= np.concatenate(spreads))
    yield f"coarse within its spread: {within:.1%} (63.2% would be right)"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the measures of detected jumps."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.depth_edges", description=__doc__.partition("\n")[0])
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--pictures", type=Path, help="folder of generated pictures")
    what.add_argument("--frames", type=Path, nargs="+", help="folders of real frames")
    parser.add_argument("--model", type=Path, default=None, help="the network as ONNX (default: the bundled one)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the hidden areas (default: %(default)s)")
    given = parser.parse_args(arguments)
    network = DepthEdgeNetwork.load(given.model or asset_path("models/depth-edges.onnx"))
    cases = generated(given.pictures) if given.pictures else real(given.frames, given.seed)
    for line in measure(cases, network):
        print(line)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
