"""A run: its set-up from a frame, its execution step by step, and its completion."""

from __future__ import annotations

import inspect
import os
from collections import defaultdict
from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.formatting import counted
from ..completion.block import Watch
from ..completion.completion import CompletionRun
from ..completion.confidence.expected_error import expected_error
from ..completion.extrapolation import extrapolation_steps
from ..data.by_hand import USUAL_WEIGHT, DepthByHand, as_by_hand, check_counts
from ..data.declarations import ParameterSet, Value, check_names
from ..data.frame import RGBDFrame, checked_frame
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters, nearest_preset
from ..data.pictures import html_row, plot_error, plot_row
from ..data.presets import as_parameters, chosen_parameters, preset
from ..data.results import Completion, IterationRecord, Progress, compose
from ..drawing.blocks import block_overlay
from ..errors import InputError, ParameterError, check_kind
from ..io.block_files import read_blocks
from ..io.frame_additions import load_by_hand
from ..io.labels import LoadedBlocks, read_mask
from ..segmentation.extraction import clear_stage_cache, found_blocks
from ..segmentation.reextraction import with_gaps_filled
from .exporters import Export
from .options import ExportOptions, drop_impossible_cloud
from .setup import RunSetup
from .writing import Written, check_not_an_input, write

EXTRAPOLATED = 0
"""In place of a block's label in the `Progress` of the extrapolation."""


