"""`python -m ilf.lab.training.surfaces --data PICTURES --completed SAMPLES --out FOLDER`: train the surface network and
the correction."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..trainer import train
from .pictures import PictureFolder

if TYPE_CHECKING:
    from .task import SurfaceTraining


def _training(arguments: argparse.Namespace) -> SurfaceTraining:
    from .task import SurfaceTraining

    return SurfaceTraining(PictureFolder(arguments.data), PictureFolder(arguments.completed), arguments.start)


def main() -> None:
    """Train, or resume training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.lab.training.surfaces", description=__doc__)
    parser.add_argument(
        "--data", type=Path, required=True, help="folder of generated pictures, <number>.npz; it may grow"
    )
    parser.add_argument(
        "--completed", type=Path, required=True, help="folder of pictures completed by the filter; it may grow"
    )
    parser.add_argument("--start", type=Path, help="network (ONNX) of an earlier training whose weights to start from")
    train(parser, 480, _training)


if __name__ == "__main__":
    main()
