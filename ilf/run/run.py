"""What a run is made of: the one bundle that is run, recorded, replayed and written."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..completion.block import Watch
from ..completion.completion import CompletionRun
from ..completion.extrapolation import guess_steps
from ..data.blocks import checked_drawn, checked_labels
from ..data.frame import RGBDFrame, checked_frame, fixed
from ..data.parameters import BlockParameters, Parameters, as_parameters, preset
from ..data.results import Completion, IterationRecord, Progress, compose
from ..errors import InputError
from ..io.block_files import read_blocks
from ..io.labels import LoadedBlocks, read_mask
from ..segmentation.extraction import forget_stages, found_blocks
from ..segmentation.reextraction import gaps_filled

GUESS = 0
"""What stands for a block's label in the `Progress` of the guess."""


@dataclass(frozen=True, eq=False)
class Run:
    """All that a run is made of; its results follow from it alone.

    Parameters
    ----------
    frame : RGBDFrame
        With its inputs, if it was read from files, its distrusted depth and its guide.
    blocks : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    parameters : Parameters or str
        Of all blocks but those that have their own, or the name of a preset; the preset "best" if left out.
    own : mapping of int to Parameters or str
        Block label -> parameters of its own.
    only : collection of int, optional
        Just these blocks are run; in the order of a sequence, if they run one after the other.
    dense : bool
        Whether the depth that is still missing after the blocks is guessed (`ilf.fill_rest`).
    extraction : BlockParameters, optional
        What the blocks were extracted with; None if they were not.
    edited : bool
        Whether the blocks are not, or no longer, what the extraction gives.
    network : str, optional
        SHA-256 of the edge network that the blocks were extracted with; None if it had no part in it.
    notes : tuple of str
        What the user should know of how all this came about, a sentence each.
    drawn : ndarray of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth gets across there. None
        if no pixel is.

    Raises
    ------
    InputError
        If the label map or the mask of drawn borders does not fit the frame.
    ParameterError
        For an unknown preset, or what are no parameters.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> import ilf
    >>> run = ilf.Run.extracted(ilf.load_frame(asset_path("samples/room")))
    >>> completion = run.complete()
    >>> completion.filled.any()
    np.True_
    """

    frame: RGBDFrame
    blocks: NDArray[np.int32]
    parameters: Parameters = field(default_factory=preset)
    own: Mapping[int, Parameters] = field(default_factory=dict)
    only: Collection[int] | None = None
    dense: bool = False
    extraction: BlockParameters | None = None
    edited: bool = False
    network: str | None = None
    notes: tuple[str, ...] = ()
    drawn: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "blocks", fixed(checked_labels(self.blocks, checked_frame(self.frame).shape)))
        object.__setattr__(self, "drawn", checked_drawn(self.drawn, self.frame.shape))
        object.__setattr__(self, "parameters", as_parameters(self.parameters))
        own = {label: as_parameters(parameters) for label, parameters in self.own.items()}
        object.__setattr__(self, "own", MappingProxyType(own))
        object.__setattr__(self, "edited", self.edited or self.extraction is None)

    @classmethod
    def extracted(
        cls,
        frame: RGBDFrame,
        extraction: BlockParameters | None = None,
        parameters: Parameters | str | None = None,
        *,
        dense: bool = False,
    ) -> Self:
        """A run over the blocks that EBS finds in a frame.

        Parameters
        ----------
        frame : RGBDFrame
        extraction : BlockParameters, optional
            The defaults if left out.
        parameters : Parameters or str, optional
            Or the name of a preset; the preset "best" if left out.
        dense : bool
        """
        chosen = extraction or BlockParameters()
        found = found_blocks(frame, chosen)
        return cls(
            frame,
            found.blocks,
            as_parameters(parameters),
            dense=dense,
            extraction=chosen,
            network=found.network,
            notes=found.notes,
        )

    def parameters_of(self, label: int) -> Parameters:
        """Parameters of a block."""
        return self.own.get(label, self.parameters)

    def steps(self, threads: int | None = None, watch: Watch | None = None) -> RunSteps:
        """The run, step by step, for those who show it or may stop it.

        Parameters
        ----------
        threads : int, optional
            Blocks that run at the same time; as many as there are cores if left out. The result is the same.
        watch : callable, optional
            Called after every iteration of a block, in the thread that made it; see `CompletionRun`.
        """
        return RunSteps(self, threads, watch)

    def complete(
        self, *, on_progress: Callable[[Progress], None] | None = None, threads: int | None = None
    ) -> Completion:
        """Run to the end.

        Parameters
        ----------
        on_progress : callable, optional
            Called with every `Progress`; what it raises stops the run.
        threads : int, optional
            As in `steps`.

        Returns
        -------
        Completion
            Blocks without enough known depth are reported in its `outcomes` and stay missing, unless the run is dense.
        """
        with self.steps(threads) as steps:
            for progress in steps:
                if on_progress is not None:
                    on_progress(progress)
        return steps.completion()


class RunSteps(CompletionRun):
    """All steps of a run: those of its blocks, then those of the guess if it is dense.

    Parameters
    ----------
    run : Run
    threads : int, optional
    watch : callable, optional
        As for `ilf.completion.completion.CompletionRun`.
    """

    def __init__(self, run: Run, threads: int | None = None, watch: Watch | None = None) -> None:
        choice = defaultdict(lambda: run.parameters, run.own)
        super().__init__(run.frame, run.blocks, choice, run.only, threads, run.extraction, run.drawn, watch)
        self._run = run
        self._dense: Completion | None = None
        if run.dense:
            self._steps = self._and_guess(self._steps)

    def completion(self) -> Completion:
        """The frame's depth as far as it has come."""
        return self._dense or compose(self._run.frame, self.results)

    def _and_guess(self, blocks: Generator[Progress, None, None]) -> Generator[Progress, None, None]:
        yield from blocks
        for record in self._guess():
            yield Progress(GUESS, record=record)

    def _guess(self) -> Generator[IterationRecord, None, None]:
        self._dense = yield from guess_steps(
            self._run.frame, self.completion(), self._run.extraction, self._run.parameters.outside_view
        )


# How runs are made of frames, whichever: parameters, and the blocks that are given or extracted.


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