@dataclass(frozen=True, eq=False)
class Run(RunSetup):
    """All inputs of a run; its results depend on nothing else.

    Parameters
    ----------
    frame : RGBDFrame
        Including its inputs, if it was read from files, its invalid mask and its guide.
    blocks : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    parameters : Parameters or str
        Parameters or preset name for all blocks without own parameters; the preset "best" if left out. `Run.of` takes
        them by keyword.
    own : mapping of int to Parameters or str
        Block label -> own parameters.
    only : collection of int, optional
        Run only these blocks; in the order of a sequence if they run one after the other.
    extrapolate : bool
        Whether depth that is still missing after the blocks is extrapolated (`ilf.extrapolate`).
    extraction : BlockParameters, optional
        Parameters of the blocks' extraction; None if they were not extracted.
    edited : bool
        Whether the blocks differ from the result of the extraction.
    network : str, optional
        SHA-256 of the edge network used by the extraction; None for none.
    notes : tuple of str
        Notes for the user on these inputs, one sentence each.
    drawn : ndarray of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth crosses it. None for
        none.
    by_hand : DepthByHand, optional
        Depth by hand. None for none.

    Raises
    ------
    InputError
        If the label map, the mask of drawn borders or depth by hand does not fit the frame.
    ParameterError
        For an unknown preset or an object that is not parameters.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> import ilf
    >>> run = ilf.Run.of(ilf.load_frame(asset_path("samples/room")), max_iterations=20)
    >>> completion = run.complete()
    >>> completion.filled.any()
    np.True_
    """

    if TYPE_CHECKING:  # as in RGBDFrame

        def __init__(
            self,
            frame: RGBDFrame,
            blocks: ArrayLike,
            parameters: Parameters | str = ...,
            own: Mapping[int, Parameters | str] = ...,
            only: Collection[int] | None = None,
            extrapolate: bool = False,
            extraction: BlockParameters | None = None,
            edited: bool = False,
            network: str | None = None,
            notes: tuple[str, ...] = (),
            drawn: ArrayLike | None = None,
            by_hand: ArrayLike | DepthByHand | None = None,
        ) -> None: ...

    @classmethod
    def of(
        cls,
        frame: RGBDFrame,
        blocks: ArrayLike | None = None,
        preset: Parameters | str | os.PathLike[str] | None = None,
        *,
        own: Mapping[int, Parameters | str] | None = None,
        extraction: BlockParameters | None = None,
        extrapolate: bool = False,
        drawn: ArrayLike | None = None,
        guide: ArrayLike | Guide | None = None,
        by_hand: ArrayLike | DepthByHand | None = None,
        **changes: Value,
    ) -> Self:
        """Make the run that `ilf.complete` executes for the same arguments."""
        if isinstance(blocks, str | ParameterSet):
            raise ParameterError(
                f"The second argument is the label map of the blocks, not {blocks!r:.60}: give presets and parameters "
                "of the filter as preset=, those of the extraction as extraction=."
            )
        keywords = inspect.signature(complete).parameters
        parameters, chosen, of_blocks = chosen_parameters(preset, extraction, changes, *keywords)
        given: dict[str, Any] = {
            "parameters": parameters,
            "extrapolate": extrapolate,
            "drawn": drawn,
            "by_hand": as_by_hand(by_hand, checked_frame(frame).shape),
        }
        if own is not None:
            given["own"] = own
        guided = checked_frame(frame) if guide is None else checked_frame(frame).with_guide(guide)
        if blocks is None:
            found = found_blocks(guided, chosen)
            given |= {"blocks": found.blocks, "network": found.network, "notes": found.notes}
            return cls(guided, extraction=chosen, **given)._with_effect()
        if of_blocks:
            raise ParameterError(
                f"{', '.join(of_blocks)} would have no effect, because blocks are given: extract them with it by "
                "ilf.extract_blocks."
            )
        given |= {"blocks": blocks, "edited": True}
        return cls(guided, extraction=extraction, **given)._with_effect()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.summary()}>"

    def summary(self) -> str:
        """Return name and size of the frame, number of blocks and parameters, in one line."""
        height, width = self.frame.shape
        count = np.count_nonzero(np.unique(self.blocks))
        preset = nearest_preset(self.parameters).text(most=3)
        own = f", {counted(len(self.own), 'block')} with own parameters" if self.own else ""
        return f"{self.frame.name!r}: {width} x {height} pixels, {counted(count, 'block')}, {preset}{own}"

    def _repr_html_(self) -> str:
        return html_row(self.summary(), self._images())

    def plot(self) -> NDArray[Any]:
        """Plot colour, blocks and depth by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes, shape (3,)
            `axes[0].figure` is the figure.

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_row(self._images())

    def _images(self) -> dict[str, NDArray[Any]]:
        blocks = block_overlay(self.frame.rgb, self.blocks)
        return {"Colour": self.frame.rgb, "Blocks": blocks, "Depth": self.frame.depth}

    def _with_effect(self) -> Self:
        """Return the run; raise InputError if its depth by hand counts nowhere."""
        check_counts(self.by_hand, self.frame, self.blocks)
        return self

    def steps(self, threads: int | None = None, watch: Watch | None = None) -> RunSteps:
        """Execute the run step by step, for progress and cancellation.

        Parameters
        ----------
        threads : int, optional
            Number of blocks that run at the same time; the number of cores if left out. It does not affect the result.
        watch : callable, optional
            Called after every iteration of a block, in its thread; see `CompletionRun`.
        """
        return RunSteps(self, threads, watch)

    def complete(
        self, *, on_progress: Callable[[Progress], None] | None = None, threads: int | None = None
    ) -> CompletedRun:
        """Run to the end.

        Parameters
        ----------
        on_progress : callable, optional
            Called with every `Progress`; an exception in it stops the run.
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
    """A frame's completed depth, and its run.

    Attributes
    ----------
    run : Run
        All inputs that the depth depends on.

    See Also
    --------
    Completion : has `depth`, `filled`, `blocks`, `outcomes`, `notes` and all other attributes.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), np.full((20, 30), 2.0))
    >>> completion = ilf.complete(frame, preset="paper")
    >>> completion.run
    <Run of 'frame': 30 x 20 pixels, 1 block, paper>
    """

    run: Run = field(kw_only=True)

    @classmethod
    def of(cls, completion: Completion, run: Run) -> Self:
        """Combine a completion with its run and the run's notes."""
        values = {known.name: getattr(completion, known.name) for known in fields(Completion)}
        notes = tuple(dict.fromkeys((*run.notes, *completion.notes)))
        return cls(**values | {"notes": notes}, run=run)

    def plot_error(self) -> NDArray[Any]:
        """Plot colour and the expected error of the filled pixels by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes, shape (2,)

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_error(self.frame.rgb, expected_error(self))

    def save(self, folder: str | os.PathLike[str], options: ExportOptions | None = None, **changes: Any) -> Written:
        """Write the files that `ilf complete` writes: depth, expected error, blocks, curves, point cloud, run record.

        Parameters
        ----------
        folder : path-like
            Created if missing. Files of the same names in it are replaced, others are not changed.
        options : ExportOptions, optional
            The files and their formats; those of `ilf complete` if left out.
        **changes
            Any of the options, by name, such as `mesh="glb"`.

        Returns
        -------
        Written
            The files, and notes on information that they do not preserve.

        Raises
        ------
        ParameterError
            For an unknown option or an invalid value.
        InputError
            If a cloud or a mesh is selected and the frame has no intrinsics. Nothing is written then.
        ExportError
            If a file would replace one of the frame's own, or cannot be written. The folder is unchanged then.

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
            chosen, notes = drop_impossible_cloud(chosen, self.frame, ": make the frame with intrinsics=")
        written = write(folder, self.run, self, chosen)
        return replace(written, notes=(*notes, *written.notes))

    def export(self, path: str | os.PathLike[str]) -> None:
        """Write a file of another program, in the format of its extension.

        Parameters
        ----------
        path : path-like
            .rrd for the viewer Rerun (package `rerun-sdk`), or an extension of a plugin. A file of that name is
            replaced; the folder is created if missing.

        Raises
        ------
        ParameterError
            If no format has this extension.
        InputError
            If the format needs a package that is not installed, or its plugin fails.
        ExportError
            If the file is one of the frame's own, or cannot be written. An existing file is unchanged then.
        """
        export = Export(path)
        check_not_an_input(self.frame, [export.path])
        export.write(self)


