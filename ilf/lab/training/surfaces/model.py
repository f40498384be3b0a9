"""The surface network: a U-Net that looks at a frame once, and a small recurrent network that corrects its depth."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from ....segmentation.edges.surfaces import AROUND, CELL, CHANNELS
from .conduction import Links, conduct

WIDTHS = (24, 32, 48, 64, 96, 96)
"""Channels of the stages, at 1/2 to 1/64 of the picture's size."""

BLOCKS = (0, 1, 2, 2, 2, 1)
"""Residual blocks of each stage."""

UP_WIDTHS = (24, 32, 32, 48, 64)
"""Channels of the decoder, at 1/2 to 1/32."""

EMBEDDING = 8
"""Channels of the embedding."""

LINES = ("jump", "crease", "border")
"""The lines that the network finds, in this order."""

_INITIAL = -3.0
"""Initial logit of lines and initial log error of the coarse depth: 5 %."""


class ResidualBlock(nn.Module):
    """x + BN(conv(ReLU(BN(conv(x))))), then ReLU."""

    def __init__(self, channels: int, dilation: int = 1) -> None:
        super().__init__()
        self.first = _convolution(channels, channels, dilation)
        self.first_norm = nn.BatchNorm2d(channels)
        self.second = _convolution(channels, channels, dilation)
        self.second_norm = nn.BatchNorm2d(channels)

    def forward(self, x: Tensor) -> Tensor:
        y = functional.relu(self.first_norm(self.first(x)))
        return functional.relu(x + self.second_norm(self.second(y)))


def _convolution(inputs: int, outputs: int, dilation: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, padding=dilation, dilation=dilation, bias=False)


