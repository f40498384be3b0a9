"""Blocks from files, as they would be taken, and to files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gui.state.session import Session
from ilf.ebs import found_blocks
from ilf.ebs.gaps import gaps_filled
from ilf.frame import RGBDFrame
from ilf.io import LoadedBlocks, read_blocks, write_blocks
from ilf.parameters import BlockParameters
from ilf.run import check_not_an_input


@dataclass(frozen=True)
class BlockSource:
    """Blocks of a file or folder for a frame; with `filling`, an extraction with these parameters fills their gaps."""

    frame: RGBDFrame
    path: str
    filling: BlockParameters | None = None


def blocks_from(source: BlockSource) -> LoadedBlocks:
    """Read the blocks, and fill their gaps if that is asked for; raises InputError as `read_blocks` does."""
    frame, filling = source.frame, source.filling
    blocks = read_blocks(source.path, frame.shape, image=_colour_file(frame))
    if filling is None:
        return blocks
    found = found_blocks(frame, filling)
    return LoadedBlocks(gaps_filled(blocks.labels, found.blocks, filling), blocks.names, blocks.notes + found.notes)


def save_blocks(path: Path, session: Session, format: str | None) -> None:
    """Write a frame's blocks, with the names that were given to them; raises ExportError as `write_blocks` does."""
    check_not_an_input(session.frame, [path])
    given = {label: info.name for label, info in session.infos.items() if info.name != f"Block {label}"}
    write_blocks(path, session.labels, format=format, names=given, image=_colour_file(session.frame))


def _colour_file(frame: RGBDFrame) -> str | None:
    return None if frame.inputs is None else frame.inputs.rgb.path
