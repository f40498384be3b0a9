"""Results of a completion: iteration records, outcomes and results of blocks, and the completed frame."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted, grouped
from .blocks import Block, check_labels
from .by_hand import DepthByHand
from .frame import RGBDFrame
from .open3d_images import image_of
from .parameters import BlockParameters, Parameters
from .pictures import html_row, plot_curves, plot_error, plot_row
from .pixel_grids import drawn_from

if TYPE_CHECKING:
    from ..run.options import ExportOptions
    from ..run.run import Run
    from ..run.writing import Written

# Equality of records that may hold NaN.


class NanEqual:
    """Base of dataclasses, declared with eq=False, in which NaN (no value) equals NaN."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return _values(self) == _values(other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(_values(self))


def _values(record: Any) -> tuple[object, ...]:
    """Return a record's values, None for NaN."""
    values = (getattr(record, field.name) for field in dataclasses.fields(record))
    return tuple(None if value != value else value for value in values)


# The record of one iteration, the quantities of its curves, and the hold-out pixels.

_SEED = 0


@dataclass(frozen=True, slots=True, eq=False)
class IterationRecord(NanEqual):
    """Record of one iteration of any filter. NaN equals NaN when records are compared.

    Attributes
    ----------
    i : int
        Number of the iteration, from 1.
    stage : int
        Number of the stage, from 1: iterations with the same pass band or weights; later stages pass more.
    sigma_i : float
        Deviation between P_i and P_(i-1) over the block [m], Eq. (2).
    l1 : float
        L1 norm of P_i over the block [m]: the sum of its absolute values.
    residual : float
        Root mean square of P_i - raw [m] over the block's known pixels that the iteration uses; NaN if there are
        none.
    held_out : float
        The same over the known pixels that are held out; NaN if there are none. Its minimum shows where noise begins
        to enter as the band grows, which sigma_i does not show.
    seconds : float
        Time since the block's iteration was set up [s].
    error : float
        Root mean square of P_i - ground truth [m] over the block's pixels without known depth, where the frame's ground
        truth is known (`RGBDFrame.ground_truth`); NaN if there are none. The iteration does not use it.
    """

    i: int
    stage: int
    sigma_i: float
    l1: float
    residual: float
    held_out: float
    seconds: float
    error: float = field(default=math.nan, kw_only=True)


def hold_out_mask(known: NDArray[np.bool_], share: float) -> NDArray[np.bool_]:
    """Select known pixels to hold out of a block's iteration: always the same ones for the same block.

    Parameters
    ----------
    known : ndarray of bool, shape (h, w)
        The block's known pixels on its bounding box.
    share : float
        Share of them to hold out, below 1: at least one known pixel is not held out.

    Returns
    -------
    ndarray of bool, shape (h, w)
    """
    if share == 0:
        return np.zeros(known.shape, bool)
    return drawn_from(known, np.random.default_rng(_SEED), slice(int(share * np.count_nonzero(known))))


def deviation(current: NDArray[np.floating], previous: NDArray[np.float64]) -> float:
    """Return sigma_i = sqrt(sum (P_i - P_(i-1))^2 / N), Eq. (2), from values at the block's N pixels [m]."""
    difference = current - previous
    return float(np.sqrt(np.mean(difference * difference)))


def l1_norm(values: NDArray[np.float64]) -> float:
    """Return the sum of the absolute values of P_i over the block's pixels [m]."""
    return float(np.sum(np.abs(values)))


History = Sequence[IterationRecord]


class Status(StrEnum):
    """Status of a block after a run."""

    COMPLETED = "completed"
    ITERATION_LIMIT = "iteration limit"
    NOT_RECOVERABLE = "not recoverable"
    NOTHING_MISSING = "nothing missing"