class RunSteps(CompletionRun):
    """All steps of a run: those of its blocks, then those of the extrapolation if it is dense.

    Parameters
    ----------
    run : Run
    threads : int, optional
    watch : callable, optional
        As for `ilf.completion.completion.CompletionRun`.
    """

    def __init__(self, run: Run, threads: int | None = None, watch: Watch | None = None) -> None:
        choice = defaultdict(lambda: run.parameters, run.own)
        by_user = run.drawn, run.by_hand
        super().__init__(run.frame, run.blocks, choice, run.only, threads, run.extraction, *by_user, watch)
        self._run = run
        self._dense: Completion | None = None
        if run.extrapolate:
            self._steps = self._and_extrapolate(self._steps)

    def completion(self) -> CompletedRun:
        """The frame's depth, as far as it is completed."""
        return CompletedRun.of(self._dense or compose(self._run.frame, self.results), self._run)

    def _and_extrapolate(self, blocks: Generator[Progress, None, None]) -> Generator[Progress, None, None]:
        yield from blocks
        for record in self._extrapolation():
            yield Progress(EXTRAPOLATED, record=record)

    def _extrapolation(self) -> Generator[IterationRecord, None, None]:
        self._dense = yield from _extrapolated(self._run, compose(self._run.frame, self.results))


def _extrapolated(run: Run, completion: Completion) -> Generator[IterationRecord, None, Completion]:
    return extrapolation_steps(completion, run.extraction, run.parameters.outside_view)


# `ilf.complete`, and the optional extrapolation.


