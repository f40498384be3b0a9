"""Depth edges learnt by what they do: a lesson that goes on from a trained depth-edge network."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from ..trainer import Arrays
from .conducting import ConductingModel, counted_cells, solution, true_cells, whole_loss
from .lesson import DepthEdgeLesson
from .pictures import PictureFolder, less_known, read_picture, sample_of


class ConductingLesson(DepthEdgeLesson):
    """The depth-edge network and its conductances, end to end through the depth that spreads.

    Parameters
    ----------
    folder : PictureFolder
    start : Path
        Checkpoint of the depth-edge network, whose averaged weights are gone on from.
    rises : bool
        Whether rises of the links, and how far to trust known cells, are learnt too.
    """

    seed = 31
    peak_rate = 5e-4
    file_name = "conducting.pt"

    def __init__(self, folder: PictureFolder, start: Path, rises: bool = True) -> None:
        super().__init__(folder)
        self.start = start
        self.rises = rises

    def new_model(self) -> nn.Module:
        model = ConductingModel(self.rises)
        model.base.load_state_dict(torch.load(self.start, map_location="cpu")["average"])
        return model

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        return whole_loss(model, batch)

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        errors = []
        for k, picture in enumerate(map(read_picture, self.folder.held_out)):
            depth = less_known(picture, np.random.default_rng((super().seed, k)))
            sample = sample_of(picture, np.asarray(picture.rgb / 255, np.float32), depth)
            image, features, _, log_depth = tensors(tuple(one[None] for one in sample))
            counted = counted_cells(log_depth, features)
            if counted.any():
                off = solution(features, model(image, features)[2]) - true_cells(log_depth)[1]
                errors.append(float(off.abs()[counted].mean()))
        return {"error of the solution": float(np.mean(errors)), "median": float(np.median(errors))}

    def export(self, model: nn.Module, path: Path) -> None:
        torch.save(model.state_dict(), path)
