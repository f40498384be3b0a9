"""The training loop: resumable, with a schedule over training time, so that it ends well on a machine of any speed."""

from __future__ import annotations

import argparse
import math
import os
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from copy import deepcopy
from pathlib import Path
from typing import Any, ClassVar

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ..._runtime.installation import optional
from ...errors import InputError
from ...io.tables import csv_text

Arrays = tuple[NDArray[np.float32], ...]

WARM_UP = 0.01
WEIGHT_DECAY = 1e-2
AVERAGING = 0.999
REPORT_EVERY = 500
# A step that takes longer was suspended, and such time does not count as training.
LONGEST_STEP_S = 10.0


class Lesson(ABC):
    """What is to be learnt: a model, samples, a loss, and figures of how well it goes."""

    seed: ClassVar[int]
    peak_rate: ClassVar[float]
    file_name: ClassVar[str]
    """Of the network as ONNX."""

    @abstractmethod
    def new_model(self) -> nn.Module:
        """A model with random weights."""

    @abstractmethod
    def batch(self, rng: np.random.Generator) -> Arrays:
        """Samples to learn from, each array of shape (N, H, W, C)."""

    @abstractmethod
    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        """Loss of a batch, its arrays having become tensors of shape (N, C, H, W)."""

    @abstractmethod
    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        """Figures on what is held out, by name."""

    @abstractmethod
    def export(self, model: nn.Module, path: Path) -> None:
        """Write the model as ONNX."""


def learning_rate(peak: float, progress: float) -> float:
    """Linear warm-up, then a cosine to zero, for a progress from 0 to 1."""
    return peak * min(progress / WARM_UP, 0.5 + 0.5 * math.cos(math.pi * progress))


class Trainer:
    """A model in training, the average of its weights, and everything needed to go on after a break.

    Parameters
    ----------
    lesson : Lesson
    out : Path
        Folder of `checkpoint.pt`, `log.csv` and the averaged model as ONNX, each renewed whenever there is a report.
    """

    def __init__(self, lesson: Lesson, out: Path) -> None:
        torch.manual_seed(lesson.seed)
        self.lesson = lesson
        self.out = out
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        self.model = lesson.new_model().to(self.device, memory_format=torch.channels_last)
        self.average = deepcopy(self.model).eval().requires_grad_(False)
        self.optimiser = torch.optim.AdamW(self.model.parameters(), lesson.peak_rate, weight_decay=WEIGHT_DECAY)
        self.step = 0
        self.seconds = 0.0

    @property
    def checkpoint(self) -> Path:
        """Where the state is kept."""
        return self.out / "checkpoint.pt"

    def save(self) -> None:
        """Write the checkpoint; a break while writing leaves the one before."""
        state = {
            "model": self.model.state_dict(),
            "average": self.average.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "step": self.step,
            "seconds": self.seconds,
        }
        with replacing(self.checkpoint) as unfinished:
            torch.save(state, unfinished)

    def resume(self) -> None:
        """Go on where the checkpoint was written."""
        state: dict[str, Any] = torch.load(self.checkpoint, self.device, weights_only=True)
        self.model.load_state_dict(state["model"])
        self.average.load_state_dict(state["average"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step = state["step"]
        self.seconds = state["seconds"]

    def run(self, minutes: float, report: Callable[[str], None]) -> None:
        """Train until `minutes` of training time have passed in all, breaks and suspensions not counted."""
        losses: list[float] = []
        batches = self._batches()
        began = time.monotonic()
        while self.seconds < 60 * minutes:
            batch = next(batches)
            rate = learning_rate(self.lesson.peak_rate, self.seconds / (60 * minutes))
            losses.append(self._learn(batch, rate))
            self.step += 1
            now = time.monotonic()
            self.seconds += min(now - began, LONGEST_STEP_S)
            began = now
            if self.step % REPORT_EVERY == 0:
                report(self._record(rate, losses))
                losses.clear()
        if losses:
            report(self._record(0.0, losses))

    def _learn(self, batch: tuple[Tensor, ...], rate: float) -> float:
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        with torch.autocast(self.device.type, torch.bfloat16):
            loss = self.lesson.loss(self.model, batch)
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()
        self._update_average()
        return float(loss.detach())

    def _update_average(self) -> None:
        # The average of the first steps is short, or the random start would stay in it for long.
        keep = min(AVERAGING, (1 + self.step) / (10 + self.step))
        with torch.no_grad():
            for mine, theirs in zip(self.average.state_dict().values(), self.model.state_dict().values(), strict=True):
                if mine.is_floating_point():
                    mine.lerp_(theirs, 1 - keep)

    def _batches(self) -> Iterator[tuple[Tensor, ...]]:
        """Batches from the present step on, the next one made while one is learnt."""
        with ThreadPoolExecutor(1) as maker:
            step = self.step
            coming = maker.submit(self._batch, step)
            while True:
                ready = coming.result()
                step += 1
                coming = maker.submit(self._batch, step)
                yield ready

    def _batch(self, step: int) -> tuple[Tensor, ...]:
        # Seeded by the step, so that a resumed training sees the batches that an unbroken one would.
        return self.tensors(self.lesson.batch(np.random.default_rng((self.lesson.seed, step))))

    def tensors(self, arrays: Arrays) -> tuple[Tensor, ...]:
        """Arrays (N, H, W, C) as tensors (N, C, H, W) where the model is."""
        # The permuted view of (N, H, W, C) is channels-last already.
        return tuple(torch.from_numpy(one).to(self.device).permute(0, 3, 1, 2) for one in arrays)

    def _record(self, rate: float, losses: list[float]) -> str:
        with torch.no_grad():
            held_out = self.lesson.held_out(self.average, self.tensors)
        values = {
            "step": str(self.step),
            "minutes": f"{self.seconds / 60:.1f}",
            "rate": f"{rate:.2e}",
            "loss": f"{np.mean(losses):.4f}",
            **{name: f"{value:.4f}" for name, value in held_out.items()},
        }
        path = self.out / "log.csv"
        head = [] if path.exists() else [values.keys()]
        with path.open("a", newline="") as file:
            file.write(csv_text([*head, values.values()]))
        self.save()
        with replacing(self.out / self.lesson.file_name) as unfinished:
            self.lesson.export(self.average, unfinished)
        return ", ".join(f"{name} {value}" for name, value in values.items())


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to, which takes the place of another when that has been done."""
    unfinished = path.with_suffix(".new")
    yield unfinished
    unfinished.replace(path)


# What the training commands have in common.


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


# Trained models as ONNX files whose height and width are free.


def write_onnx(model: nn.Module, path: Path, inputs: Mapping[str, int], outputs: tuple[str, ...]) -> None:
    """Write a model for inference; normalisation is folded into the weights.

    Parameters
    ----------
    model : nn.Module
        In the mode of evaluation.
    path : Path
    inputs : mapping of str to int
        Name -> channels, in the order in which the model takes them.
    outputs : tuple of str
        Names of what it gives.
    """
    names = (*inputs, *outputs)
    torch.onnx.export(
        model,
        tuple(torch.zeros(1, channels, 64, 64) for channels in inputs.values()),
        str(path),
        input_names=list(inputs),
        output_names=list(outputs),
        dynamic_axes={name: {2: f"{name} height", 3: f"{name} width"} for name in names},
        opset_version=17,
        dynamo=False,
    )
