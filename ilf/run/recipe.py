"""How runs are made of frames, whichever: parameters, and the blocks that are given or extracted."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..ebs import forget_stages, found_blocks
from ..ebs.gaps import gaps_filled
from ..errors import InputError
from ..frame import RGBDFrame
from ..io import LoadedBlocks, read_blocks
from ..io.label_files import read_mask
from ..parameters import BlockParameters, Parameters, as_parameters, preset
from .run import Run


@dataclass(frozen=True)
class Recipe:
    """All that makes a `Run` of a frame.

    Parameters
    ----------
    parameters : Parameters or str
        Or the name of a preset; the preset "best" if left out.
    extraction : BlockParameters
        The defaults if left out.
    dense : bool
        Whether the depth that is still missing after the blocks is guessed.
    blocks : str, optional
        Path of blocks that are taken as they are (`ilf.io.read_blocks`); they are extracted if left out.
    fill_gaps : bool
        Whether blocks are extracted where none is given.
    drawn : str, optional
        Path of the mask of pixels whose border was drawn by hand.
    """

    parameters: Parameters = field(default_factory=preset)
    extraction: BlockParameters = field(default_factory=BlockParameters)
    dense: bool = False
    blocks: str | None = None
    fill_gaps: bool = False
    drawn: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", as_parameters(self.parameters))

    def run_of(self, frame: RGBDFrame) -> Run:
        """The run of a frame. What only other extractions of it would need is not remembered.

        Raises
        ------
        InputError
            If a file that is named cannot be read or does not fit the frame, or there are no blocks.
        """
        given = self._given(frame)
        drawn = None if self.drawn is None else read_mask(self.drawn, frame.shape)
        if given is None or self.fill_gaps:
            found = found_blocks(frame, self.extraction)
            forget_stages(frame)
            run = Run(
                frame,
                found.blocks if given is None else gaps_filled(given.labels, found.blocks, self.extraction),
                self.parameters,
                dense=self.dense,
                extraction=self.extraction,
                edited=self.fill_gaps,
                network=found.network,
                notes=found.notes if given is None else given.notes + found.notes,
                drawn=drawn,
            )
            way_out = "Lower min_size or min_known_share of the extraction, or give blocks."
        else:
            run = Run(frame, given.labels, self.parameters, dense=self.dense, notes=given.notes, drawn=drawn)
            way_out = f"{self.blocks} holds none: give a file with blocks, or have its gaps filled."
        if not run.blocks.any():
            raise InputError(f"There are no blocks, so there is nothing to complete. {way_out}")
        return run

    def _given(self, frame: RGBDFrame) -> LoadedBlocks | None:
        if self.blocks is None:
            return None
        return read_blocks(self.blocks, frame.shape, image=None if frame.inputs is None else frame.inputs.rgb.path)
