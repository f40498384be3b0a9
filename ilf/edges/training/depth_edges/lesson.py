"""Depth edges as the trainer learns them: generated pictures, of which more and more may come."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from torch import Tensor, nn

from ...depth_features import CHANNELS
from ..trainer import Arrays, Lesson
from .export import export_onnx
from .loss import COARSE_SHARE, at_quarter, coarse_loss, line_loss
from .measures import LineScore
from .model import DepthEdgeModel
from .pictures import PictureFolder, less_known, random_sample, sample_of

BATCH = 4
LOOK_AGAIN_S = 60.0
"""How often the folder is looked through for new pictures."""

FAR = np.log1p(3) / 4
"""The feature "distance" 3 px from known depth, up to which the known depth itself tells of jumps."""


class DepthEdgeLesson(Lesson):
    """The lesson of the depth-edge network.

    Parameters
    ----------
    folder : PictureFolder
    """

    seed = 20
    peak_rate = 2e-3
    file_name = "depth-edges.onnx"

    def __init__(self, folder: PictureFolder) -> None:
        self.folder = folder
        self._looked = time.monotonic()

    def new_model(self) -> nn.Module:
        return DepthEdgeModel()

    def batch(self, rng: np.random.Generator) -> Arrays:
        if time.monotonic() > self._looked + LOOK_AGAIN_S:
            self.folder.look_again()
            self._looked = time.monotonic()
        chosen = rng.integers(len(self.folder.learnt), size=BATCH)
        samples = [random_sample(self.folder.learnt[k], rng) for k in chosen]
        return tuple(np.stack(arrays) for arrays in zip(*samples, strict=True))

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, features, lines, log_depth = batch
        logits, coarse = model(image, features)
        return line_loss(logits, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features)

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        losses, jumps, creases, errors, fills = [], LineScore(), LineScore(), [], []
        for k, picture in enumerate(self.folder.held_out):
            depth = less_known(picture, np.random.default_rng((self.seed, k)))
            sample = sample_of(picture, np.asarray(picture.rgb / 255, np.float32), depth)
            image, features, lines, log_depth = tensors(tuple(one[None] for one in sample))
            logits, coarse = model(image, features)
            losses.append(
                float(line_loss(logits, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features))
            )
            far = sample[1][..., CHANNELS.index("distance")] > FAR
            for score, found, truth in zip(
                (jumps, creases), logits[0].sigmoid(), sample[2].transpose(2, 0, 1) > 0, strict=True
            ):
                score.add(found.cpu().numpy(), truth, far)
            offset = at_quarter(log_depth - features[:, 1:2])[0, 0].cpu().numpy()
            counted = np.isfinite(offset) & far[2::4, 2::4]
            errors.append(np.abs(offset - coarse[0, 0].cpu().numpy())[counted])
            fills.append(np.abs(offset)[counted])
        return {
            "held-out loss": float(np.mean(losses)),
            "jump AP": jumps.average_precision,
            "crease AP": creases.average_precision,
            "coarse error": float(np.mean(np.concatenate(errors))),
            "filled error": float(np.mean(np.concatenate(fills))),
        }

    def export(self, model: nn.Module, path: Path) -> None:
        assert isinstance(model, DepthEdgeModel)
        export_onnx(model, path)
