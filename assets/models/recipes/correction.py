"""The correction network: it learns to minimise the error of the corrected depth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from ilf.completion.correction import CHANNELS

from .correction_model import CorrectionModel, change
from .correction_samples import SampleFolder, augmented, read_sample
from .depth_edges import COARSE_SHARE, coarse_loss, line_loss
from .initialisation import initialise_from
from .trainer import Arrays, Recipe

BATCH = 4

LINES_SHARE = 0.1
"""Weight in the loss of the lines and the coarse depth, which the depth-edge network has learnt; the error has 1."""

_MIN_MEAN, _MIN_RMS = 0.01, 0.02
"""Minimum errors of the completed depth, in units of the frame's median depth; smaller ones count as these."""

_NEAREST, _FARTHEST = -4.0, 2.0
"""Range of log depth minus its median in which errors count in full."""


class _Deployed(nn.Module):
    """The model with links of cells and logits of the pixels' weights as outputs."""

    def __init__(self, model: nn.Module) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        _, _, (right, below, rise_right, rise_below, held, pull), logits = self.model(image, features)
        beyond, beneath = (0, 1), (0, 0, 0, 1)
        links = [
            functional.pad(one[:, None], side)
            for one, side in ((right, beyond), (below, beneath), (rise_right, beyond), (rise_below, beneath))
        ]
        return torch.cat([*links, held[:, None], pull[:, None]], 1), logits


class CorrectionRecipe(Recipe):
    """Recipe of the correction network.

    Parameters
    ----------
    folder : SampleFolder
    start : Path or None
        Depth-edge network (ONNX) that initialises the trunk; random weights if None.
    """

    seed = 51
    peak_rate = 1.5e-3
    file_name = "correction.onnx"
    inputs: ClassVar = {"image": 3, "features": len(CHANNELS)}
    outputs = ("links", "logits")

    def __init__(self, folder: SampleFolder, start: Path | None) -> None:
        self.folder = folder
        self.start = start

    def new_model(self) -> nn.Module:
        model = CorrectionModel()
        if self.start is not None:
            image, features, *_ = self.batch(np.random.default_rng(self.seed))
            initialise_from(model, self.start, image, features)
        return model

    def batch(self, rng: np.random.Generator) -> Arrays:
        self.folder.refresh()
        chosen = rng.integers(len(self.folder.learnt), size=BATCH)
        samples = [augmented(read_sample(self.folder.learnt[k]), rng) for k in chosen]
        return tuple(np.stack(arrays) for arrays in zip(*samples, strict=True))

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, features, lines, log_depth, completed = batch
        of_lines, coarse, links, of_weights = model(image, features)
        loss = error_ratio(completed[:, 0] + change(links, of_weights), batch).mean()
        drawn = torch.isfinite(lines).flatten(1).all(1)
        if not drawn.any():
            return loss
        of_lines, coarse, lines, log_depth, features = (
            one[drawn] for one in (of_lines, coarse, lines, log_depth, features)
        )
        before = line_loss(of_lines, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features)
        return loss + LINES_SHARE * before

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        """Geometric means of the ratios of errors to those of the completed depth, and the largest ratio."""
        ratios = []
        for path in self.folder.held_out:
            batch = tensors(tuple(one[None] for one in read_sample(path)))
            links, of_weights = model(*batch[:2])[2:]
            if counted(batch).any():
                completed = batch[4][:, 0]
                now, before = torch.cat(errors(completed + change(links, of_weights), batch)), errors(completed, batch)
                ratios.append(torch.log(now / torch.cat(before)).cpu().numpy())
        mean, rms = np.exp(np.mean(ratios, axis=0))
        return {"MAE ratio": float(mean), "RMS ratio": float(rms), "worst": float(np.exp(np.max(ratios)))}

    def deployed(self, model: nn.Module) -> nn.Module:
        return _Deployed(model)


def counted(batch: tuple[Tensor, ...]) -> Tensor:
    """Pixels with a true depth, but without a known one; (N, H, W)."""
    features, log_depth = batch[1], batch[3]
    return torch.isfinite(log_depth[:, 0]) & (features[:, 0] == 0)


def errors(log_depth: Tensor, batch: tuple[Tensor, ...]) -> tuple[Tensor, Tensor]:
    """Mean and root mean square error of each picture over its counted pixels, in units of its median depth; (N,)."""
    there = counted(batch)
    true = torch.exp(torch.nan_to_num(batch[3][:, 0]).clamp(max=_FARTHEST))
    off = (torch.exp(log_depth.clamp(_NEAREST, _FARTHEST)) - true) * there
    count = there.sum((1, 2)).clamp(min=1)
    return off.abs().sum((1, 2)) / count + 1e-4, (off.square().sum((1, 2)) / count + 1e-8).sqrt()


def error_ratio(log_depth: Tensor, batch: tuple[Tensor, ...]) -> Tensor:
    """For each picture, ratio of its errors to those of the completed depth, summed over mean and RMS; (N,)."""
    mean, rms = errors(log_depth, batch)
    with torch.no_grad():
        mean_before, rms_before = errors(batch[4][:, 0], batch)
    return mean / (mean_before + _MIN_MEAN) + rms / (rms_before + _MIN_RMS)
