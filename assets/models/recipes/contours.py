"""The contour network: lines and an embedding from colour alone.

It learns from generated pictures with exact lines, and from real frames with measured depth.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from ilf.data.frame import RGBDFrame

from .contour_samples import REAL, generated_sample, real_sample, sample_of
from .depth_edges import BESIDE_WEIGHT, POSITIVE_WEIGHT, at_quarter
from .initialisation import initialise_from
from .lines import LineScore
from .pictures import PictureFolder, read_picture
from .trainer import Arrays, Recipe
from .unet import UP_WIDTHS, UNet, lines_head

BATCH = 4

REAL_FRAMES = 0.2
"""Share of real frames among the samples."""

LINES = ("jump", "crease", "border")
"""The lines that the network learns, in this order; borders are jumps and lines between objects."""

EMBEDDING = 8
"""Channels of the embedding."""

LINE_SHARES = (1.0, 0.5, 1.0)
"""Weights of jumps, creases and borders in the loss."""

EMBEDDING_SHARE, REAL_SHARE = 0.1, 0.5
"""Weights of the embedding and of a real frame in the loss; a generated picture's lines have 1."""

OFFSET = 3
"""Largest offset [px] of jumps of measured depth from those in the colour image."""

_MOST_THINGS, _LEAST_CELLS = 32, 6
"""Maximum number of objects of a picture in the loss of the embedding, and minimum number of cells of each."""

_NEAR, _APART = 0.3, 2.0
"""Distance from the mean of an object within which its pixels cost nothing, and distance of two means from which on
they cost nothing."""

_FAINTEST, _STRONGEST = -6.0, 2.0
"""Range of the logit of a border that strength covers from 0 to 1: blocks need faint lines, too."""


class ContourModel(UNet):
    """Network from colour to logits of lines and an embedding.

    The image is (N, 3, H, W), RGB in [0, 1], H and W multiples of 32. `forward` gives the logits of jump, crease and
    border, (N, 3, H, W), and the embedding, (N, 8, H/4, W/4), in which pixels of one object lie near each other.
    """

    def __init__(self) -> None:
        super().__init__(3)
        self.lines = lines_head(len(LINES))
        self.embedding = nn.Conv2d(UP_WIDTHS[1], EMBEDDING, 3, padding=1)

    def forward(self, image: Tensor) -> tuple[Tensor, Tensor]:
        half, quarter = self.levels(image)
        return functional.pixel_shuffle(self.lines(half), 2), self.embedding(quarter)


def line_loss(logits: Tensor, lines: Tensor) -> Tensor:
    """Weighted cross-entropy of lines, (N, 3, H, W), of each picture; (N,)."""
    near = functional.max_pool2d(lines, 3, stride=1, padding=1) > 0
    weights = torch.where(lines > 0, POSITIVE_WEIGHT, torch.where(near, BESIDE_WEIGHT, 1.0))
    shares = torch.tensor(LINE_SHARES, device=lines.device).view(1, -1, 1, 1)
    loss = functional.binary_cross_entropy_with_logits(logits.float(), lines, weights * shares, reduction="none")
    return loss.sum((1, 2, 3)) / weights[:, 0].sum((1, 2))


def measured_loss(logits: Tensor, lines: Tensor, none: Tensor) -> Tensor:
    """Cross-entropy of jumps and borders of each real frame: a line within `OFFSET` of every measured jump, and none
    on smooth surfaces; (N,)."""
    jump, border = logits[:, :1].float(), logits[:, 2:].float()
    measured = lines[:, :1]
    loss = torch.zeros(len(logits), device=logits.device)
    for one in (jump, border):
        nearby = functional.max_pool2d(one, 2 * OFFSET + 1, stride=1, padding=OFFSET)
        missed, wrong = functional.softplus(-nearby) * measured, functional.softplus(one) * none
        for cost, where, weight in ((missed, measured, 0.3), (wrong, none, 1.0)):
            loss = loss + weight * cost.sum((1, 2, 3)) / where.sum((1, 2, 3)).clamp(min=100)
    return loss