def _stage(inputs: int, channels: int, blocks: int, kernel: int) -> nn.Sequential:
    entry = nn.Conv2d(inputs, channels, kernel, stride=2, padding=kernel // 2 - 1, bias=False)
    rest = (ResidualBlock(channels) for _ in range(blocks))
    return nn.Sequential(entry, nn.BatchNorm2d(channels), nn.ReLU(), *rest)


class SurfaceModel(nn.Module):
    """Network from colour and features of the known depth to lines, coarse depth, an embedding, and what the
    correction of the depth needs.

    The image is (N, 3, H, W), RGB in [0, 1], the features are (N, 6, H, W), H and W multiples of 32. `forward` gives
    the logits of jump, crease and border, (N, 3, H, W); the coarse depth, (N, 2, H/4, W/4): the log depth minus the
    filled one of the features, and the log of its mean error; the embedding, (N, 8, H/4, W/4); the context of the
    correction, (N, CONTEXT, H/4, W/4); and logits of the weights with which each pixel averages the changes of the
    cells around it, (N, 36, H/2, W/2): for each of the 9 cells those of the 2 x 2 pixels.
    """

    def __init__(self) -> None:
        super().__init__()
        entries = (3 + len(CHANNELS), *WIDTHS[:-1])
        self.stages = nn.ModuleList(
            # The first convolution covers every pixel of the full size: 6 x 6 around each 2 x 2.
            _stage(before, width, blocks, 4 if k else 6)
            for k, (before, width, blocks) in enumerate(zip(entries, WIDTHS, BLOCKS, strict=True))
        )
        self.across = nn.ModuleList(nn.Conv2d(*pair, 1) for pair in zip(WIDTHS, UP_WIDTHS, strict=False))
        self.up = nn.ModuleList(
            nn.Conv2d(*pair, 1) for pair in zip((*UP_WIDTHS[1:], WIDTHS[-1]), UP_WIDTHS, strict=True)
        )
        self.refine = nn.ModuleList(ResidualBlock(width) for width in UP_WIDTHS)
        self.lines = nn.Conv2d(UP_WIDTHS[0], len(LINES) * 4, 3, padding=1)
        self.coarse = nn.Conv2d(UP_WIDTHS[1], 2, 3, padding=1)
        self.embedding = nn.Conv2d(UP_WIDTHS[1], EMBEDDING, 3, padding=1)
        self.weights = nn.Conv2d(UP_WIDTHS[0], AROUND * 4, 3, padding=1)
        with torch.no_grad():
            self.lines.bias.fill_(_INITIAL)
            self.coarse.bias.copy_(torch.tensor((0.0, _INITIAL)))
            self.weights.weight.zero_()
            self.weights.bias.zero_()
            self.weights.bias.view(AROUND, 4)[AROUND // 2] = 1.0

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
        half, quarter = self.levels(image, features)
        lines, coarse = self.lines(half), self.coarse(quarter)
        # the first four are the jumps in 2 x 2 pixels; pooled from centre to centre of the cells
        jump = lines[:, :4].amax(1, keepdim=True)
        across = functional.max_pool2d(functional.pad(jump[..., 1:], (0, 1), value=-9.0), CELL // 2)
        down = functional.max_pool2d(functional.pad(jump[..., 1:, :], (0, 0, 0, 1), value=-9.0), CELL // 2)
        context = torch.cat([across / 4, down / 4, coarse[:, :1], coarse[:, 1:] / 4, quarter], 1)
        return functional.pixel_shuffle(lines, 2), coarse, self.embedding(quarter), context, self.weights(half)

    def levels(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        """Features at 1/2 and 1/4 of the picture's size."""
        x = torch.cat([(image - 0.45) * 4, features], 1)
        finer = []
        for stage in self.stages:
            x = stage(x)
            finer.append(x)
        for k in reversed(range(len(UP_WIDTHS))):
            # of that size, because the coarsest stage halves odd sides
            above = functional.interpolate(self.up[k](x), finer[k].shape[2:], mode="bilinear", align_corners=False)
            x = self.refine[k](functional.relu(above + self.across[k](finer[k])))
            if k == 1:
                quarter = x
        return x, quarter


# The correction: from the context and depth that is completed so far, how changes of depth spread between cells.

CONTEXT = 4 + UP_WIDTHS[1]
"""Channels of the context: jumps to the right and below, coarse depth and its error, and features."""

STATE = ("known", "departure", "coarse departure", "fine relief", "wide relief", "guide", "guided")
"""Channels of the state of completion, see `Frame.state`."""

HIDDEN = 16
"""Channels that one step passes to the next."""

_WIDTH = 32
_DILATIONS = (1, 3)

FIRMNESS = 10.0
"""Firmness with which a cell of known pixels is held to its depth, relative to a conductance of 1."""

MIN_CONDUCTANCE = 1e-5

_STEEPNESS = 4.0
"""Initial exponent that turns the probability of no jump into a conductance."""

_GAIN, _RISE_GAIN, _TARGET_GAIN = 4.0, 0.1, 0.5
"""Gains of the last convolution's outputs: for conductance and trust, rises of log depth, and the change itself."""

_INITIAL_TRUST, _INITIAL_LEVELLING = -4.0, -3.0
"""Initial logarithm of the firmness with which cells without known depth are held to the completed depth, and initial
logit of the share of its own rises that is removed."""

_DEPARTURE_GAIN, _FINE_GAIN, _WIDE_GAIN, _GUIDE_GAIN, _LIMIT = 4.0, 20.0, 4.0, 4.0, 4.0
_FINE, _WIDE = 3, 13


class Frame(NamedTuple):
    """What stays the same for all steps of the correction.

    Attributes
    ----------
    context : Tensor, shape (N, CONTEXT, h, w)
        Of cells of 4 x 4 pixels, as all but the weights.
    weights : Tensor, shape (N, 9, 4, H/2, W/2)
        Weights with which each pixel averages the changes of the cells around it.
    coarse, known, filled, guide, guided : Tensor, shape (N, 1, h, w)
        Coarse log depth minus the filled one; share of known depth; filled log depth minus the median of the known
        one; the guide's log depth minus the same median; the confidence in the guide, 0 where there is none.
    """

    context: Tensor
    weights: Tensor
    coarse: Tensor
    known: Tensor
    filled: Tensor
    guide: Tensor
    guided: Tensor

    def state(self, cells: Tensor) -> Tensor:
        """The state of completion, (N, 7, h, w), given the completed log depth of the cells, (N, 1, h, w)."""
        departure = cells - self.filled
        channels = [
            self.known,
            _DEPARTURE_GAIN * departure,
            _DEPARTURE_GAIN * (departure - self.coarse),
            _FINE_GAIN * (cells - _mean(cells, _FINE)),
            _WIDE_GAIN * (cells - _mean(cells, _WIDE)),
            _GUIDE_GAIN * (self.guide - cells) * self.guided,
            self.guided,
        ]
        return torch.cat(channels, 1).clamp(-_LIMIT, _LIMIT)

    def change(self, links: Links) -> Tensor:
        """The change of log depth of every pixel, (N, 1, H, W)."""
        cells = conduct(*links).float()
        count, height, width = cells.shape
        around = functional.unfold(functional.pad(cells[:, None], (1, 1, 1, 1), mode="replicate"), 3)
        around = functional.interpolate(around.view(count, AROUND, height, width), scale_factor=CELL // 2, mode="nearest")
        return functional.pixel_shuffle((self.weights * around[:, :, None]).sum(1), 2)


def _mean(values: Tensor, side: int) -> Tensor:
    return functional.avg_pool2d(functional.pad(values, (side // 2,) * 4, mode="replicate"), side, stride=1)


class CorrectionModel(nn.Module):
    """One step of the correction: from context, state of completion and what the step before has passed on, to the
    links of cells of 4 x 4 pixels (`conduct`).

    `forward` takes (N, CONTEXT, h, w), (N, 7, h, w), (N, HIDDEN, h, w) and the completed log depth of the cells,
    (N, 1, h, w), and gives links and what it passes on.
    """

    def __init__(self) -> None:
        super().__init__()
        self.entry = nn.Sequential(
            _convolution(CONTEXT + len(STATE) + HIDDEN, _WIDTH), nn.BatchNorm2d(_WIDTH), nn.ReLU()
        )
        self.blocks = nn.Sequential(*(ResidualBlock(_WIDTH, dilation) for dilation in _DILATIONS))
        self.links = nn.Conv2d(_WIDTH, 9, 3, padding=1)
        self.passed = nn.Conv2d(_WIDTH, HIDDEN, 1)
        self.steepness = nn.Parameter(torch.tensor(_STEEPNESS))
        with torch.no_grad():
            self.links.weight.zero_()
            self.links.bias.zero_()

    def forward(self, context: Tensor, state: Tensor, passed: Tensor, cells: Tensor) -> tuple[Links, Tensor]:
        x = self.blocks(self.entry(torch.cat([context, state, passed], 1)))
        found, across, down = self.links(x).float(), 4 * context[:, 0].float(), 4 * context[:, 1].float()
        right = self._conductance(_GAIN * found[:, 0] + across)[:, :, :-1]
        below = self._conductance(_GAIN * found[:, 1] + down)[:, :-1]
        levelling, completed = torch.sigmoid(_INITIAL_LEVELLING + _GAIN * found[:, 4:6]), cells[:, 0].float()
        risen, fallen = completed[:, :, 1:] - completed[:, :, :-1], completed[:, 1:] - completed[:, :-1]
        rise_right = _RISE_GAIN * found[:, 2, :, :-1] - levelling[:, 0, :, :-1] * risen
        rise_below = _RISE_GAIN * found[:, 3, :-1] - levelling[:, 1, :-1] * fallen
        firm = FIRMNESS * state[:, 0].float() * torch.exp((_GAIN * found[:, 6]).clamp(-6, 3))
        loose = torch.exp((_INITIAL_TRUST + _GAIN * found[:, 7]).clamp(-9, 4))
        pull = loose * _TARGET_GAIN * found[:, 8]
        return (right, below, rise_right, rise_below, firm + loose, pull), torch.tanh(self.passed(x))

    def _conductance(self, logit: Tensor) -> Tensor:
        return torch.exp(-self.steepness * functional.softplus(logit)).clamp(max=1) + MIN_CONDUCTANCE


class FrameModel(nn.Module):
    """The surface network and the correction, trained together."""

    def __init__(self) -> None:
        super().__init__()
        self.surfaces = SurfaceModel()
        self.correction = CorrectionModel()

    def corrected(
        self, found: tuple[Tensor, ...], features: Tensor, completed: Tensor, guide: Tensor, steps: int
    ) -> list[Tensor]:
        """The completed log depth after each step, (N, 1, H, W).

        Parameters
        ----------
        found : tuple of Tensor
            The outputs of the surface network.
        features : Tensor, shape (N, 6, H, W)
        completed : Tensor, shape (N, 1, H, W)
            Log depth minus the median of the known one.
        guide : Tensor, shape (N, 2, H, W)
            Log depth minus the same median, and the confidence in it, 0 where there is none.
        steps : int
        """
        _, coarse, _, context, weights = found
        count, _, height, width = weights.shape
        weights = functional.softmax(weights.float().view(count, AROUND, 4, height, width), 1)
        known, filled, depth, share = functional.avg_pool2d(torch.cat([features[:, :2], guide], 1), CELL).split(1, 1)
        frame = Frame(context, weights, coarse[:, :1].float(), known, filled, depth, share)
        passed = context.new_zeros((count, HIDDEN, *context.shape[2:]))
        depths = []
        for _ in range(steps):
            cells = functional.avg_pool2d(completed, CELL)
            links, passed = self.correction(context, frame.state(cells), passed, cells)
            completed = completed + frame.change(links)
            depths.append(completed)
        return depths
