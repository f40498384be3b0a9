"""`ilf blocks`: the label map of a frame, and pictures of how it comes about."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..drawing.block_pictures import stage_pictures
from ..ebs import extract
from ..ebs.reextraction import flow_around
from ..errors import InputError
from ..io import read_labels, write_labels
from ..io.atomic import write_bytes
from ..io.folders import made_folder
from ..io.images import encode_image
from ..parameters import BlockParameters
from ..run import check_not_an_input
from .parsing import Commands, UsageError, add_block_parameters, add_distrusted, add_frame, frame_from, with_given
from .report import table, warn


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "blocks",
        help="extract the operation blocks of a frame",
        usage="ilf blocks (RGB DEPTH | FOLDER) --out FILE.png [options]",
        description="Extract boundaries and surfaces (EBS) and write the label map: 16-bit PNG, 0 = no block. "
        "`ilf complete --labels` takes it, edited or not.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_distrusted(parser)
    again = parser.add_argument_group("extracting again")
    again.add_argument(
        "--around",
        metavar="FILE.png",
        help="label map whose blocks stay as they are, with their numbers; the others are extracted around them",
    )
    again.add_argument(
        "--keep", type=_numbers, metavar="N,N,...", help="only these blocks of it stay (default: all of them)"
    )
    output = parser.add_argument_group("output")
    output.add_argument("--out", metavar="FILE.png", required=True, help="the label map")
    output.add_argument(
        "--stages",
        metavar="DIR",
        help="folder for pictures of every stage of the extraction",
    )
    output.add_argument("--quiet", action="store_true", help="print nothing but errors")
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    parameters = with_given(BlockParameters(), arguments)
    frame = frame_from(arguments)
    if arguments.keep is not None and arguments.around is None:
        raise UsageError("--keep names blocks of a label map: give it by --around.")
    present = None if arguments.around is None else read_labels(arguments.around, frame.shape)
    extraction = extract(frame, parameters)
    labels = extraction.blocks
    if present is not None:
        kept = _kept(present, arguments.keep)
        labels = flow_around(present, kept, labels, parameters.smallest_block(labels.size))
    pictures = {}
    if arguments.stages is not None:
        folder = Path(arguments.stages)
        stages = stage_pictures(frame.rgb, extraction).items()
        pictures = {folder / f"{number}-{name}.png": picture for number, (name, picture) in enumerate(stages, 1)}
    check_not_an_input(frame, [Path(arguments.out), *pictures])
    write_labels(arguments.out, labels)
    for path, picture in pictures.items():
        made_folder(path.parent)
        # the encoder takes colours with blue first
        write_bytes(path, encode_image(".png", picture[..., ::-1] if picture.ndim == 3 else picture))
    warn(extraction.notes)
    if arguments.quiet:
        return
    pixels = np.bincount(labels.ravel())
    known = np.bincount(labels[frame.known], minlength=pixels.size)
    rows = [
        (str(label), str(pixels[label]), f"{1 - known[label] / pixels[label]:.1%}")
        for label in np.flatnonzero(pixels)
        if label > 0
    ]
    print("\n".join(table(("block", "pixels", "missing"), rows)))
    print(f"\n{len(rows)} blocks cover {np.count_nonzero(labels) / labels.size:.1%} of the frame.")
    print("Written:", ", ".join([arguments.out, *map(str, pictures)]))


def _numbers(text: str) -> frozenset[int]:
    try:
        return frozenset(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no list of block numbers, as in 3,7,12") from None


def _kept(present: NDArray[np.int32], chosen: Collection[int] | None) -> frozenset[int]:
    """The blocks of a label map that stay: the chosen ones, or all."""
    there = frozenset(np.unique(present).tolist()) - {0}
    if chosen is None:
        return there
    if absent := sorted(set(chosen) - there):
        raise InputError(f"There are no blocks {', '.join(map(str, absent))} to keep in the label map.")
    return frozenset(chosen)
