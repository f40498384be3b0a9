"""Blocks that the arguments name, from this program or another, and what is left of the extraction then."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from ..ebs import FoundBlocks
from ..ebs.gaps import gaps_filled
from ..frame import RGBDFrame
from ..io import LoadedBlocks, read_blocks
from ..parameters import BlockParameters
from .parsing import BLOCK_PREFIX, UsageError, given_parameters, with_given


def add_given_blocks(group: Any, *flags: str) -> None:
    """Add the arguments that name blocks, and say what is done where they leave gaps."""
    group.add_argument(
        *flags,
        dest="blocks",
        metavar="PATH",
        help="take these blocks, do not extract them: a label map (PNG), labelme or COCO JSON, masks of "
        "segment-anything (JSON) or a folder of masks (a PNG each); where they overlap, the smallest lies on top",
    )
    group.add_argument(
        "--fill-gaps", action="store_true", help=f"where {flags[0]} has no block, take those of the extraction"
    )


def check_given_blocks(
    arguments: argparse.Namespace, flag: str, base: BlockParameters | None = None
) -> BlockParameters:
    """What blocks are extracted with, from `base` on; UsageError for arguments about something that there is not."""
    if arguments.blocks is None and arguments.fill_gaps:
        raise UsageError(f"--fill-gaps is about blocks that are given: name them by {flag}.")
    given = given_parameters(arguments, BlockParameters)
    if arguments.blocks is not None and given and not arguments.fill_gaps:
        raise UsageError(
            f"With {flag} nothing is extracted: leave out the --{BLOCK_PREFIX}* flags, or add --fill-gaps."
        )
    return with_given(base or BlockParameters(), arguments)


def given_blocks(arguments: argparse.Namespace, frame: RGBDFrame) -> LoadedBlocks:
    """The blocks that the arguments name; a map without blocks if they name none."""
    if arguments.blocks is None:
        return LoadedBlocks(np.zeros(frame.shape, np.int32))
    return read_blocks(arguments.blocks, frame.shape, image=None if frame.inputs is None else frame.inputs.rgb.path)


def filled(blocks: LoadedBlocks, extracted: FoundBlocks, parameters: BlockParameters) -> LoadedBlocks:
    """Blocks with those of an extraction in their gaps."""
    labels = gaps_filled(blocks.labels, extracted.blocks, parameters)
    return LoadedBlocks(labels, blocks.names, blocks.notes + extracted.notes)
