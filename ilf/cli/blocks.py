"""`ilf blocks`: the label map of a frame, and pictures of how it comes about."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ..drawing.block_pictures import stage_pictures
from ..ebs import extract
from ..io import write_labels
from ..io.atomic import write_bytes
from ..io.folders import made_folder
from ..io.images import encode_image
from ..parameters import BlockParameters
from ..run.export import check_not_an_input
from .comparison import warn
from .parsing import Commands, add_block_parameters, add_frame, frame_from, with_given
from .report import table


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
    extraction = extract(frame, parameters)
    labels = extraction.blocks
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
        (str(label), str(pixels[label]), f"{1 - known[label] / pixels[label]:.1%}") for label in range(1, pixels.size)
    ]
    print("\n".join(table(("block", "pixels", "missing"), rows)))
    print(f"\n{len(rows)} blocks cover {np.count_nonzero(labels) / labels.size:.1%} of the frame.")
    print("Written:", ", ".join([arguments.out, *map(str, pictures)]))