def embedding_loss(embedding: Tensor, things: Tensor) -> Tensor:
    """Cost of pixels far from the mean of their object, and of objects whose means are near each other.

    Parameters
    ----------
    embedding : Tensor, shape (C, H/4, W/4)
    things : Tensor, shape (H/4, W/4)
        Number of the object of each pixel.
    """
    values, numbers = embedding.float().flatten(1), things.flatten()
    _, inverse, counts = torch.unique(numbers, return_inverse=True, return_counts=True)
    kept = torch.nonzero(counts >= _LEAST_CELLS)[:, 0]
    kept = kept[torch.argsort(counts[kept], descending=True)[:_MOST_THINGS]]
    if len(kept) == 0:
        return values.sum() * 0
    inside = (inverse[None] == kept[:, None]).float()
    means = inside @ values.T / inside.sum(1, keepdim=True)
    # every object counts by the square root of its size
    weights = inside.sum(1).sqrt() / inside.sum(1)
    off = functional.relu((values - means.T @ inside).norm(dim=0) - _NEAR).square()
    pull = (inside.T @ weights * off).sum() / (weights @ inside).sum().clamp(min=1e-6)
    apart = functional.relu(_APART - torch.cdist(means, means)).square()
    between = 1 - torch.eye(len(kept), device=means.device)
    return pull + (apart * between).sum() / between.sum().clamp(min=1) + 1e-3 * means.norm(dim=1).mean()


class _Deployed(nn.Module):
    """The borders alone, with the image and its mirror image as one batch: their mean does not depend on which is
    which."""

    def __init__(self, model: ContourModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor) -> tuple[Tensor, Tensor]:
        border = self._borders(torch.cat([image, image.flip(3)]))
        logit = (border[:1] + border[1:].flip(3)) / 2
        strength = ((logit - _FAINTEST) / (_STRONGEST - _FAINTEST)).clamp(0, 1)
        return torch.sigmoid(logit), strength

    def _borders(self, images: Tensor) -> Tensor:
        """Logits of borders, without those of the other lines."""
        half, _ = self.model.levels(images)
        first = 4 * LINES.index("border")
        weight, bias = (one[first : first + 4] for one in (self.model.lines.weight, self.model.lines.bias))
        return functional.pixel_shuffle(functional.conv2d(half, weight, bias, padding=1), 2)


class ContourRecipe(Recipe):
    """Recipe of the contour network.

    Parameters
    ----------
    folder : PictureFolder
        Generated pictures.
    frames : sequence of RGBDFrame
        Real frames.
    start : Path, optional
        Network (ONNX) that initialises the trunk; random weights if None.
    """

    seed = 29
    peak_rate = 2e-3
    file_name = "edges.onnx"
    inputs: ClassVar = {"image": 3}
    outputs = ("probability", "strength")

    def __init__(self, folder: PictureFolder, frames: Sequence[RGBDFrame], start: Path | None = None) -> None:
        self.folder, self.frames, self.start = folder, frames, start

    def new_model(self) -> nn.Module:
        model = ContourModel()
        if self.start is not None:
            initialise_from(model, self.start, self.batch(np.random.default_rng(self.seed))[0])
        return model

    def batch(self, rng: np.random.Generator) -> Arrays:
        self.folder.refresh()
        return tuple(np.stack(arrays) for arrays in zip(*(self._sample(rng) for _ in range(BATCH)), strict=True))

    def _sample(self, rng: np.random.Generator) -> Arrays:
        if self.frames and rng.random() < REAL_FRAMES:
            return real_sample(self.frames[rng.integers(len(self.frames))], rng)
        return generated_sample(self.folder.learnt[rng.integers(len(self.folder.learnt))], rng)

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, lines, none, things = batch
        logits, embedding = model(image)
        real = things[:, 0, 0, 0] == REAL
        exact, measured = line_loss(logits, lines), measured_loss(logits, lines, none)
        loss = torch.where(real, REAL_SHARE * measured, exact).mean()
        generated = torch.nonzero(~real)[:, 0]
        objects = [embedding_loss(embedding[k], at_quarter(things)[k, 0]) for k in generated]
        return loss + EMBEDDING_SHARE * torch.stack(objects).mean() if objects else loss

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        scores, losses = [LineScore() for _ in LINES], []
        for picture in map(read_picture, self.folder.held_out):
            sample = sample_of(picture, np.asarray(picture.rgb / 255, np.float32))
            image, lines, *_ = tensors(tuple(one[None] for one in sample))
            logits, _ = model(image)
            losses.append(float(line_loss(logits, lines)))
            for score, found, truth in zip(scores, logits[0].sigmoid(), sample[1].transpose(2, 0, 1) > 0, strict=True):
                score.add(found.cpu().numpy(), truth, np.ones_like(truth))
        measures = {f"{name} AP": score.average_precision for name, score in zip(LINES, scores, strict=True)}
        return {"held-out loss": float(np.mean(losses)), **measures}

    def deployed(self, model: nn.Module) -> nn.Module:
        assert isinstance(model, ContourModel)
        return _Deployed(model)
