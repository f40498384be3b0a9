"""`python -m ilf.lab.training.correction --data SAMPLES --out FOLDER`: train the correction network."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..trainer import train
from .task import SampleFolder

if TYPE_CHECKING:
    from .task import CorrectionTraining


def _training(arguments: argparse.Namespace) -> CorrectionTraining:
    from .task import CorrectionTraining

    return CorrectionTraining(SampleFolder(arguments.data), arguments.start)


def main() -> None:
    """Train, or resume training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.lab.training.correction", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of samples; it may grow during training")
    parser.add_argument("--start", type=Path, help="depth-edge network (ONNX) that initialises the trunk")
    train(parser, 90, _training)


if __name__ == "__main__":
    main()