def complete(
    frame: RGBDFrame,
    blocks: ArrayLike | None = None,
    preset: Parameters | str | os.PathLike[str] | None = None,
    *,
    own: Mapping[int, Parameters | str] | None = None,
    extraction: BlockParameters | None = None,
    extrapolate: bool = False,
    drawn: ArrayLike | None = None,
    guide: ArrayLike | Guide | None = None,
    by_hand: ArrayLike | DepthByHand | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    threads: int | None = None,
    **changes: Value,
) -> CompletedRun:
    """Complete the depth of a frame by iterative low-pass filtering, block by block (section 3).

    Parameters
    ----------
    frame : RGBDFrame
    blocks : array_like of int, shape (H, W), optional
        Label map, 0 = no block; a bool mask is one block. Extracted from the frame if left out.
    preset : Parameters or str, optional
        Parameters of the filter, or a preset by name (`ilf.PRESETS`, or your own) or file, with its parameters of the
        extraction; "best" if left out.
    own : mapping of int to Parameters or str, optional
        Block label -> own parameters.
    extraction : BlockParameters, optional
        Parameters of the blocks' extraction, now or earlier; the defaults if left out. The filter uses the same edges.
    extrapolate : bool
        Whether depth that is still missing after the blocks is extrapolated, as by `ilf.extrapolate`.
    drawn : array_like of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth crosses it. A block's
        result depends only on its own pixels of these. The pass band ignores them, since it sees nothing beyond a
        block.
    guide : array_like or Guide, optional
        Depth or inverse depth of the frame, metric or relative, shape (H, W) or of the same aspect: from a monocular
        depth network or another sensor. The frame's own, if any, if left out. NaN, infinite and zero values are
        ignored. The edge-aware filter follows it as far as the known depth supports it; the pass band ignores it.
    by_hand : array_like or DepthByHand, optional
        Depth [m] that you state, shape (H, W), NaN or 0 = none, as a constraint with a weight. It counts in blocks
        where depth is missing or marked invalid, and lets a block with too little known depth be completed. It never
        counts as measured: the result is filled and unsupported there (`CompletedRun.by_hand`). The pass band treats it
        as known depth.
    on_progress : callable, optional
        Called with every `Progress` (`ilf.data.results`), in this thread: the block's label and the record of an
        iteration, or the block's result. Raise `ilf.Cancelled` in it to stop.
    threads : int, optional
        Number of blocks that run at the same time; the number of cores if left out. It does not affect the result.
    **changes
        Any of the `Parameters`, by name, and, if blocks are extracted, any of the `BlockParameters` with another name.

    Returns
    -------
    CompletedRun
        Blocks without enough known depth are reported in `outcomes` and stay missing.

    Raises
    ------
    InputError
        If label map, drawn borders or depth by hand do not fit the frame, or depth by hand counts nowhere.
    ParameterError
        For an unknown preset or parameter, a value out of range, a parameter without effect in combination with the
        others, or an object that is not parameters.

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
        frame,
        blocks,
        preset,
        own=own,
        extraction=extraction,
        extrapolate=extrapolate,
        drawn=drawn,
        guide=guide,
        by_hand=by_hand,
        **changes,
    )
    return run.complete(on_progress=on_progress, threads=threads)


def extrapolate(completion: CompletedRun) -> CompletedRun:
    """Extrapolate the depth that is still missing: between blocks, in the margin, and in blocks with too little data.

    The completed frame is treated as one block whose surfaces end at edges. The result is unsupported by measurements:
    it is for programs that need dense depth. `ilf.complete` with `extrapolate=True` gives the same.

    Parameters
    ----------
    completion : CompletedRun

    Returns
    -------
    CompletedRun
        Without missing pixels, except those outside the depth camera's view unless the run's parameters include them;
        `extrapolated` is the mask of pixels filled by this step. All other depth is unchanged.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[5:9, 5:9] = 0
    >>> frame = ilf.RGBDFrame(rgb=np.zeros((20, 30, 3), np.uint8), depth=depth)
    >>> nothing_run = ilf.complete(frame, np.zeros((20, 30), int))
    >>> int(ilf.extrapolate(nothing_run).extrapolated.sum())
    16
    """
    check_kind(completion, CompletedRun, "The first argument must be a completion", "give what ilf.complete returns.")
    steps = _extrapolated(completion.run, completion)
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return CompletedRun.of(end.value, replace(completion.run, extrapolate=True))


# Run configurations, independent of a frame: parameters, and given or extracted blocks.


@dataclass(frozen=True)
class RunConfiguration:
    """The configuration that turns a frame into a `Run`.

    Parameters
    ----------
    parameters : Parameters or str
        Parameters or the name of a preset; "best" if left out.
    extraction : BlockParameters
        The defaults if left out.
    extrapolate : bool
        Whether depth that is still missing after the blocks is extrapolated.
    blocks : str, optional
        Path of existing blocks (`ilf.io.read_blocks`); they are extracted if left out.
    fill_gaps : bool
        Whether blocks are extracted where the file has none.
    drawn : str, optional
        Path of the mask of pixels whose border was drawn by hand.
    by_hand : str, optional
        Path of depth by hand, in the encoding of the frame's depth or, as floating-point numbers, in metres.
    by_hand_weight : float
        Its weight.
    """

    parameters: Parameters = field(default_factory=preset)
    extraction: BlockParameters = field(default_factory=BlockParameters)
    extrapolate: bool = False
    blocks: str | None = None
    fill_gaps: bool = False
    drawn: str | None = None
    by_hand: str | None = None
    by_hand_weight: float = USUAL_WEIGHT

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", as_parameters(self.parameters))

    def make_run(self, frame: RGBDFrame) -> Run:
        """Make the run of a frame. Intermediate results of the extraction are not cached.

        Raises
        ------
        InputError
            If a given file cannot be read or does not fit the frame, or there are no blocks.
        """
        given = self._given(frame)
        added: dict[str, Any] = {
            "drawn": None if self.drawn is None else read_mask(self.drawn, frame.shape),
            "by_hand": None if self.by_hand is None else load_by_hand(self.by_hand, frame, self.by_hand_weight),
        }
        if given is None or self.fill_gaps:
            found = found_blocks(frame, self.extraction)
            clear_stage_cache(frame)
            run = Run(
                frame,
                found.blocks if given is None else with_gaps_filled(given.labels, found.blocks, self.extraction),
                self.parameters,
                extrapolate=self.extrapolate,
                extraction=self.extraction,
                edited=self.fill_gaps,
                network=found.network,
                notes=found.notes if given is None else given.notes + found.notes,
                **added,
            )
            remedy = "Lower min_size or min_known_share of the extraction, or give blocks."
        else:
            run = Run(frame, given.labels, self.parameters, extrapolate=self.extrapolate, notes=given.notes, **added)
            remedy = f"{self.blocks} contains none: give a file with blocks, or fill its gaps."
        if not run.blocks.any():
            raise InputError(f"There are no blocks to complete. {remedy}")
        return run._with_effect()

    def _given(self, frame: RGBDFrame) -> LoadedBlocks | None:
        if self.blocks is None:
            return None
        return read_blocks(self.blocks, frame.shape, image=None if frame.inputs is None else frame.inputs.rgb.path)
