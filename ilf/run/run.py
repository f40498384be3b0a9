"""A run: made of a frame, carried out step by step, and its completion, which is written."""

from __future__ import annotations

import inspect
import os
from collections import defaultdict
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from numpy.typing import ArrayLike

from ..completion.block import Watch
from ..completion.completion import CompletionRun
from ..completion.extrapolation import guess_steps
from ..data.declarations import ParameterSet, Value, check_names
from ..data.frame import RGBDFrame, checked_frame
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters, as_extraction, as_parameters, by_set, preset
from ..data.results import Completion, IterationRecord, Progress, compose
from ..errors import InputError, ParameterError
from ..io.block_files import read_blocks
from ..io.labels import LoadedBlocks, read_mask
from ..segmentation.extraction import forget_stages, found_blocks
from ..segmentation.reextraction import gaps_filled
from .options import ExportOptions, without_impossible_cloud
from .setup import RunSetup
from .writing import Written, write

GUESS = 0
"""What stands for a block's label in the `Progress` of the guess."""


@dataclass(frozen=True, eq=False)
class Run(RunSetup):
    """All that a run is made of; its results follow from it alone.

    Parameters
    ----------
    frame : RGBDFrame
        With its inputs, if it was read from files, its distrusted depth and its guide.
    blocks : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    parameters : Parameters or str
        Of all blocks but those that have their own, or the name of a preset; the preset "best" if left out. `Run.of`
        takes them by keyword.
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
    >>> run = ilf.Run.of(ilf.load_frame(asset_path("samples/room")), max_iterations=20)
    >>> completion = run.complete()
    >>> completion.filled.any()
    np.True_
    """

    @classmethod
    def of(
        cls,
        frame: RGBDFrame,
        blocks: ArrayLike | None = None,
        preset: Parameters | str | None = None,
        *,
        own: Mapping[int, Parameters | str] | None = None,
        extraction: BlockParameters | None = None,
        dense: bool = False,
        drawn: ArrayLike | None = None,
        guide: ArrayLike | Guide | None = None,
        **changes: Value,
    ) -> Self:
        """The run that `ilf.complete` makes of the same arguments."""
        if isinstance(blocks, str | ParameterSet):
            raise ParameterError(
                f"The second argument is the label map of the blocks, not {blocks!r:.60}: give presets and parameters "
                "of the filter as preset=, those of the extraction as extraction=."
            )
        of_filter, of_blocks = by_set(changes, *inspect.signature(complete).parameters)
        given: dict[str, Any] = {"parameters": as_parameters(preset, **of_filter), "dense": dense, "drawn": drawn}
        if own is not None:
            given["own"] = own
        guided = checked_frame(frame) if guide is None else checked_frame(frame).with_guide(guide)
        if blocks is None:
            chosen = as_extraction(extraction, **of_blocks)
            found = found_blocks(guided, chosen)
            given |= {"blocks": found.blocks, "network": found.network, "notes": found.notes}
            return cls(guided, extraction=chosen, **given)
        if of_blocks:
            raise ParameterError(
                f"{', '.join(of_blocks)} would have no effect, because blocks are given: extract them with it by "
                "ilf.extract_blocks."
            )
        given |= {"blocks": blocks, "edited": True}
        return cls(guided, extraction=extraction, **given)

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
    ) -> CompletedRun:
        """Run to the end.

        Parameters
        ----------
        on_progress : callable, optional
            Called with every `Progress`; what it raises stops the run.
        threads : int, optional
            As in `steps`.

        Returns
        -------
        CompletedRun
            Blocks without enough known depth are reported in its `outcomes` and stay missing, unless the run is dense.
        """
        with self.steps(threads) as steps:
            for progress in steps:
                if on_progress is not None:
                    on_progress(progress)
        return steps.completion()


@dataclass(frozen=True, eq=False, repr=False)
class CompletedRun(Completion):
    """A frame's completed depth, and the run that it came of.

    Attributes
    ----------
    run : Run
        All that the depth follows from.

    See Also
    --------
    Completion : has `depth`, `filled`, `blocks`, `outcomes`, `notes` and all else.
    """

    run: Run = field(kw_only=True)

    @classmethod
    def of(cls, completion: Completion, run: Run) -> Self:
        """A completion with its run, and with what there is to know of that."""
        values = {known.name: getattr(completion, known.name) for known in fields(Completion)}
        notes = tuple(dict.fromkeys((*run.notes, *completion.notes)))
        return cls(**values | {"notes": notes}, run=run)

    def save(self, folder: str | os.PathLike[str], options: ExportOptions | None = None, **changes: Any) -> Written:
        """Write the files that `ilf complete` writes: depth, expected error, blocks, curves, point cloud, run record.

        Parameters
        ----------
        folder : path-like
            Made if it is not there. Files of the same names in it are replaced, others are left alone.
        options : ExportOptions, optional
            Which files are written, and how; those of `ilf complete` if left out.
        **changes
            Any of the options by name, such as `mesh="glb"`.

        Returns
        -------
        Written
            The files, and notes of what was lost or left out on the way into them.

        Raises
        ------
        ParameterError
            For an unknown option, or a value that it cannot have.
        InputError
            If a cloud or a mesh is asked for and the frame has no intrinsics. Nothing is written then.
        ExportError
            If a file would replace one of the frame's own, or cannot be written. The folder is as it was then.

        Examples
        --------
        >>> import numpy as np, ilf
        >>> depth = np.full((20, 30), 2.0)
        >>> depth[8:12, 10:20] = np.nan
        >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
        >>> written = ilf.complete(frame).save("done", expected_error=False)
        >>> [path.name for path in written.files], written.notes[0][:26]
        (['depth.png', 'depth.npy', 'blocks.png', 'curves.csv', 'run.json'], 'No point cloud is written,')
        """
        check_names(changes, [known.name for known in fields(ExportOptions)])
        chosen, notes = replace(options or ExportOptions(), **changes), tuple[str, ...]()
        if options is None and "cloud" not in changes:
            chosen, notes = without_impossible_cloud(chosen, self.frame, ": make the frame with intrinsics=")
        written = write(folder, self.run, self, chosen)
        return replace(written, notes=(*notes, *written.notes))


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

    def completion(self) -> CompletedRun:
        """The frame's depth as far as it has come."""
        return CompletedRun.of(self._dense or compose(self._run.frame, self.results), self._run)

    def _and_guess(self, blocks: Generator[Progress, None, None]) -> Generator[Progress, None, None]:
        yield from blocks
        for record in self._guess():
            yield Progress(GUESS, record=record)

    def _guess(self) -> Generator[IterationRecord, None, None]:
        self._dense = yield from _guessed(self._run, compose(self._run.frame, self.results))


