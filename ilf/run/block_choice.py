"""How frames get their blocks: extracted, or read from files."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ..data.blocks import Blocks, as_blocks, labels_in
from ..data.by_hand import USUAL_WEIGHT
from ..data.frame import RGBDFrame
from ..data.parameters import BlockParameters
from ..errors import InputError
from ..io.block_files import read_blocks
from ..io.frame_additions import load_by_hand
from ..io.labels import read_mask
from ..segmentation.extraction import clear_stage_cache, found_blocks
from ..segmentation.reextraction import fill_around


@dataclass(frozen=True)
class BlockChoice:
    """The choice of blocks for any frame.

    Parameters
    ----------
    extraction : BlockParameters
        The defaults if left out.
    file : str, optional
        Path of existing blocks (`ilf.io.block_files.read_blocks`); they are extracted if left out.
    fill_gaps : bool
        Whether blocks are extracted where the file has none.
    drawn : str, optional
        Path of the mask of pixels whose border was drawn by hand.
    by_hand : str, optional
        Path of depth by hand, in the encoding of the frame's depth or, as floating-point numbers, in metres.
    by_hand_weight : float
        Its weight.
    """

    extraction: BlockParameters = field(default_factory=BlockParameters)
    file: str | None = None
    fill_gaps: bool = False
    drawn: str | None = None
    by_hand: str | None = None
    by_hand_weight: float = USUAL_WEIGHT

    @property
    def extracts(self) -> bool:
        """Whether blocks are extracted."""
        return self.file is None or self.fill_gaps

    def blocks_of(self, frame: RGBDFrame) -> Blocks:
        """Read or extract the blocks of a frame. Intermediate results of the extraction are not cached.

        Raises
        ------
        InputError
            If a given file cannot be read or does not fit the frame, or there are no blocks.
        """
        blocks = self._extracted_or_read(frame)
        if not blocks.labels.any():
            remedy = (
                "Lower min_size or min_known_share of the extraction, or give blocks."
                if self.extracts
                else f"{self.file} contains none: give a file with blocks, or fill its gaps."
            )
            raise InputError(f"There are no blocks to complete. {remedy}")
        drawn = None if self.drawn is None else read_mask(self.drawn, frame.shape)
        by_hand = None if self.by_hand is None else load_by_hand(self.by_hand, frame, self.by_hand_weight)
        blocks = as_blocks(replace(blocks, drawn=drawn, by_hand=by_hand), frame.shape)
        if blocks.by_hand is not None:
            blocks.by_hand.check_counts(frame, blocks.labels)
        return blocks

    def _extracted_or_read(self, frame: RGBDFrame) -> Blocks:
        if self.file is None:
            blocks = found_blocks(frame, self.extraction)
        else:
            image = None if frame.inputs is None else frame.inputs.rgb.path
            given = read_blocks(self.file, frame.shape, image=image)
            if not self.fill_gaps:
                return given
            blocks = gaps_filled(given, frame, self.extraction)
        clear_stage_cache(frame)
        return blocks


def gaps_filled(given: Blocks, frame: RGBDFrame, extraction: BlockParameters) -> Blocks:
    """Return given blocks of a frame with extracted ones in their gaps; slivers of these below the smallest size of a
    block are merged into a neighbouring new one."""
    found, smallest = found_blocks(frame, extraction), extraction.smallest_block(given.labels.size)
    labels = fill_around(given.labels, labels_in(given.labels), found.labels, smallest)
    return replace(found, labels=labels, infos=given.infos, extracted=None, notes=given.notes + found.notes)
