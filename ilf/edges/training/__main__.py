"""`python -m ilf.edges.training --data BSDS500 --out FOLDER`: train the edge network and write it as ONNX."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ...errors import InputError
from ...extras import optional
from .data import load_examples


def main() -> None:
    """Train, or go on training, and export."""
    parser = argparse.ArgumentParser(prog="python -m ilf.edges.training", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of BSDS500, with images and groundTruth")
    parser.add_argument("--out", type=Path, required=True, help="folder of the checkpoint, the log and edges.onnx")
    parser.add_argument("--minutes", type=float, default=70, help="training time in all (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="default: all (%(default)s)")
    parser.add_argument("--resume", action="store_true", help="go on from the checkpoint in --out")
    arguments = parser.parse_args()

    try:
        optional("torch", "train", "Training")
    except InputError as error:
        parser.exit(1, f"{error}\n")
    from .export import export_onnx
    from .train import Trainer, limit_threads

    limit_threads(arguments.threads)
    arguments.out.mkdir(parents=True, exist_ok=True)
    trainer = Trainer(*load_examples(arguments.data), arguments.out)
    if arguments.resume:
        trainer.resume()
    trainer.run(arguments.minutes, lambda line: print(line, flush=True))
    export_onnx(trainer.average, arguments.out / "edges.onnx")


if __name__ == "__main__":
    main()
