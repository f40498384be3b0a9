"""The training loop: resumable, with a schedule over training time, so that it suits a machine of any speed."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from copy import deepcopy
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ilf.io.tables import csv_text

Arrays = tuple[NDArray[np.float32], ...]

WARM_UP = 0.01
WEIGHT_DECAY = 1e-2
AVERAGING = 0.999
REPORT_EVERY = 500
# A longer step means that the process was suspended; the excess does not count as training time.
LONGEST_STEP_S = 10.0


class Recipe(ABC):
    """What a network is made of: a model, samples, a loss, and measures on held-out samples."""

    seed: ClassVar[int]
    peak_rate: float
    file_name: ClassVar[str]
    """File name of the exported ONNX network."""
    inputs: ClassVar[Mapping[str, int]]
    """Inputs of the exported network: name -> channels, in the order of the model's arguments."""
    outputs: ClassVar[tuple[str, ...]]
    """Names of its outputs."""

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

    def deployed(self, model: nn.Module) -> nn.Module:
        """Convert a trained model to the network that is exported."""
        return model

    def finish(self, path: Path) -> None:  # noqa: B027 (not every recipe does)
        """Change the weights of the exported file; by default, they stay."""


def learning_rate(peak: float, progress: float) -> float:
    """Linear warm-up, then cosine decay to zero, for a progress from 0 to 1."""
    return peak * min(progress / WARM_UP, 0.5 + 0.5 * math.cos(math.pi * progress))


class Trainer:
    """A model in training, the average of its weights, and the state for resuming.

    Parameters
    ----------
    recipe : Recipe
    out : Path
        Folder of `checkpoint.pt`, `log.csv` and the averaged model as ONNX, each updated at every report.
    """

    def __init__(self, recipe: Recipe, out: Path) -> None:
        torch.manual_seed(recipe.seed)
        self.recipe = recipe
        self.out = out
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        self.model = recipe.new_model().to(self.device, memory_format=torch.channels_last)
        self.average = deepcopy(self.model).eval().requires_grad_(False)
        self.optimiser = torch.optim.AdamW(self.model.parameters(), recipe.peak_rate, weight_decay=WEIGHT_DECAY)
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
            rate = learning_rate(self.recipe.peak_rate, self.seconds / (60 * minutes))
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
        # without AVX-512 or AMX, a processor takes ten times as long with bfloat16
        quick = self.device.type != "cpu" or torch.backends.cpu.get_cpu_capability().startswith("AVX512")
        with torch.autocast(self.device.type, torch.bfloat16, enabled=quick):
            loss = self.recipe.loss(self.model, batch)
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
        return self.tensors(self.recipe.batch(np.random.default_rng((self.recipe.seed, step))))

    def tensors(self, arrays: Arrays) -> tuple[Tensor, ...]:
        """Convert arrays (N, H, W, C) to tensors (N, C, H, W) on the model's device."""
        # The permuted view of (N, H, W, C) is channels-last already.
        return tuple(torch.from_numpy(one).to(self.device).permute(0, 3, 1, 2) for one in arrays)

    def _record(self, rate: float, losses: list[float]) -> str:
        with torch.no_grad():
            held_out = self.recipe.held_out(self.average, self.tensors)
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
        with replacing(self.out / self.recipe.file_name) as unfinished:
            write_onnx(self.recipe, deepcopy(self.average).cpu(), unfinished)
        return ", ".join(f"{name} {value}" for name, value in values.items())


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path, which replaces `path` after writing."""
    unfinished = path.with_suffix(".new")
    yield unfinished
    unfinished.replace(path)


def write_onnx(recipe: Recipe, model: nn.Module, path: Path) -> None:
    """Write a trained model as an ONNX file with free height and width; normalisation is folded into the weights."""
    torch.onnx.export(
        recipe.deployed(model).eval(),
        tuple(torch.zeros(1, channels, 64, 64) for channels in recipe.inputs.values()),
        str(path),
        input_names=list(recipe.inputs),
        output_names=list(recipe.outputs),
        dynamic_axes={name: {2: f"{name} height", 3: f"{name} width"} for name in (*recipe.inputs, *recipe.outputs)},
        opset_version=17,
        dynamo=False,
    )
    recipe.finish(path)
