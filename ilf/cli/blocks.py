"""`ilf blocks`: the label map of a frame, and pictures of how it comes about."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import made_folder, write_bytes
from .._runtime.formatting import covered
from ..drawing.blocks import stage_pictures
from ..errors import InputError
from ..io.block_files import BLOCK_FORMATS, write_blocks
from ..io.images import encode_image
from ..io.labels import LoadedBlocks
from ..run.writing import check_not_an_input
from ..segmentation.extraction import extract, found_blocks
from .options import add_given_blocks, check_given_blocks, filled, given_blocks
from .output import table, warn
from .parsing import add_block_parameters, add_distrusted, add_frame, frame_from
from .usage import Parser, UsageError


def add_arguments(parser: Parser) -> None:
    """Give the command's parser its arguments."""
    parser.usage = "ilf blocks (RGB DEPTH | FOLDER) --out FILE [options]"
    parser.description = (
        "Extract boundaries and surfaces (EBS), or take blocks from another program, and write them: label "
        "map (16-bit PNG, 0 = no block), COCO or labelme JSON. `ilf complete --blocks` takes them, edited or not."
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_distrusted(parser)
    taken = parser.add_argument_group("blocks that there are")
    add_given_blocks(taken, "--from")
    taken.add_argument("--around", action=_Around, metavar="PATH", help="the same as --from PATH --fill-gaps")
    taken.add_argument(
        "--keep", type=_numbers, metavar="N,N,...", help="only these blocks of them stay (default: all of them)"
    )
    output = parser.add_argument_group("output")
    output.add_argument("--out", metavar="FILE", required=True, help="the blocks, as .png or .json")
    output.add_argument(
        "--format",
        choices=tuple(BLOCK_FORMATS),
        help="format of that file (default: png for .png, coco for .json). COCO and labelme have names, too; all are "
        "exact to the pixel",
    )
    output.add_argument(
        "--stages",
        metavar="DIR",
        help="folder for pictures of every stage of the extraction",
    )
    output.add_argument("--quiet", action="store_true", help="print nothing but errors")
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    parameters = check_given_blocks(arguments, "--from")
    if arguments.keep is not None and arguments.blocks is None:
        raise UsageError("--keep names blocks that are given: name them by --from.")
    extracts = arguments.blocks is None or arguments.fill_gaps
    if arguments.stages is not None and not extracts:
        raise UsageError("With --from nothing is extracted: leave out --stages, or add --fill-gaps.")
    frame = frame_from(arguments)
    found = given_blocks(arguments, frame)
    if arguments.keep is not None:
        found = _only(found, arguments.keep)
    pictures = {}
    if extracts:
        found = filled(found, found_blocks(frame, parameters), parameters)
        if arguments.stages is not None:
            folder = Path(arguments.stages)
            stages = stage_pictures(frame.rgb, extract(frame, parameters)).items()
            pictures = {folder / f"{number}-{name}.png": picture for number, (name, picture) in enumerate(stages, 1)}
    check_not_an_input(frame, [Path(arguments.out), *pictures])
    image = None if frame.inputs is None else frame.inputs.rgb.path
    write_blocks(arguments.out, found.labels, format=arguments.format, names=found.names, image=image)
    for path, picture in pictures.items():
        made_folder(path.parent)
        # the encoder takes colours with blue first
        write_bytes(path, encode_image(".png", picture[..., ::-1] if picture.ndim == 3 else picture))
    warn(found.notes)
    if not arguments.quiet:
        print("\n".join(_report(found, ~frame.missing)))
        print("Written:", ", ".join([arguments.out, *map(str, pictures)]))


class _Around(argparse.Action):
    """Names blocks that stay as they are, while the others are extracted around them."""

    def __call__(self, parser: object, namespace: argparse.Namespace, values: object, option: object = None) -> None:
        namespace.blocks, namespace.fill_gaps = values, True


def _report(found: LoadedBlocks, lacks_nothing: NDArray[np.bool_]) -> list[str]:
    """A table of the blocks, and how much they cover."""
    pixels = np.bincount(found.labels.ravel())
    with_depth = np.bincount(found.labels[lacks_nothing], minlength=pixels.size)
    rows = [
        (str(label), str(pixels[label]), f"{1 - with_depth[label] / pixels[label]:.1%}", found.names.get(label, ""))
        for label in np.flatnonzero(pixels).tolist()
        if label > 0
    ]
    head = "block", "pixels", "missing", "name" if found.names else ""
    share = np.count_nonzero(found.labels) / found.labels.size
    return [*table(head, rows), "", f"{covered(len(rows), share)}."]


def _numbers(text: str) -> frozenset[int]:
    try:
        return frozenset(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no list of block numbers, as in 3,7,12") from None


def _only(found: LoadedBlocks, chosen: Collection[int]) -> LoadedBlocks:
    """The chosen ones of the blocks."""
    if absent := sorted(set(chosen) - set(np.unique(found.labels).tolist())):
        raise InputError(f"There are no blocks {', '.join(map(str, absent))} to keep.")
    labels = np.where(np.isin(found.labels, list(chosen)), found.labels, 0).astype(np.int32)
    return LoadedBlocks(labels, {label: found.names[label] for label in chosen if label in found.names}, found.notes)