@dataclass(frozen=True, eq=False)
class BlockOutcome(NanEqual):
    """Outcome of one block. NaN equals NaN when outcomes are compared.

    Attributes
    ----------
    label : int
    status : Status
    message : str
        The reason as text; "" if there is none.
    pixels, known, recovered : int
        Pixels of the block, those with raw depth, and those in the depth camera's view that were missing and now have
        depth.
    iterations, stages : int
    sigma_i : float
        Deviation of the last iteration [m], NaN if there was none.
    outside : int
        Pixels of the block outside the depth camera's view. They count as neither missing nor recovered.
    by_hand : int
        Pixels of the block with depth by hand. They count as missing, and as recovered.
    suspect : int
        Known pixels of the block in suspect islands, which were left out of the fill and keep their depth.
    """

    label: int
    status: Status
    message: str
    pixels: Annotated[int, msgspec.Meta(ge=1)]
    known: int
    recovered: int = 0
    iterations: int = 0
    stages: int = 0
    sigma_i: float = math.nan
    outside: int = 0
    by_hand: int = 0
    suspect: int = field(default=0, metadata={"optional": True})

    @property
    def defect_rate(self) -> float:
        """Share of the block's pixels without raw depth in the depth camera's view, 0-1."""
        return 1.0 - (self.known + self.outside) / self.pixels


def blocks_by_message(outcomes: Iterable[BlockOutcome]) -> dict[str, list[int]]:
    """Return message -> labels of the blocks with this message, in their order; blocks without one are omitted."""
    found: dict[str, list[int]] = {}
    for outcome in outcomes:
        if outcome.message:
            found.setdefault(outcome.message, []).append(outcome.label)
    return found


@dataclass(frozen=True, eq=False)
class BlockResult:
    """One block's completed depth, with the data that explains it.

    Attributes
    ----------
    block : Block
        The pixels of the block at the time of the run.
    depth : ndarray of float32
        Depth [m] at the block's pixels in the order of `block.mask`'s True values, NaN = still missing.
    outcome : BlockOutcome
    history : sequence of IterationRecord
    parameters : Parameters
    network : str or None
        SHA-256 of the edge network that was used; None if none was.
    notes : tuple of str
        What the user should know about how the result was computed; empty if all went as requested.
    edges : BlockParameters or None
        Parameters of the edges that the filter used (`edge_parameters`); None for the pass band.
    drawn : ndarray of bool or None
        Which of the block's pixels were marked as at a drawn border, in the order of `block.mask`'s True values
        (`Blocks.drawn_of`); None if none was.
    correction : tuple of str
        SHA-256 of the correction network that was used and, in a sparse frame, of that for sparse depth; empty if none
        was.
    explained : bool
        Whether a smooth surface explains all of the block's known depth, so that a network has nothing to correct.
        Valid only during the run, and not stored.
    by_hand : DepthByHand or None
        Depth by hand at the block's missing pixels, in the order of `block.mask`'s True values; None if there was none.
    """

    block: Block
    depth: NDArray[np.float32]
    outcome: BlockOutcome
    history: History
    parameters: Parameters
    network: str | None = None
    notes: tuple[str, ...] = ()
    edges: BlockParameters | None = None
    drawn: NDArray[np.bool_] | None = None
    correction: tuple[str, ...] = ()
    explained: bool = field(default=False, metadata={"stored": False})
    by_hand: DepthByHand | None = None


