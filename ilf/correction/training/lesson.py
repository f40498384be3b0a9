"""Correction as the trainer learns it: by the error of the corrected depth."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from ...edges.training.depth_edges.lesson import LOOK_AGAIN_S
from ...edges.training.depth_edges.loss import COARSE_SHARE, coarse_loss, line_loss
from ...edges.training.trainer import Arrays, Lesson
from .export import export_onnx
from .model import CorrectionModel, change
from .samples import SampleFolder, read_sample, varied
from .start import take_over

BATCH = 4

LINES_SHARE = 0.1
"""In the loss, of the lines and the coarse depth, which the depth-edge network has learnt; 1 is that of the error."""

_LEAST_MEAN, _LEAST_RMS = 0.01, 0.02
"""Errors of the completed depth, in units of the frame's median depth, that count as the least there are."""

_NEAREST, _FARTHEST = -4.0, 2.0
"""Log depth less its median up to which errors count in full."""


class CorrectionLesson(Lesson):
    """The lesson of the correction network.

    Parameters
    ----------
    folder : SampleFolder
    start : Path or None
        Depth-edge network (ONNX) whose trunk is gone on from; from random weights if None.
    """

    seed = 51
    peak_rate = 1.5e-3
    file_name = "correction.onnx"

    def __init__(self, folder: SampleFolder, start: Path | None) -> None:
        self.folder = folder
        self.start = start
        self._looked = time.monotonic()

    def new_model(self) -> nn.Module:
        model = CorrectionModel()
        if self.start is not None:
            image, features, *_ = (torch.from_numpy(one) for one in self.batch(np.random.default_rng(self.seed)))
            take_over(model.base, self.start, image.permute(0, 3, 1, 2), features.permute(0, 3, 1, 2))
        return model

    def batch(self, rng: np.random.Generator) -> Arrays:
        if time.monotonic() > self._looked + LOOK_AGAIN_S:
            self.folder.look_again()
            self._looked = time.monotonic()
        chosen = rng.integers(len(self.folder.learnt), size=BATCH)
        samples = [varied(read_sample(self.folder.learnt[k]), rng) for k in chosen]
        return tuple(np.stack(arrays) for arrays in zip(*samples, strict=True))

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, features, lines, log_depth, completed = batch
        of_lines, coarse, links, of_weights = model(image, features)
        before = line_loss(of_lines, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features)
        return error_ratio(completed[:, 0] + change(links, of_weights), batch).mean() + LINES_SHARE * before

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        """Geometric means of the errors over those of the completed depth, and the largest of these ratios."""
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

    def export(self, model: nn.Module, path: Path) -> None:
        assert isinstance(model, CorrectionModel)
        export_onnx(model, path)


def counted(batch: tuple[Tensor, ...]) -> Tensor:
    """Pixels with a true depth, but no known one; (N, H, W)."""
    features, log_depth = batch[1], batch[3]
    return torch.isfinite(log_depth[:, 0]) & (features[:, 0] == 0)


def errors(log_depth: Tensor, batch: tuple[Tensor, ...]) -> tuple[Tensor, Tensor]:
    """Mean and root mean square error of each picture where it counts, in units of its median depth; (N,)."""
    there = counted(batch)
    true = torch.exp(torch.nan_to_num(batch[3][:, 0]).clamp(max=_FARTHEST))
    off = (torch.exp(log_depth.clamp(_NEAREST, _FARTHEST)) - true) * there
    count = there.sum((1, 2)).clamp(min=1)
    return off.abs().sum((1, 2)) / count + 1e-4, (off.square().sum((1, 2)) / count + 1e-8).sqrt()


def error_ratio(log_depth: Tensor, batch: tuple[Tensor, ...]) -> Tensor:
    """Of each picture: its errors over those of the completed depth, mean and root mean square added; (N,)."""
    mean, rms = errors(log_depth, batch)
    with torch.no_grad():
        mean_before, rms_before = errors(batch[4][:, 0], batch)
    return mean / (mean_before + _LEAST_MEAN) + rms / (rms_before + _LEAST_RMS)
