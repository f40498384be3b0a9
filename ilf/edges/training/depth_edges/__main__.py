"""`python -m ilf.edges.training.depth_edges --data PICTURES --out FOLDER`: train the depth-edge network."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..command import train
from .pictures import PictureFolder

if TYPE_CHECKING:
    from .lesson import DepthEdgeLesson


def _lesson(arguments: argparse.Namespace) -> DepthEdgeLesson:
    folder = PictureFolder(arguments.data)
    if arguments.conducting_from is not None:
        from .conducting_lesson import ConductingLesson

        return ConductingLesson(folder, arguments.conducting_from)
    from .lesson import DepthEdgeLesson

    return DepthEdgeLesson(folder)


def main() -> None:
    """Train, or go on training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.edges.training.depth_edges", description=__doc__)
    parser.add_argument(
        "--data", type=Path, required=True, help="folder of generated pictures, <number>.npz; it may be growing"
    )
    parser.add_argument(
        "--conducting-from",
        type=Path,
        help="checkpoint to go on from with conductances and rises, by what depth does that spreads through them",
    )
    train(parser, 480, _lesson)


if __name__ == "__main__":
    main()
