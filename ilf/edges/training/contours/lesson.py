"""Contours of pictures as the trainer learns them: crops of BSDS500's images, and all of those held out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from torch import Tensor, nn

from ...network import MULTIPLE
from ...onnx_network import reflected
from ..trainer import Arrays, Lesson
from .data import Example, consensus, random_sample
from .export import export_onnx
from .model import EdgeModel, edge_loss

BATCH = 4
CROP = 320


class Contours(Lesson):
    """The lesson of the edge network.

    Parameters
    ----------
    learnt, held_out : list of Example
    """

    seed = 20
    peak_rate = 2e-3
    file_name = "edges.onnx"

    def __init__(self, learnt: list[Example], held_out: list[Example]) -> None:
        self.learnt = learnt
        self.others = held_out

    def new_model(self) -> nn.Module:
        return EdgeModel()

    def batch(self, rng: np.random.Generator) -> Arrays:
        chosen = rng.integers(len(self.learnt), size=BATCH)
        images, shares = zip(*(random_sample(self.learnt[k], CROP, rng) for k in chosen), strict=True)
        return np.stack(images), np.stack(shares)[..., None]

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, share = batch
        return edge_loss(model(image), share)

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        losses = []
        for example in self.others:
            padded, window = reflected(example.rgb, MULTIPLE, MULTIPLE)
            share = consensus(example.segmentations)[None, ..., None]
            image, truth = tensors((np.asarray(padded[None] / 255, np.float32), share))
            losses.append(float(edge_loss([one[:, :, window[0], window[1]] for one in model(image)], truth)))
        return {"held-out loss": float(np.mean(losses))}

    def export(self, model: nn.Module, path: Path) -> None:
        assert isinstance(model, EdgeModel)
        export_onnx(model, path)
