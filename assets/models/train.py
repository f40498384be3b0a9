"""Train a network anew: `python assets/models/train.py NAME --data FOLDER --out FOLDER`.

README.md, beside this file, has the commands of each network. Training needs PyTorch and onnx; using the networks does
not. It may be interrupted, and continues with `--resume`.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from ilf.errors import IlfError
from ilf.evaluation.bench.frames import load_bench_frame

if TYPE_CHECKING:
    from recipes.trainer import Recipe

MINUTES = {"depth-edges": 480, "contours": 480, "correction": 90, "sparse-correction": 24, "bsds500": 70}
"""Network -> total training time if none is given."""


def recipe_of(given: argparse.Namespace) -> Recipe:
    """The recipe of the network that is named, with its samples."""
    if given.network == "depth-edges":
        from recipes.depth_edges import DepthEdgeRecipe
        from recipes.pictures import PictureFolder

        return DepthEdgeRecipe(PictureFolder(given.data))
    if given.network == "contours":
        from recipes.contours import ContourRecipe
        from recipes.pictures import PictureFolder

        frames = [load_bench_frame(folder).frame for folder in given.frames]
        return ContourRecipe(PictureFolder(given.data), frames, given.start)
    if given.network == "correction":
        from recipes.correction import CorrectionRecipe
        from recipes.correction_samples import SampleFolder

        return CorrectionRecipe(SampleFolder(given.data), given.start)
    if given.network == "sparse-correction":
        from recipes.sparse_correction import SparseCorrectionRecipe
        from recipes.sparse_samples import make_samples

        make_samples(given.frames, given.data, given.jobs)
        return SparseCorrectionRecipe(given.data, given.start)
    from recipes.bsds500 import Bsds500Recipe
    from recipes.bsds500_images import load_examples

    return Bsds500Recipe(*load_examples(given.data))


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments; each network has its own besides those of all."""
    parser = argparse.ArgumentParser(description=__doc__.partition(":")[0], allow_abbrev=False)
    networks = parser.add_subparsers(dest="network", required=True, metavar="NAME", help=", ".join(MINUTES))
    of = {name: networks.add_parser(name, allow_abbrev=False) for name in MINUTES}
    cores = os.cpu_count() or 1
    for name, one in of.items():
        one.add_argument("--data", type=Path, required=True, help="folder of pictures or samples; it may grow")
        one.add_argument("--out", type=Path, required=True, help="folder of the checkpoint, the log and the ONNX file")
        one.add_argument("--minutes", type=float, default=MINUTES[name], help="training time (default: %(default)s)")
        one.add_argument("--rate", type=float, help="peak learning rate (default: the recipe's)")
        one.add_argument("--threads", type=int, default=cores, help="of PyTorch (default: all cores, %(default)s)")
        one.add_argument("--resume", action="store_true", help="resume from the checkpoint in --out")
    for name in ("contours", "sparse-correction"):
        of[name].add_argument("--frames", type=Path, nargs="*", default=[], help="folders of real frames")
    for name in ("contours", "correction", "sparse-correction"):
        of[name].add_argument("--start", type=Path, help="network (ONNX) of an earlier training to start from")
    of["sparse-correction"].add_argument(
        "--jobs", type=int, default=cores, help="processes that make samples (default: all cores, %(default)s)"
    )
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Train, or resume training, export, and return the exit status."""
    given = parsed(arguments)
    try:
        import onnx  # noqa: F401
        import torch
    except ImportError:
        print("train: error: Training needs PyTorch and onnx: pip install torch onnx", file=sys.stderr)
        return 1
    from recipes.trainer import Trainer

    torch.set_num_threads(given.threads)
    # a single thread makes the samples
    cv2.setNumThreads(1)
    try:
        given.out.mkdir(parents=True, exist_ok=True)
        recipe = recipe_of(given)
        recipe.peak_rate = given.rate or recipe.peak_rate
        trainer = Trainer(recipe, given.out)
        if given.resume:
            trainer.resume()
        trainer.run(given.minutes, lambda line: print(line, flush=True))
    except IlfError as error:
        print(f"train: error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
