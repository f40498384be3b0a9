"""Training task of the surface network and the correction: generated pictures, to which new ones may be added during
training."""

from __future__ import annotations

import time
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from ....segmentation.edges.surfaces import CELL, CHANNELS, LOG_SPREADS
from ..trainer import Arrays, TrainingTask, write_onnx
from .initialisation import initialise_from
from .measures import LineScore
from .model import CONTEXT, HIDDEN, LINES, STATE, CorrectionModel, FrameModel, SurfaceModel
from .pictures import Picture, PictureFolder, random_sample, read_picture, sample_of, with_hidden_depth

# Loss: lines, coarse depth and embedding, and the error of the corrected depth.

POSITIVE_WEIGHT = 3.0
"""Weight of a pixel on a line; other pixels have 1."""

BESIDE_WEIGHT = 0.25
"""Weight of a pixel beside a line."""

KNOWN_WEIGHT = 0.4
"""Weight of pixels with known depth, where the known depth shows edges; pixels with missing depth have 1."""

LINE_SHARES = (1.0, 0.5, 0.7)
"""Weights of jumps, creases and borders in the loss."""

COARSE_SHARE, EMBEDDING_SHARE = 0.1, 0.1
STEP_SHARES = (0.4, 0.6)
"""Weights in the loss of the error after each step of the correction."""


def line_loss(logits: Tensor, lines: Tensor, features: Tensor) -> Tensor:
    """Weighted cross-entropy of lines, (N, 3, H, W)."""
    near = functional.max_pool2d(lines, 3, stride=1, padding=1) > 0
    weights = torch.where(lines > 0, POSITIVE_WEIGHT, torch.where(near, BESIDE_WEIGHT, 1.0))
    weights = weights * _where_missing(features)
    shares = torch.tensor(LINE_SHARES, device=lines.device).view(1, -1, 1, 1)
    loss = functional.binary_cross_entropy_with_logits(logits.float(), lines, weights * shares, reduction="sum")
    return loss / weights[:, 0].sum()


def coarse_loss(coarse: Tensor, log_depth: Tensor, features: Tensor) -> Tensor:
    """Negative log likelihood of a Laplace distribution around the coarse depth.

    Parameters
    ----------
    coarse : Tensor, shape (N, 2, H/4, W/4)
        Log depth minus the filled one, and the log of its mean error.
    log_depth : Tensor, shape (N, 1, H, W)
        True log depth in the unit of the features, NaN where there is none.
    features : Tensor, shape (N, 6, H, W)
    """
    offset = at_quarter(log_depth - features[:, CHANNELS.index("filled")][:, None])
    weights = at_quarter(_where_missing(features)) * torch.isfinite(offset)
    middle, spread = coarse.float().split(1, 1)
    spread = spread.clamp(*LOG_SPREADS)
    loss = (torch.nan_to_num(offset) - middle).abs() * torch.exp(-spread) + spread
    return (loss * weights).sum() / weights.sum().clamp(min=1)


