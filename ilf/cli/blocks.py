"""`ilf blocks`: write the label map of a frame, and images of the stages of its extraction."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from .._runtime.formatting import covered
from .._runtime.writing import ensure_folder, write_bytes
from ..data.blocks import Blocks, check_labels, labels_in
from ..data.frame import RGBDFrame
from ..drawing.blocks import stage_pictures
from ..io.block_files import BLOCK_FORMATS, read_blocks, write_blocks
from ..io.images import encode_image
from ..run.writing import check_not_an_input
from ..segmentation.extraction import extract
from ..segmentation.reextraction import gaps_filled
from .output import Column, table, warn
from .parsing import add_block_parameters, add_frame, add_given_blocks, add_shared, extraction_from, frame_from
from .usage import Parser, UsageError, declare


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = "ilf blocks (RGB DEPTH | FOLDER) --out FILE [options]"
    parser.description = (
        "Extract boundaries and surfaces (EBS), or read blocks of another program, and write the blocks as a label map "
        "(16-bit PNG, 0 = no block), COCO or labelme JSON. `ilf complete --blocks` reads all these formats."
    )
    add_frame(parser, companions=False)
    add_shared(parser, "--invalid-mask")
    taken = parser.add_argument_group("existing blocks")
    add_given_blocks(taken, "--from")
    declare(taken, "--keep N,N,...  with --from: keep only these blocks (default: all)")
    output = parser.add_argument_group("output")
    declared = f"""
        --out FILE    required: output file, .png or .json
        --format {"|".join(BLOCK_FORMATS)}  format of the output file (default: png for .png, coco for .json); COCO and
            labelme include names; all formats are exact to the pixel
        --stages DIR  folder for images of all stages of the extraction
    """
    declare(output, declared)
    add_shared(output, "--quiet")
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    parameters = extraction_from(arguments, "--from")
    extracts = arguments.blocks is None or arguments.fill_gaps
    if arguments.stages is not None and not extracts:
        raise UsageError("With --from nothing is extracted: leave out --stages, or add --fill-gaps.")
    frame = frame_from(arguments)
    image = None if frame.inputs is None else frame.inputs.rgb.path
    blocks = Blocks(np.zeros(frame.shape, np.int32))
    if arguments.blocks is not None:
        blocks = read_blocks(arguments.blocks, frame.shape, image=image)
    if arguments.keep is not None:
        blocks = _only(blocks, arguments.keep)
    pictures = {}
    if extracts:
        blocks = gaps_filled(blocks, frame, parameters)
        if arguments.stages is not None:
            folder = Path(arguments.stages)
            stages = stage_pictures(frame.rgb, extract(frame, parameters)).items()
            pictures = {folder / f"{number}-{name}.png": picture for number, (name, picture) in enumerate(stages, 1)}
    check_not_an_input(frame, [Path(arguments.out), *pictures])
    write_blocks(arguments.out, blocks.labels, format=arguments.format, names=blocks.names, image=image)
    for path, picture in pictures.items():
        ensure_folder(path.parent)
        # the encoder expects blue first
        write_bytes(path, encode_image(".png", picture[..., ::-1] if picture.ndim == 3 else picture))
    warn(blocks.notes)
    if not arguments.quiet:
        print("\n".join(_report(blocks, frame)))
        print("Written:", ", ".join([arguments.out, *map(str, pictures)]))


def _report(blocks: Blocks, frame: RGBDFrame) -> list[str]:
    """Format a table of the blocks, and their coverage."""
    pixels = np.bincount(blocks.labels.ravel())
    missing = np.bincount(blocks.labels[frame.missing], minlength=pixels.size)
    columns = [
        Column("block", int),
        Column("pixels", lambda label: int(pixels[label])),
        Column("missing", lambda label: missing[label] / pixels[label], ".1%"),
    ]
    if blocks.names:
        columns.append(Column("name", lambda label: blocks.names.get(label, "")))
    labels = [label for label in np.flatnonzero(pixels).tolist() if label > 0]
    share = np.count_nonzero(blocks.labels) / blocks.labels.size
    return [*table(columns, labels), "", f"{covered(len(labels), share)}."]


def _only(found: Blocks, chosen: Collection[int]) -> Blocks:
    """Return the selected blocks; raises InputError if there is no such one."""
    check_labels(sorted(chosen), labels_in(found.labels))
    labels = np.where(np.isin(found.labels, list(chosen)), found.labels, 0).astype(np.int32)
    return replace(found, labels=labels, infos={label: found.infos[label] for label in chosen if label in found.infos})
