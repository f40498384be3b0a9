"""`python -m ilf.lab.training.depth_edges --data PICTURES --out FOLDER`: train the depth-edge network."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..trainer import train
from .pictures import PictureFolder

if TYPE_CHECKING:
    from .task import DepthEdgeTraining


def _training(arguments: argparse.Namespace) -> DepthEdgeTraining:
    from .task import DepthEdgeTraining

    return DepthEdgeTraining(PictureFolder(arguments.data))


def main() -> None:
    """Train, or resume training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.lab.training.depth_edges", description=__doc__)
    parser.add_argument(
        "--data", type=Path, required=True, help="folder of generated pictures, <number>.npz; it may grow"
    )
    train(parser, 480, _training)


if __name__ == "__main__":
    main()
