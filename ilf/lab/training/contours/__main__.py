"""`python -m ilf.lab.training.contours --data PICTURES --frames FRAME... --out FOLDER`: train the contour network."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..depth_edges.pictures import PictureFolder
from ..trainer import train

if TYPE_CHECKING:
    from .task import ContourTraining


def _training(arguments: argparse.Namespace) -> ContourTraining:
    from ..real_frames import read_real_frame
    from .task import ContourTraining

    frames = [read_real_frame(folder) for folder in arguments.frames]
    return ContourTraining(PictureFolder(arguments.data), frames, arguments.start)


def main() -> None:
    """Train, or resume training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.lab.training.contours", description=__doc__)
    parser.add_argument(
        "--data", type=Path, required=True, help="folder of generated pictures, <number>.npz; it may grow"
    )
    parser.add_argument(
        "--frames", type=Path, nargs="*", default=[], help="folders of real frames: rgb.jpg, depth.png, meta.json"
    )
    parser.add_argument("--start", type=Path, help="network (ONNX) of an earlier training to start from")
    train(parser, 480, _training)


if __name__ == "__main__":
    main()
