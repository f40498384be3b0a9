"""The training loop: resumable, with a schedule over training time, so that it ends well on a machine of any speed."""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from torch import Tensor

from ..network import pad_image
from .data import Example, consensus, random_sample
from .model import EdgeModel, edge_loss

SEED = 20
BATCH = 4
CROP = 320
PEAK_RATE = 2e-3
WARM_UP = 0.01
WEIGHT_DECAY = 1e-2
AVERAGING = 0.999
REPORT_EVERY = 500
# A step that takes longer was suspended, and such time does not count as training.
LONGEST_STEP_S = 10.0
LOG_COLUMNS = ("step", "minutes", "rate", "loss", "held-out loss")


def learning_rate(progress: float) -> float:
    """Linear warm-up, then a cosine to zero, for a progress from 0 to 1."""
    return PEAK_RATE * min(progress / WARM_UP, 0.5 + 0.5 * math.cos(math.pi * progress))


class Trainer:
    """A model in training, the average of its weights, and everything needed to go on after a break.

    Parameters
    ----------
    learnt, held_out : list of Example
    out : Path
        Folder of `checkpoint.pt` and `log.csv`.
    """

    def __init__(self, learnt: list[Example], held_out: list[Example], out: Path) -> None:
        torch.manual_seed(SEED)
        self.learnt = learnt
        self.held_out = held_out
        self.out = out
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        self.model = EdgeModel().to(self.device, memory_format=torch.channels_last)
        self.average = deepcopy(self.model).eval().requires_grad_(False)
        self.optimiser = torch.optim.AdamW(self.model.parameters(), PEAK_RATE, weight_decay=WEIGHT_DECAY)
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
        unfinished = self.checkpoint.with_suffix(".new")
        torch.save(state, unfinished)
        unfinished.replace(self.checkpoint)

    def resume(self) -> None:
        """Go on where the checkpoint was written."""
        state: dict[str, Any] = torch.load(self.checkpoint, map_location=self.device)
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
            images, shares = next(batches)
            rate = learning_rate(self.seconds / (60 * minutes))
            losses.append(self._learn(images, shares, rate))
            self.step += 1
            now = time.monotonic()
            self.seconds += min(now - began, LONGEST_STEP_S)
            began = now
            if self.step % REPORT_EVERY == 0:
                report(self._record(rate, losses))
                losses.clear()
        if losses:
            report(self._record(0.0, losses))

    def _learn(self, images: Tensor, shares: Tensor, rate: float) -> float:
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        with torch.autocast(self.device.type, torch.bfloat16):
            outputs = self.model(images)
        loss = edge_loss(outputs, shares)
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

    def _batches(self) -> Iterator[tuple[Tensor, Tensor]]:
        """Batches from the present step on, the next one made while one is learnt."""
        with ThreadPoolExecutor(1) as maker:
            step = self.step
            coming = maker.submit(self._batch, step)
            while True:
                ready = coming.result()
                step += 1
                coming = maker.submit(self._batch, step)
                yield ready

    def _batch(self, step: int) -> tuple[Tensor, Tensor]:
        # Seeded by the step, so that a resumed training sees the batches that an unbroken one would.
        rng = np.random.default_rng((SEED, step))
        chosen = rng.integers(len(self.learnt), size=BATCH)
        images, shares = zip(*(random_sample(self.learnt[k], CROP, rng) for k in chosen), strict=True)
        return self._tensor(np.stack(images)), self._tensor(np.stack(shares)[..., None])

    def _tensor(self, array: np.ndarray) -> Tensor:
        # The permuted view of (N, H, W, C) is channels-last already.
        return torch.from_numpy(array).to(self.device).permute(0, 3, 1, 2)

    def _record(self, rate: float, losses: list[float]) -> str:
        mean, held_out = float(np.mean(losses)), self.held_out_loss()
        values = (self.step, f"{self.seconds / 60:.1f}", f"{rate:.2e}", f"{mean:.4f}", f"{held_out:.4f}")
        path = self.out / "log.csv"
        new = not path.exists()
        with path.open("a", newline="") as file:
            writer = csv.writer(file)
            if new:
                writer.writerow(LOG_COLUMNS)
            writer.writerow(values)
        self.save()
        return ", ".join(f"{name} {value}" for name, value in zip(LOG_COLUMNS, values, strict=True))

    @torch.no_grad()
    def held_out_loss(self) -> float:
        """Mean loss of the averaged model over the whole held-out images."""
        losses = []
        for example in self.held_out:
            padded, window = pad_image(example.rgb)
            image = self._tensor(padded[None].astype(np.float32) / 255)
            outputs = [one[:, :, window[0], window[1]] for one in self.average(image)]
            share = self._tensor(consensus(example.segmentations)[None, ..., None])
            losses.append(float(edge_loss(outputs, share)))
        return float(np.mean(losses))


def limit_threads(threads: int) -> None:
    """Let PyTorch compute on so many threads, and the making of samples on the one that makes them."""
    torch.set_num_threads(threads)
    cv2.setNumThreads(1)
