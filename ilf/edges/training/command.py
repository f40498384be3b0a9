"""What the training commands have in common."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from ...errors import InputError
from ...extras import optional

if TYPE_CHECKING:
    from .trainer import Lesson


def train(parser: argparse.ArgumentParser, minutes: float, lesson: Callable[[argparse.Namespace], Lesson]) -> None:
    """Train, or go on training, and export.

    Parameters
    ----------
    parser : ArgumentParser
        With what the lesson needs; what every training needs is added.
    minutes : float
        Training time in all, where nothing else is said.
    lesson : callable
        What is to be learnt, from the parsed arguments; called only where there is PyTorch.
    """
    parser.add_argument("--out", type=Path, required=True, help="folder of the checkpoint, the log and the ONNX file")
    parser.add_argument("--minutes", type=float, default=minutes, help="training time in all (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="default: all (%(default)s)")
    parser.add_argument("--resume", action="store_true", help="go on from the checkpoint in --out")
    arguments = parser.parse_args()

    try:
        torch = optional("torch", "train", "Training")
        from .trainer import Trainer

        torch.set_num_threads(arguments.threads)
        # samples are made on the one thread that makes them
        cv2.setNumThreads(1)
        arguments.out.mkdir(parents=True, exist_ok=True)
        trainer = Trainer(lesson(arguments), arguments.out)
        if arguments.resume:
            trainer.resume()
        trainer.run(arguments.minutes, lambda line: print(line, flush=True))
    except InputError as error:
        parser.exit(1, f"{error}\n")
