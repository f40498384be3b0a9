"""`python -m ilf.lab.training.sparse_correction --frames FRAME... --data SAMPLES --out FOLDER`: train the correction
network for sparse depth."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..trainer import train
from .samples import make_samples

if TYPE_CHECKING:
    from .task import SparseCorrectionTraining


def _training(arguments: argparse.Namespace) -> SparseCorrectionTraining:
    from .task import SparseCorrectionTraining

    make_samples(arguments.frames, arguments.data, arguments.jobs)
    return SparseCorrectionTraining(arguments.data)


def main() -> None:
    """Make the samples that are missing, train, or resume training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.lab.training.sparse_correction", description=__doc__)
    parser.add_argument("--frames", type=Path, nargs="*", default=[], help="folders of real frames")
    parser.add_argument("--data", type=Path, required=True, help="folder of the samples")
    parser.add_argument(
        "--jobs", type=int, default=os.cpu_count() or 1, help="processes for samples (default: all cores, %(default)s)"
    )
    train(parser, 24, _training)


if __name__ == "__main__":
    main()