@dataclass(frozen=True, eq=False)
class Completion:
    """A frame's completed depth.

    Attributes
    ----------
    run : Run
        All inputs that the depth depends on.
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN where it could not be recovered.
    filled : ndarray of bool, shape (H, W)
        Pixels that had no depth before and have depth now.
    results : dict
        Block label -> BlockResult, in ascending order of labels.
    extrapolated : ndarray of bool, shape (H, W)
        The extrapolated pixels, filled outside of all completed blocks: none without `ilf.extrapolate`.
    notes : tuple of str
        What the user should know about how the result was computed, each sentence once.
    extrapolation_network : str or None
        SHA-256 of the edge network used for extrapolation; None if none was.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> completion = ilf.complete(ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth))
    >>> completion
    <Completion of 'frame': 30 x 20 pixels, 1 block, 40 pixels filled, 0 still missing>
    >>> print(completion.outcomes[1].status, completion.outcomes[1].recovered)
    completed 40
    >>> completion.run
    <Run of 'frame': 30 x 20 pixels, 1 block, best>
    """

    run: Run
    depth: NDArray[np.float32]
    filled: NDArray[np.bool_]
    results: dict[int, BlockResult]
    extrapolated: NDArray[np.bool_]
    notes: tuple[str, ...] = ()
    extrapolation_network: str | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.summary()}>"

    def summary(self) -> str:
        """Return name and size of the frame, and the numbers of filled and still missing pixels, in one line."""
        height, width = self.depth.shape
        masks = self.filled, self.from_neighbours, self.by_hand, self.extrapolated, ~np.isfinite(self.depth)
        filled, from_neighbours, by_hand, extrapolated, left = (int(np.count_nonzero(mask)) for mask in masks)
        counts = {"measured by neighbours": from_neighbours, "by hand": by_hand, "extrapolated": extrapolated}
        parts = ", ".join(f"{grouped(count)} {what}" for what, count in counts.items() if count)
        suspect = f", {grouped(self.suspect)} suspect" if self.suspect else ""
        return (
            f"{self.frame.name!r}: {width} x {height} pixels, {counted(len(self.results), 'block')}, "
            f"{counted(filled, 'pixel')} filled{f' ({parts})' if parts else ''}, "
            f"{grouped(left)} still missing{suspect}"
        )

    def _repr_html_(self) -> str:
        return html_row(self.summary(), self._images())

    def plot(self) -> NDArray[Any]:
        """Plot colour, depth and completed depth by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes
            Axes of the three images; `axes[0].figure` is the figure.

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_row(self._images())

    def _images(self) -> dict[str, NDArray[Any]]:
        return {"Colour": self.frame.rgb, "Depth": self.frame.depth, "Completed depth": self.depth}

    def plot_curves(self, labels: Iterable[int] | None = None) -> NDArray[Any]:
        """Plot sigma_i and the L1 norm, relative to its last value, of the blocks against the iteration by matplotlib.

        Parameters
        ----------
        labels : iterable of int, optional
            The blocks; all that were iterated if left out.

        Returns
        -------
        ndarray of matplotlib.axes.Axes, shape (2,)

        Raises
        ------
        InputError
            If a block was not run, or matplotlib is not installed (extra `plot`).
        """
        chosen = list(self.results if labels is None else labels)
        check_labels(chosen, self.results)
        return plot_curves({label: self.results[label].history for label in chosen})

    def to_open3d(self) -> Any:
        """Return colour and completed depth [m] as `RGBDFrame.to_open3d` does; `frame.open3d_camera()` is the camera.

        Raises
        ------
        ExportError
            If Open3D is not installed (extra `app`).
        """
        return image_of(self.frame.rgb, self.depth)

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
        from ..completion.confidence.expected_error import expected_error

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
        >>> import ilf
        >>> depth = np.full((20, 30), 2.0)
        >>> depth[8:12, 10:20] = np.nan
        >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
        >>> written = ilf.complete(frame).save("done", expected_error=False)
        >>> [path.name for path in written.files], written.notes[0][:26]
        (['depth.png', 'depth.npy', 'blocks.png', 'curves.csv', 'run.json'], 'No point cloud is written,')
        """
        from ..run.writing import save

        return save(folder, self, options, **changes)

    def export(self, path: str | os.PathLike[str]) -> tuple[str, ...]:
        """Write a file of another program, in the format of its extension; return notes on what it does not preserve.

        Parameters
        ----------
        path : path-like
            Depth as .exr (package `OpenEXR`) or .tum.png, blocks as .palette.png, .coco.json or .labelme.json, the
            camera as .camera.json, .opencv.yaml or .camera_info.yaml; .rrd for the viewer Rerun (package `rerun-sdk`);
            or an extension of a plugin. A file of that name is replaced; the folder is created if missing.

        Raises
        ------
        ParameterError
            If no format has this extension.
        InputError
            If the format needs a package that is not installed or a camera that the frame lacks, or its plugin fails.
        ExportError
            If the file is one of the frame's own, or cannot be written. An existing file is unchanged then.
        """
        from ..run.writing import export

        return export(path, self)

    @property
    def frame(self) -> RGBDFrame:
        """The frame before completion."""
        return self.run.frame

    @property
    def blocks(self) -> NDArray[np.int32]:
        """Label map of the blocks that were run, int32, shape (H, W), 0 = no block."""
        labels = np.zeros(self.depth.shape, np.int32)
        for label, result in self.results.items():
            labels[result.block.box][result.block.mask] = label
        return labels

    @property
    def filled_by_blocks(self) -> NDArray[np.bool_]:
        """The filled pixels without the extrapolated ones, bool, shape (H, W)."""
        return self.filled & ~self.extrapolated

    @property
    def from_neighbours(self) -> NDArray[np.bool_]:
        """The filled pixels that neighbours of the frame have measured, bool, shape (H, W)."""
        added = self.frame.from_neighbours
        return np.zeros(self.depth.shape, bool) if added is None else added

    @property
    def by_hand(self) -> NDArray[np.bool_]:
        """The filled pixels whose depth the user has stated (`DepthByHand`), bool, shape (H, W)."""
        stated = np.zeros(self.depth.shape, bool)
        for result in self.results.values():
            if result.by_hand is not None:
                stated[result.block.box][result.block.mask] = result.by_hand.pixels
        return stated & self.filled

    @property
    def suspect(self) -> int:
        """Number of known pixels in suspect islands that were left out of the fill: small, surrounded by missing depth
        and far off everything near by. They keep their depth."""
        return sum(outcome.suspect for outcome in self.outcomes.values())

    @property
    def history(self) -> dict[int, History]:
        """Block label -> records of all iterations."""
        return {label: result.history for label, result in self.results.items()}

    @property
    def outcomes(self) -> dict[int, BlockOutcome]:
        """Block label -> outcome of the block."""
        return {label: result.outcome for label, result in self.results.items()}


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a run: the record of an iteration, the result of a finished block, or a step outside of blocks.

    Attributes
    ----------
    label : int
        The block; 0 for a step outside of blocks.
    record : IterationRecord or None
        Its iteration, such as `record.i` and `record.sigma_i` [m]. With more than one thread, blocks that run at the
        same time report theirs in turn.
    result : BlockResult or None
        Its result, once it is finished; `result.outcome` has its status.
    """

    label: int
    record: IterationRecord | None = None
    result: BlockResult | None = None


NO_BLOCK = Step(0)
"""A step outside of blocks: it shows that the run has advanced, and allows leaving it."""


def compose(run: Run, results: Mapping[int, BlockResult], base: Completion | None = None) -> Completion:
    """Insert results of a run's blocks into its frame's depth; pixels outside of blocks keep their raw depth.

    With `base`, a completion of the same frame without extrapolation, only differing results are inserted.
    """
    frame = run.frame
    former = {} if base is None else base.results
    depth = (frame.depth if base is None else base.depth).copy()
    for label, result in former.items():
        if results.get(label) is not result:
            box, mask = result.block.box, result.block.mask
            depth[box][mask] = frame.depth[box][mask]
    for label, result in results.items():
        if former.get(label) is not result:
            depth[result.block.box][result.block.mask] = result.depth
    filled = ~frame.own & np.isfinite(depth)
    in_order = dict(sorted(results.items()))
    return Completion(run, depth, filled, in_order, np.zeros_like(filled), notes_of(in_order))


def notes_of(results: Mapping[int, BlockResult]) -> tuple[str, ...]:
    """Return the notes of all blocks, each sentence once."""
    return tuple(dict.fromkeys(note for result in results.values() for note in result.notes))


# The record of one iteration in a pass band.


@dataclass(frozen=True, slots=True, eq=False)
class PassBandRecord(IterationRecord):
    """Record of one iteration of the ideal low-pass filter. A stage is one pass band.

    Attributes
    ----------
    radii : tuple of float
        Cut-off radii (r_y, r_x) of this iteration, in cycles per padded grid.
    weighted : bool
        Whether the colour spectrum weighted this iteration.
    """

    radii: tuple[float, float]
    weighted: bool


# The record of one iteration of the edge-aware filter.


@dataclass(frozen=True, slots=True, eq=False)
class EdgeAwareRecord(IterationRecord):
    """Record of one iteration of the edge-aware filter. A stage is one grid, or one round on the finest grid.

    Attributes
    ----------
    cell : int
        Cell size of the grid that the iteration used [px]; 1 on the finest.
    round : int
        Number of the round in which jumps are cut, from 1; 0 before the first.
    """

    cell: int
    round: int