def at_quarter(values: Tensor) -> Tensor:
    """Take one pixel of each 4 x 4, not their mean, which could lie between two surfaces."""
    return values[..., CELL // 2 :: CELL, CELL // 2 :: CELL]


def _where_missing(features: Tensor) -> Tensor:
    known = features[:, CHANNELS.index("known")][:, None]
    return 1 - (1 - KNOWN_WEIGHT) * known


_MOST_THINGS, _LEAST_CELLS = 32, 6
"""Maximum number of objects of a picture in the loss of the embedding, and minimum number of cells of each."""

_NEAR, _APART = 0.3, 2.0
"""Distance from the mean of an object within which its pixels cost nothing, and distance of two means from which on
they cost nothing."""


def embedding_loss(embedding: Tensor, things: Tensor) -> Tensor:
    """Cost of pixels far from the mean of their object, and of objects whose means are near each other.

    Parameters
    ----------
    embedding : Tensor, shape (N, C, H/4, W/4)
    things : Tensor, shape (N, 1, H, W)
        Number of the object of each pixel.
    """
    losses = []
    for values, numbers in zip(embedding.float().flatten(2), at_quarter(things).flatten(1), strict=True):
        found, inverse, counts = torch.unique(numbers, return_inverse=True, return_counts=True)
        kept = torch.nonzero(counts >= _LEAST_CELLS)[:, 0]
        kept = kept[torch.argsort(counts[kept], descending=True)[:_MOST_THINGS]]
        if len(kept) == 0:
            continue
        inside = (inverse[None] == kept[:, None]).float()
        means = inside @ values.T / inside.sum(1, keepdim=True)
        # every object counts by the square root of its size
        weights = inside.sum(1).sqrt() / inside.sum(1)
        off = functional.relu((values - means.T @ inside).norm(dim=0) - _NEAR).square()
        pull = (inside.T @ weights * off).sum() / (weights @ inside).sum().clamp(min=1e-6)
        apart = functional.relu(_APART - torch.cdist(means, means)).square()
        between = 1 - torch.eye(len(kept), device=means.device)
        losses.append(pull + (apart * between).sum() / between.sum().clamp(min=1) + 1e-3 * means.norm(dim=1).mean())
    return torch.stack(losses).mean() if losses else embedding.float().sum() * 0


_MIN_MEAN, _MIN_RMS = 0.01, 0.02
"""Minimum errors of the completed depth, in units of the frame's median depth; smaller ones count as these."""

_NEAREST, _FARTHEST = -4.0, 2.0
"""Range of log depth minus its median in which errors count in full."""


def counted(features: Tensor, log_depth: Tensor) -> Tensor:
    """Pixels with a true depth, but without a known one; (N, H, W)."""
    return torch.isfinite(log_depth[:, 0]) & (features[:, 0] == 0)


def errors(depth: Tensor, features: Tensor, log_depth: Tensor) -> tuple[Tensor, Tensor]:
    """Mean and root mean square error of log depth (N, 1, H, W) of each picture over its counted pixels, in units of
    its median depth; (N,)."""
    there = counted(features, log_depth)
    true = torch.exp(torch.nan_to_num(log_depth[:, 0]).clamp(max=_FARTHEST))
    off = (torch.exp(depth[:, 0].clamp(_NEAREST, _FARTHEST)) - true) * there
    count = there.sum((1, 2)).clamp(min=1)
    return off.abs().sum((1, 2)) / count + 1e-4, (off.square().sum((1, 2)) / count + 1e-8).sqrt()


def error_ratio(depth: Tensor, before: Tensor, features: Tensor, log_depth: Tensor) -> Tensor:
    """For each picture, ratio of the errors of log depth to those of another, summed over mean and RMS; (N,)."""
    mean, rms = errors(depth, features, log_depth)
    with torch.no_grad():
        mean_before, rms_before = errors(before, features, log_depth)
    return mean / (mean_before + _MIN_MEAN) + rms / (rms_before + _MIN_RMS)


# The trained models as ONNX.


class _DeployedSurfaces(nn.Module):
    def __init__(self, model: SurfaceModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, depth: Tensor) -> tuple[Tensor, ...]:
        lines, *rest = self.model(image, depth)
        return torch.sigmoid(lines), *rest


class _DeployedCorrection(nn.Module):
    def __init__(self, model: CorrectionModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, context: Tensor, state: Tensor, passed: Tensor, cells: Tensor) -> tuple[Tensor, Tensor]:
        (right, below, rise_right, rise_below, held, pull), passed = self.model(context, state, passed, cells)
        beyond, beneath = (0, 1), (0, 0, 0, 1)
        links = [
            functional.pad(one[:, None], side)
            for one, side in ((right, beyond), (below, beneath), (rise_right, beyond), (rise_below, beneath))
        ]
        return torch.cat([*links, held[:, None], pull[:, None]], 1), passed


def export_onnx(model: FrameModel, path: Path) -> None:
    """Write the surface network to an ONNX file, and the correction beside it."""
    ready = deepcopy(model).cpu().eval()
    outputs = ("lines", "coarse", "embedding", "context", "weights")
    write_onnx(_DeployedSurfaces(ready.surfaces).eval(), path, {"image": 3, "depth": len(CHANNELS)}, outputs)
    inputs = {"context": CONTEXT, "state": len(STATE), "passed": HIDDEN, "cells": 1}
    step = _DeployedCorrection(ready.correction).eval()
    write_onnx(step, path.with_name("correction.onnx"), inputs, ("links", "next"))


BATCH = 4
SIDES = (256, 320)
"""Height and width of the samples."""

WHOLE, COMPLETED = 0.1, 0.45
"""Share of the batches that are one whole picture of twice the size, and of those with details of completed ones."""

DETAILS = 0.3
"""Share of the other samples that show a quarter of a picture at twice its size."""

RELIST_INTERVAL_S = 60.0
"""Interval at which the folders are listed again."""

FAR_FROM_KNOWN = np.log1p(3) / 4
"""The feature "distance" at 3 px from known depth; up to there the known depth itself shows jumps."""

_TRIED, _LEAST, _MOST = 4, 0.02, 0.98
"""Windows that are tried in a completed picture, and share of known depth within which there is something to learn."""


class SurfaceTraining(TrainingTask):
    """Training task of the surface network and the correction.

    Parameters
    ----------
    pictures, completed : PictureFolder
        Generated pictures, and some that have been completed.
    start : Path, optional
        ONNX network that initialises the surface network, as far as it has the same convolutions.
    """

    seed = 29
    peak_rate = 2e-3
    file_name = "surfaces.onnx"

    def __init__(self, pictures: PictureFolder, completed: PictureFolder, start: Path | None = None) -> None:
        self.pictures, self.completed, self.start = pictures, completed, start
        self._looked = time.monotonic()

    def new_model(self) -> nn.Module:
        model = FrameModel()
        if self.start is not None:
            image, features, *_ = (torch.from_numpy(one) for one in self.batch(np.random.default_rng(self.seed)))
            initialise_from(model.surfaces, self.start, image.permute(0, 3, 1, 2), features.permute(0, 3, 1, 2))
        return model

    def batch(self, rng: np.random.Generator) -> Arrays:
        if time.monotonic() > self._looked + RELIST_INTERVAL_S:
            for folder in (self.pictures, self.completed):
                folder.relist()
            self._looked = time.monotonic()
        kind = rng.random()
        if kind < WHOLE:
            while (picture := self._one(self.completed, rng)).part.shape == SIDES:
                pass
            chosen = [picture]
        elif kind < WHOLE + COMPLETED:
            chosen = [_detail(self._one(self.completed, rng), rng) for _ in range(BATCH)]
        else:
            chosen = [self._one(self.pictures, rng) for _ in range(BATCH)]
            chosen = [_enlarged_part(one, rng) if rng.random() < DETAILS else one for one in chosen]
        samples = [random_sample(one, rng) for one in chosen]
        return tuple(np.stack(arrays) for arrays in zip(*samples, strict=True))

    @staticmethod
    def _one(folder: PictureFolder, rng: np.random.Generator) -> Picture:
        return read_picture(folder.learnt[rng.integers(len(folder.learnt))])

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        assert isinstance(model, FrameModel)
        image, features, lines, log_depth, completed, guide, things = batch
        found = model.surfaces(image, features)
        loss = line_loss(found[0], lines, features) + COARSE_SHARE * coarse_loss(found[1], log_depth, features)
        loss = loss + EMBEDDING_SHARE * embedding_loss(found[2], things)
        depths = model.corrected(found, features, completed, guide, len(STEP_SHARES))
        for share, depth in zip(STEP_SHARES, depths, strict=True):
            loss = loss + share * error_ratio(depth, completed, features, log_depth).mean()
        return loss

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        assert isinstance(model, FrameModel)
        scores = [LineScore() for _ in LINES]
        coarse, filled = [], []
        for k, picture in enumerate(map(read_picture, self.pictures.held_out)):
            depth = with_hidden_depth(picture, np.random.default_rng((self.seed, k)))
            sample = sample_of(picture, np.asarray(picture.rgb / 255, np.float32), depth)
            image, features, _, log_depth, *_ = tensors(tuple(one[None] for one in sample))
            found = model.surfaces(image, features)
            far = sample[1][..., CHANNELS.index("distance")] > FAR_FROM_KNOWN
            for score, line, truth in zip(scores, found[0][0].sigmoid(), sample[2].transpose(2, 0, 1) > 0, strict=True):
                score.add(line.cpu().numpy(), truth, far)
            offset = at_quarter(log_depth - features[:, 1:2])[0, 0].cpu().numpy()
            there = np.isfinite(offset) & far[2::4, 2::4]
            coarse.append(np.abs(offset - found[1][0, 0].cpu().numpy())[there])
            filled.append(np.abs(offset)[there])
        return {
            **{f"{name} AP": score.average_precision for name, score in zip(LINES, scores, strict=True)},
            "coarse error": float(np.mean(np.concatenate(coarse)) / np.mean(np.concatenate(filled))),
            **self._correction(model, tensors),
        }

    def _correction(self, model: FrameModel, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        """Geometric means of the ratios of errors to those of the completed depth, and the largest ratio."""
        ratios = []
        for picture in map(read_picture, self.completed.held_out):
            sample = sample_of(picture, np.asarray(picture.rgb / 255, np.float32), picture.measured)
            image, features, _, log_depth, completed, guide, _ = tensors(tuple(one[None] for one in sample))
            if counted(features, log_depth).any():
                found = model.surfaces(image, features)
                depth = model.corrected(found, features, completed, guide, len(STEP_SHARES))[-1]
                now, before = (torch.cat(errors(one, features, log_depth)) for one in (depth, completed))
                ratios.append(torch.log(now / before).cpu().numpy())
        mean, rms = np.exp(np.mean(ratios, axis=0))
        return {"MAE ratio": float(mean), "RMS ratio": float(rms), "worst": float(np.exp(np.max(ratios)))}

    def export(self, model: nn.Module, path: Path) -> None:
        assert isinstance(model, FrameModel)
        export_onnx(model, path)


def _enlarged_part(picture: Picture, rng: np.random.Generator) -> Picture:
    """A quarter of a picture, at twice its size."""
    sides = [size // 2 for size in picture.part.shape]
    corner = [int(rng.integers(side + 1)) for side in sides]
    rows, columns = (slice(start, start + side) for start, side in zip(corner, sides, strict=True))
    return picture.window(rows, columns).enlarged


def _detail(picture: Picture, rng: np.random.Generator) -> Picture:
    """A part of a completed picture of the size of the others, with both known and missing depth if there is one."""
    for _ in range(_TRIED):
        corner = [int(rng.integers((whole - side) // CELL + 1)) * CELL for whole, side in zip(picture.part.shape, SIDES, strict=True)]
        rows, columns = (slice(start, start + side) for start, side in zip(corner, SIDES, strict=True))
        if _LEAST < np.isfinite(picture.measured[rows, columns]).mean() < _MOST:
            break
    return picture.window(rows, columns)