def _guessed(run: Run, completion: Completion) -> Generator[IterationRecord, None, Completion]:
    return guess_steps(completion, run.extraction, run.parameters.outside_view)


# The first call, and the optional last step.


def complete(
    frame: RGBDFrame,
    blocks: ArrayLike | None = None,
    preset: Parameters | str | None = None,
    *,
    own: Mapping[int, Parameters | str] | None = None,
    extraction: BlockParameters | None = None,
    dense: bool = False,
    drawn: ArrayLike | None = None,
    guide: ArrayLike | Guide | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    threads: int | None = None,
    **changes: Value,
) -> CompletedRun:
    """Complete the depth of a frame by iterative low-pass filtering, block by block (section 3).

    Parameters
    ----------
    frame : RGBDFrame
    blocks : array_like of int, shape (H, W), optional
        Label map, 0 = no block; of a mask, bool, all that is True is one block. Extracted from the frame if left out.
    preset : Parameters or str, optional
        Parameters of the filter, or the name of a preset (`ilf.PRESETS`). The default preset, "best", if left out.
    own : mapping of int to Parameters or str, optional
        Block label -> parameters of its own.
    extraction : BlockParameters, optional
        What blocks are extracted with, or were, unless that is the defaults: the filter sees the same edges.
    dense : bool
        Whether the depth that is still missing after the blocks is guessed, as by `ilf.fill_rest`.
    drawn : array_like of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth gets across there. Of a
        block's result, only those of its own pixels decide. The pass band has no use for them, since it sees nothing
        beyond a block.
    guide : array_like or Guide, optional
        Depth or inverse depth of the frame, metric or relative, shape (H, W) or of the same aspect: from a network
        that looks at colour, or another sensor. The frame's own, if it has one, if left out. NaN, infinite and zero
        mean that nothing is said there. The edge-aware filter follows it as far as the known depth bears it out; the
        pass band has no use for it.
    on_progress : callable, optional
        Called with every `Progress`; raise `ilf.Cancelled` in it to stop.
    threads : int, optional
        Blocks that run at the same time; as many as there are cores if left out. The result is the same.
    **changes
        Any of the `Parameters` by name and, where blocks are extracted, any of the `BlockParameters` that has no
        namesake there.

    Returns
    -------
    CompletedRun
        Blocks without enough known depth are reported in `outcomes` and stay missing.

    Raises
    ------
    InputError
        If label map or drawn borders do not fit the frame.
    ParameterError
        For an unknown preset or parameter, a value out of range, a parameter that has no effect beside the others, or
        what are no parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> ilf.complete(frame)
    <CompletedRun of 'frame': 30 x 20 pixels, 1 block, 40 pixels filled, 0 still missing>
    >>> result = ilf.complete(frame, np.ones((20, 30), np.int32), "paper", max_iterations=50)
    >>> round(float(result.depth[10, 15]), 3), result.outcomes[1].iterations
    (2.0, 24)
    """
    run = Run.of(
        frame, blocks, preset, own=own, extraction=extraction, dense=dense, drawn=drawn, guide=guide, **changes
    )
    return run.complete(on_progress=on_progress, threads=threads)


def fill_rest(completion: CompletedRun) -> CompletedRun:
    """Guess the depth that is still missing: between blocks, in their margin, and in blocks too poor in data.

    The frame as it is completed so far is taken for one block whose surfaces end at edges. Nothing vouches for the
    result: it is for programs that cannot do with gaps. `ilf.complete` with `dense=True` gives the same.

    Parameters
    ----------
    completion : CompletedRun

    Returns
    -------
    CompletedRun
        Without missing pixels, but for those outside the depth camera's view unless the run's parameters ask for them;
        `guessed` says which ones this step has filled. What was there before is as it was.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[5:9, 5:9] = 0
    >>> frame = ilf.RGBDFrame(rgb=np.zeros((20, 30, 3), np.uint8), depth=depth)
    >>> nothing_run = ilf.complete(frame, np.zeros((20, 30), int))
    >>> int(ilf.fill_rest(nothing_run).guessed.sum())
    16
    """
    steps = _guessed(completion.run, completion)
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return CompletedRun.of(end.value, replace(completion.run, dense=True))


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
