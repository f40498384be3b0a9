"""The correction network for sparse depth: it learns to minimise the error of the cells."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor, nn

from ilf.completion.sparse_correction import CHANNELS, mirrored
from ilf.errors import InputError

from .initialisation import initialise_from
from .sparse_samples import MEASURED, Sample, is_held_out
from .stored_weights import mix_weights
from .trainer import Arrays, Recipe
from .unet import ResidualBlock

WIDTH, DILATIONS = 48, (1, 2, 4)
BATCH, _MEASURING_BATCH = 4, 16
"""Samples of a batch, and of the one by which the normalisation of a given network is measured."""

CROP = (64, 80)
"""Rows and columns of the cells that a sample of a batch shows."""

NOISE = 0.02
"""Standard deviation of the noise that is added to features."""

_SCALE = 0.25
"""Factor on the network's last layer, to the change of log depth."""

_LARGEST = 1.5
_LEAST_CELLS = 20
_MIN_MEAN, _MIN_RMS = 0.01, 0.02
"""Minimum errors, as shares of the median depth; smaller ones count as these."""

_RMS_SHARE = 1.0
"""Weight in the loss of the ratio of RMS errors; that of mean errors has 1."""


_START_SHARE = 0.6
"""Share of the network that a training starts from in the exported weights: such a mean is better than either."""


class SparseCorrectionModel(nn.Module):
    """Network from `sparse_features`, (N, 24, h, w), to the change of log depth of each cell, (N, 1, h, w)."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(len(CHANNELS), WIDTH, 3, padding=1, bias=False),
            nn.BatchNorm2d(WIDTH),
            nn.ReLU(),
            *(ResidualBlock(WIDTH, dilation) for dilation in DILATIONS),
        )
        self.last = nn.Conv2d(WIDTH, 1, 1)
        nn.init.zeros_(self.last.weight)
        assert self.last.bias is not None
        nn.init.zeros_(self.last.bias)

    def forward(self, features: Tensor) -> Tensor:
        changed: Tensor = self.last(self.layers(features)) * _SCALE
        return changed


class SparseCorrectionRecipe(Recipe):
    """Recipe of the correction network for sparse depth.

    Parameters
    ----------
    folder : Path
        Folder of samples.
    start : Path, optional
        Network (ONNX) of an earlier training to start from.
    """

    seed = 67
    peak_rate = 2e-3
    file_name = "sparse-correction.onnx"
    inputs: ClassVar = {"features": len(CHANNELS)}
    outputs = ("change",)

    def __init__(self, folder: Path, start: Path | None = None) -> None:
        paths = sorted(folder.glob("*.npz"))
        learnt = {path: Sample.load(path) for path in paths if not is_held_out(path)}
        # measured frames count twice: of the others there are more, and simulated sensors are not quite like real ones
        self.learnt = [*learnt.values(), *(one for path, one in learnt.items() if path.name.startswith(MEASURED))]
        self.kept_back = [Sample.load(path) for path in paths if is_held_out(path)]
        self.start = start
        if not self.learnt or not self.kept_back:
            raise InputError(f"{folder} has too few samples. Name more frames.")

    def new_model(self) -> nn.Module:
        model = SparseCorrectionModel()
        if self.start is not None:
            features, _ = self.batch(np.random.default_rng(self.seed), _MEASURING_BATCH)
            initialise_from(model, self.start, features)
        return model

    def finish(self, path: Path) -> None:
        if self.start is not None:
            mix_weights(path, self.start, _START_SHARE)

    def batch(self, rng: np.random.Generator, size: int = BATCH) -> Arrays:
        chosen = [self._cropped(self.learnt[k], rng) for k in rng.integers(len(self.learnt), size=size)]
        return tuple(np.stack(arrays) for arrays in zip(*chosen, strict=True))

    def _cropped(self, sample: Sample, rng: np.random.Generator) -> Arrays:
        depths, features = np.stack([sample.true, sample.corrected, sample.fading], axis=-1), sample.features
        if rng.random() < 0.5:
            depths, features = depths[:, ::-1], mirrored(features)
        features = np.moveaxis(features, 0, 2)
        rows, columns = (
            np.arange(side) + int(rng.integers(max(size - side, 0) + 1))
            for side, size in zip(CROP, sample.true.shape, strict=True)
        )
        # beyond the end of a small frame its last cells are repeated
        there = np.ix_(*(np.minimum(at, size - 1) for at, size in zip((rows, columns), sample.true.shape, strict=True)))
        noise = NOISE * rng.standard_normal((*CROP, features.shape[2]), np.float32)
        return np.asarray(features[there] + noise, np.float32), np.ascontiguousarray(depths[there], np.float32)

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        features, depths = batch
        mean, rms = errors(model(features).float(), depths)
        with torch.no_grad():
            mean_before, rms_before = errors(torch.zeros_like(depths[:, :1]), depths)
            median = depths[:, 1].flatten(1).median(1).values
            counts = torch.isfinite(depths[:, 0]).flatten(1).sum(1) > _LEAST_CELLS
        ratio = mean / (mean_before + _MIN_MEAN * median) + _RMS_SHARE * rms / (rms_before + _MIN_RMS * median)
        return (ratio * counts).mean()

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        """Geometric means of the ratios of errors to those before, and the largest ratio."""
        ratios = []
        for sample in self.kept_back:
            depths = np.stack([sample.true, sample.corrected, sample.fading], axis=-1)
            features, known = tensors((np.moveaxis(sample.features, 0, 2)[None].astype(np.float32), depths[None]))
            now, before = (torch.cat(errors(one, known)) for one in (model(features), torch.zeros_like(known[:, :1])))
            ratios.append(torch.log(now / before).cpu().numpy())
        mean, rms = np.exp(np.mean(ratios, axis=0))
        return {"MAE ratio": float(mean), "RMS ratio": float(rms), "worst": float(np.exp(np.max(ratios)))}


def errors(change: Tensor, depths: Tensor) -> tuple[Tensor, Tensor]:
    """Mean and root mean square error of each sample [m], (N,), for changes (N, 1, h, w) of the log of corrected depth;
    `depths` are true and corrected depth, and the factor on changes, (N, 3, h, w)."""
    true, corrected, fading = depths.unbind(1)
    there = torch.isfinite(true)
    changed = corrected * torch.exp((change[:, 0] * fading).clamp(-_LARGEST, _LARGEST))
    off = torch.where(there, changed - torch.nan_to_num(true), torch.zeros_like(true))
    count = there.flatten(1).sum(1).clamp(min=1)
    return off.abs().sum((1, 2)) / count, (off.square().sum((1, 2)) / count + 1e-8).sqrt()
