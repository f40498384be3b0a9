"""`python -m ilf_bsds500 --data BSDS500 --out FOLDER`: train the edge network, write it as ONNX."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ilf.lab.training.trainer import train

from .data import load_examples

if TYPE_CHECKING:
    from .task import ContourTraining


def _training(arguments: argparse.Namespace) -> ContourTraining:
    from .task import ContourTraining

    return ContourTraining(*load_examples(arguments.data))


def main() -> None:
    """Train, or resume training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf_bsds500", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of BSDS500, with images and groundTruth")
    train(parser, 70, _training)


if __name__ == "__main__":
    main()
