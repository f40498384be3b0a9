"""The training loop: resumable, with a schedule over training time, so that it suits a machine of any speed."""

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
# A longer step means that the process was suspended; the excess does not count as training time.
LONGEST_STEP_S = 10.0


class TrainingTask(ABC):
    """A training task: a model, samples, a loss, and measures on held-out samples."""

    seed: ClassVar[int]
    peak_rate: ClassVar[float]
    file_name: ClassVar[str]
    """File name of the exported ONNX network."""

    @abstractmethod
    def new_model(self) -> nn.Module:
        """Create a model with random weights."""

    @abstractmethod
    def batch(self, rng: np.random.Generator) -> Arrays:
        """Make a batch of training samples, arrays of shape (N, H, W, C)."""

    @abstractmethod
    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        """Compute the loss of a batch, given as tensors of shape (N, C, H, W)."""

    @abstractmethod
    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        """Compute measures on held-out samples, by name."""

    @abstractmethod
    def export(self, model: nn.Module, path: Path) -> None:
        """Write the model as ONNX."""


def learning_rate(peak: float, progress: float) -> float:
    """Linear warm-up, then cosine decay to zero, for a progress from 0 to 1."""
    return peak * min(progress / WARM_UP, 0.5 + 0.5 * math.cos(math.pi * progress))


class Trainer:
    """A model in training, the average of its weights, and the state for resuming.

    Parameters
    ----------
    task : TrainingTask
    out : Path
        Folder of `checkpoint.pt`, `log.csv` and the averaged model as ONNX, each updated at every report.
    """

    def __init__(self, task: TrainingTask, out: Path) -> None:
        torch.manual_seed(task.seed)
        self.task = task
        self.out = out
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        self.model = task.new_model().to(self.device, memory_format=torch.channels_last)
        self.average = deepcopy(self.model).eval().requires_grad_(False)
        self.optimiser = torch.optim.AdamW(self.model.parameters(), task.peak_rate, weight_decay=WEIGHT_DECAY)
        self.step = 0
        self.seconds = 0.0

    @property
    def checkpoint(self) -> Path:
        """Path of the stored state."""
        return self.out / "checkpoint.pt"

    def save(self) -> None:
        """Write the checkpoint; an interruption leaves the previous one."""
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
        """Restore the state of the checkpoint."""
        state: dict[str, Any] = torch.load(self.checkpoint, self.device, weights_only=True)
        self.model.load_state_dict(state["model"])
        self.average.load_state_dict(state["average"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step = state["step"]
        self.seconds = state["seconds"]

    def run(self, minutes: float, report: Callable[[str], None]) -> None:
        """Train until the total training time reaches `minutes`, without breaks and suspensions."""
        losses: list[float] = []
        batches = self._batches()
        began = time.monotonic()
        while self.seconds < 60 * minutes:
            batch = next(batches)
            rate = learning_rate(self.task.peak_rate, self.seconds / (60 * minutes))
            losses.append(self._train_step(batch, rate))
            self.step += 1
            now = time.monotonic()
            self.seconds += min(now - began, LONGEST_STEP_S)
            began = now
            if self.step % REPORT_EVERY == 0:
                report(self._record(rate, losses))
                losses.clear()
        if losses:
            report(self._record(0.0, losses))

    def _train_step(self, batch: tuple[Tensor, ...], rate: float) -> float:
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        with torch.autocast(self.device.type, torch.bfloat16):
            loss = self.task.loss(self.model, batch)
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()
        self._update_average()
        return float(loss.detach())

    def _update_average(self) -> None:
        # Averaging is short at first, so that the random start soon disappears from the average.
        keep = min(AVERAGING, (1 + self.step) / (10 + self.step))
        with torch.no_grad():
            for mine, theirs in zip(self.average.state_dict().values(), self.model.state_dict().values(), strict=True):
                if mine.is_floating_point():
                    mine.lerp_(theirs, 1 - keep)

    def _batches(self) -> Iterator[tuple[Tensor, ...]]:
        """Yield batches from the current step on; the next one is prepared during training."""
        with ThreadPoolExecutor(1) as maker:
            step = self.step
            pending = maker.submit(self._batch, step)
            while True:
                ready = pending.result()
                step += 1
                pending = maker.submit(self._batch, step)
                yield ready

    def _batch(self, step: int) -> tuple[Tensor, ...]:
        # Seeded by the step, so that a resumed training gets the same batches as an uninterrupted one.
        return self.tensors(self.task.batch(np.random.default_rng((self.task.seed, step))))

    def tensors(self, arrays: Arrays) -> tuple[Tensor, ...]:
        """Convert arrays (N, H, W, C) to tensors (N, C, H, W) on the model's device."""
        # The permuted view of (N, H, W, C) is channels-last already.
        return tuple(torch.from_numpy(one).to(self.device).permute(0, 3, 1, 2) for one in arrays)

    def _record(self, rate: float, losses: list[float]) -> str:
        with torch.no_grad():
            held_out = self.task.held_out(self.average, self.tensors)
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
        with replacing(self.out / self.task.file_name) as unfinished:
            self.task.export(self.average, unfinished)
        return ", ".join(f"{name} {value}" for name, value in values.items())


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path, which replaces `path` after writing."""
    unfinished = path.with_suffix(".new")
    yield unfinished
    unfinished.replace(path)


# Common part of the training commands.


def train(parser: argparse.ArgumentParser, minutes: float, task: Callable[[argparse.Namespace], TrainingTask]) -> None:
    """Train, or resume training, and export.

    Parameters
    ----------
    parser : ArgumentParser
        With the arguments of the task; the common arguments are added.
    minutes : float
        Default of the total training time.
    task : callable
        Returns the training task for the parsed arguments; called only if PyTorch is installed.
    """
    parser.add_argument("--out", type=Path, required=True, help="folder of the checkpoint, the log and the ONNX file")
    parser.add_argument("--minutes", type=float, default=minutes, help="total training time (default: %(default)s)")
    parser.add_argument(
        "--threads", type=int, default=os.cpu_count() or 1, help="threads of PyTorch (default: all, %(default)s)"
    )
    parser.add_argument("--resume", action="store_true", help="resume from the checkpoint in --out")
    arguments = parser.parse_args()

    try:
        torch = optional("torch", "ilf-studio[torch]", "Training")

        torch.set_num_threads(arguments.threads)
        # a single thread makes the samples
        cv2.setNumThreads(1)
        arguments.out.mkdir(parents=True, exist_ok=True)
        trainer = Trainer(task(arguments), arguments.out)
        if arguments.resume:
            trainer.resume()
        trainer.run(arguments.minutes, lambda line: print(line, flush=True))
    except InputError as error:
        parser.exit(1, f"{error}\n")


# Trained models as ONNX files with free height and width.


def write_onnx(model: nn.Module, path: Path, inputs: Mapping[str, int], outputs: tuple[str, ...]) -> None:
    """Write a model for inference; normalisation is folded into the weights.

    Parameters
    ----------
    model : nn.Module
        In evaluation mode.
    path : Path
    inputs : mapping of str to int
        Name -> channels, in the order of the model's arguments.
    outputs : tuple of str
        Names of the outputs.
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
