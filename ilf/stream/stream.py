"""`Stream`: completes frames as they come, with blocks, edges and correction that are found aside and carried along."""

from __future__ import annotations

import itertools
import math
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass, replace
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import cancelled_by, short_switches
from ..completion.block import BlockTask, filter_steps
from ..completion.correction import applied_change, needs_correction, unapplied_change
from ..data.blocks import Blocks, find_blocks
from ..data.declarations import Value
from ..data.frame import RGBDFrame, checked_frame
from ..data.parameters import BlockParameters, Parameters
from ..data.presets import chosen_parameters
from ..data.results import BlockResult, Completion, Status, compose
from ..errors import InputError
from ..run.run import Run
from ..segmentation.edges.frame_edges import FrameEdges, edges_for
from ..segmentation.extraction import clear_stage_cache, found_blocks
from .carrying import Carried, Offsets, carry_depth, drop_contradicted, reduced_grey
from .pacing import latest_of

Array = NDArray[np.float32]
P = ParamSpec("P")
T = TypeVar("T")

_REFRESH = 8
"""Blocks and edges are found again after so many frames, and the correction after them, which fades in over as many."""

_REMEMBERED = 1000
"""Number of frames whose latency is remembered."""

_CHANGED, _CHANGED_SHARE = 0.2, 0.5
"""The scene has changed if depth is off by more than the first share at more than the second share of known pixels."""

_NEW_SCENE = "The scene has changed: the stream starts anew with {}."

_CARRIED = "It has too little known depth: its depth is that of the frame before."

# What is found in some frames and carried to the following ones.


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Blocks and edges of a frame.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        The label map, 0 = no block.
    edges : FrameEdges or None
        The filter's edges; None for the pass band, which uses none.
    notes : tuple of str
        Notes for the user.
    """

    labels: NDArray[np.int32]
    edges: FrameEdges | None
    notes: tuple[str, ...]


Change = tuple[Array | None, tuple[str, ...]]
"""Change of log depth by the correction networks, (H, W), and notes; None with a note on why there is none."""


def change_of(frame: RGBDFrame, completed: Array, edges: FrameEdges) -> Change:
    """Run the correction networks on a frame's completed depth [m]."""
    try:
        return unapplied_change(frame, completed, edges), ()
    except InputError as error:
        return None, (f"Depth is not corrected: {error}",)


class Shot:
    """All that is carried from frame to frame while the scene stays the same.

    Parameters
    ----------
    frame : RGBDFrame
        The first frame.
    surroundings : Surroundings
        Its blocks and edges.

    Attributes
    ----------
    frame : RGBDFrame
        The current frame.
    surroundings : Carried of Surroundings
    age : int
        Number of frames since the surroundings were requested.
    change, former_change : Carried of Change, or None
        The latest, and the one before, from which it fades in.
    change_age : int
        Number of frames since the latest change was adopted.
    corrected : Surroundings or None
        Those for which the change was requested last.
    pending : Carried of Future, or None
        What the stream's thread is finding.
    depth : ndarray of float32, shape (H, W), or None
        The latest completed depth without correction [m].
    expected : ndarray of float32, shape (H, W), or None
        Depth [m] expected from the frame before, where no known depth nearby contradicts it; None in the first frame.
    """

    def __init__(self, frame: RGBDFrame, surroundings: Surroundings) -> None:
        self.frame = frame
        self._grey = reduced_grey(frame)
        self.surroundings = self.of_this_frame(surroundings)
        self.age = 0
        self.change: Carried[Change] | None = None
        self.former_change: Carried[Change] | None = None
        self.change_age = 0
        self.corrected: Surroundings | None = None
        self.pending: Carried[Future[Surroundings | Change]] | None = None
        self.depth: Array | None = None
        self.expected: Array | None = None

    def of_this_frame(self, value: T) -> Carried[T]:
        """Something found in the current frame."""
        return Carried(value, Offsets.none(self.frame.shape, self._grey.shape))

    def advance(self, frame: RGBDFrame) -> bool:
        """Carry everything to the next frame; False if that shows another scene, or has another size."""
        if frame.shape != self.frame.shape or self.depth is None:
            return False
        grey = reduced_grey(frame)
        step = Offsets.between(grey, self._grey, frame.shape)
        if step is None:
            return False
        expected = carry_depth(self.depth, step, frame)
        off = np.abs(expected - frame.depth) / frame.depth
        off = off[np.isfinite(off)]
        if off.size and np.mean(off > _CHANGED) > _CHANGED_SHARE:
            return False
        drop_contradicted(expected, frame.depth)
        self.frame, self._grey, self.expected = frame, grey, expected
        self.surroundings = self.surroundings.to_next(step)
        self.change = self.change and self.change.to_next(step)
        self.change_age += 1
        former = self.former_change if self.change_age < _REFRESH else None
        self.former_change = former and former.to_next(step)
        self.pending = self.pending and self.pending.to_next(step)
        self.age += 1
        return True

    def adopt(self, found: Carried[Surroundings | Change]) -> None:
        """Use something newly found."""
        if isinstance(found.value, Surroundings):
            self.surroundings = Carried(found.value, found.offsets)
        else:
            self.former_change, self.change_age = self.change, 0
            self.change = Carried(found.value, found.offsets)

    @property
    def labels(self) -> NDArray[np.int32]:
        """The label map carried to the current frame."""
        return self.surroundings.offsets.nearest(self.surroundings.value.labels)

    def edges(self) -> FrameEdges | None:
        """The filter's edges carried to the current frame."""
        edges, offsets = self.surroundings.value.edges, self.surroundings.offsets
        if edges is None:
            return None
        probability = offsets.nearest(edges.probability)
        crease = None if edges.crease is None else offsets.nearest(edges.crease)
        return FrameEdges(probability, probability, offsets.nearest(edges.strength), edges.network, crease, edges.notes)

    def with_expected(self, result: BlockResult) -> BlockResult:
        """The result of a block that has too little known depth, filled with the expected depth; others unchanged."""
        if self.expected is None or result.outcome.status is not Status.NOT_RECOVERABLE:
            return result
        block, left = result.block, self.frame.unfilled_mask(result.parameters.outside_view)
        expected = self.expected if left is None else np.where(left, np.float32(np.nan), self.expected)
        depth = np.where(np.isnan(result.depth), expected[block.box][block.mask], result.depth)
        filled = int(np.count_nonzero(np.isfinite(depth) & np.isnan(result.depth)))
        if not filled:
            return result
        outcome = replace(result.outcome, status=Status.COMPLETED, recovered=filled, message=_CARRIED)
        return replace(result, depth=depth, outcome=outcome)

    def with_change(self, results: dict[int, BlockResult]) -> dict[int, BlockResult]:
        """Results with the change carried to the current frame applied, if there is one."""
        values = _carried_values(self.change)
        if values is None:
            return results
        if (former := _carried_values(self.former_change)) is not None:
            values = former + (values - former) * np.float32(self.change_age / _REFRESH)
        known = self.frame.known
        factor = np.exp(applied_change(values, known))
        factor[known] = 1
        return {
            label: replace(result, depth=result.depth * factor[result.block.box][result.block.mask])
            if needs_correction(result)
            else result
            for label, result in results.items()
        }

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on surroundings and change."""
        return self.surroundings.value.notes + (() if self.change is None else self.change.value[1])


def _carried_values(change: Carried[Change] | None) -> Array | None:
    """The values of a change at the current frame's pixels, if there are any."""
    return None if change is None or change.value[0] is None else change.offsets.interpolated(change.value[0])


# The stream.


@dataclass
class StreamStatistics:
    """What a stream has done up to a moment.

    Attributes
    ----------
    frames : int
        Completed frames.
    dropped : int
        Frames that `Stream.play` left out because the next one had already come.
    late : int
        Completed frames that took longer than the rate allows.
    scenes : int
        Starts anew, including the first.
    refreshes : int
        How often blocks and edges were found.
    median, worst : float
        Median and 95 % quantile of the latency [s] of the latest frames; NaN before the first.
    """

    frames: int = 0
    dropped: int = 0
    late: int = 0
    scenes: int = 0
    refreshes: int = 0
    median: float = math.nan
    worst: float = math.nan


class Stream(AbstractContextManager["Stream"]):
    """Completes the frames of a camera, one after the other, in a fraction of the time that `ilf.complete` takes.

    Blocks, edges and the learned correction change little from frame to frame: they are found every few frames and
    carried along by optical flow in between. The filter starts from the completed depth of the frame before, which is
    carried along, too, and followed with a small weight, so that filled depth does not flicker. When the scene has
    changed, the stream starts anew, with a note.

    With a rate, blocks, edges and correction are found in a separate thread, from the frames as they come, so results
    depend on timing. Without, they are found in line at fixed frames: the same frames give the same bits.

    Parameters
    ----------
    preset : Parameters or str, optional
        Parameters of the filter, or the name of a preset; "best" if left out.
    rate : float, optional
        Frames per second that are to be completed in time; no deadline if left out.
    threads : int
        Number of threads; with a rate, one of them finds blocks, edges and correction when it is time, and the others,
        at least one, complete blocks.
    extraction : BlockParameters, optional
        Parameters of the blocks' extraction.
    **changes
        Any of the `Parameters` or `BlockParameters`, by name.

    Raises
    ------
    InputError
        If rate or number of threads is not positive.
    ParameterError
        For an unknown preset or parameter, or a value out of range.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> depth = np.full((48, 64), 2.0)
    >>> depth[20:30, 20:40] = 0
    >>> frame = ilf.RGBDFrame(np.zeros((48, 64, 3), np.uint8), depth)
    >>> with ilf.Stream() as stream:
    ...     filled = [int(stream.complete(frame).filled.sum()) for _ in range(3)]
    >>> filled, stream.statistics.frames
    ([200, 200, 200], 3)
    """

    def __init__(
        self,
        preset: Parameters | str | os.PathLike[str] | None = None,
        *,
        rate: float | None = None,
        threads: int = 2,
        extraction: BlockParameters | None = None,
        **changes: Value,
    ) -> None:
        if rate is not None and not 0 < rate < math.inf:
            raise InputError(f"The rate must be positive, in frames per second, not {rate!r}.")
        if threads < 1:
            raise InputError(f"The number of threads must be at least 1, not {threads!r}.")
        self._parameters, self._extraction, _ = chosen_parameters(
            preset, extraction, changes, "preset", "rate", "threads", "extraction"
        )
        self._corrects = self._parameters.filter == "edge-aware" and self._parameters.correction
        self._uncorrected = self._parameters.replace(correction=False) if self._corrects else self._parameters
        self._rate, self._threads = rate, threads
        self._thread = None if rate is None else ThreadPoolExecutor(1, "ilf-stream")
        self._closed = threading.Event()
        self._scene: Shot | None = None
        self._statistics = StreamStatistics()
        self._latencies = deque[float](maxlen=_REMEMBERED)

    @property
    def statistics(self) -> StreamStatistics:
        """What the stream has done so far."""
        return replace(self._statistics)

    def complete(self, frame: RGBDFrame) -> Completion:
        """Complete the next frame.

        Parameters
        ----------
        frame : RGBDFrame
            Of any size; when it changes, the stream starts anew. Its guide, if any, is not used.

        Returns
        -------
        Completion
            As of `ilf.complete`, with a note when the scene has changed.

        Raises
        ------
        InputError
            If it is not a frame, or the stream is closed.
        """
        begun = time.monotonic()
        if self._closed.is_set():
            raise InputError("The stream is closed. Make a new one.")
        plain = checked_frame(frame)
        if frame.guide is not None or frame.ground_truth is not None:
            plain = frame.changed(guide=None, ground_truth=None)
        before, self._scene = self._scene, None  # after an error, the stream starts anew
        notes: tuple[str, ...] = ()
        if before is not None and before.advance(plain):
            scene = before
            self._refresh(scene)
        else:
            notes = () if before is None else (_NEW_SCENE.format(frame.name),)
            scene = Shot(plain, self._find_surroundings(plain))
            self._statistics.scenes += 1
        edges = scene.edges()
        results = self._filtered(scene, edges)
        run = Run(plain, Blocks(scene.labels, extraction=self._extraction), self._parameters)
        scene.depth = compose(run, results).depth
        if edges is not None and self._corrects:
            self._correct(scene, scene.depth, edges)
        completion = compose(replace(run, frame=frame), scene.with_change(results))
        self._scene = scene
        seconds = time.monotonic() - begun
        self._latencies.append(seconds)
        self._statistics.frames += 1
        self._statistics.late += self._rate is not None and seconds > 1 / self._rate
        self._statistics.median, self._statistics.worst = np.quantile(self._latencies, (0.5, 0.95)).tolist()
        return replace(completion, notes=tuple(dict.fromkeys((*notes, *scene.notes, *completion.notes))))

    def play(self, frames: Iterable[RGBDFrame]) -> Generator[Completion, None, None]:
        """Complete frames as they come, which are taken in a thread. Without a rate, every one; with a rate, frames are
        taken at that rate, and while one is being completed, of those that come only the latest waits: the others are
        dropped. The first, which takes longest, is completed before others are taken.

        Parameters
        ----------
        frames : iterable of RGBDFrame
            A recording, or a camera that waits for its next frame.
        """
        coming = iter(frames)
        for first in itertools.islice(coming, 1):
            yield self.complete(first)
        with closing(latest_of(coming, lambda: self._rate)) as taken:
            for frame, dropped in taken:
                self._statistics.dropped += dropped
                yield self.complete(frame)

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the stream and its thread."""
        self._closed.set()
        self._scene = None
        if self._thread is not None:
            self._thread.shutdown(cancel_futures=True)

    def _refresh(self, scene: Shot) -> None:
        """Find blocks and edges again if it is time; with a rate, in the thread, whose results are used when done."""
        if scene.pending is not None and scene.pending.value.done():
            scene.adopt(Carried(scene.pending.value.result(), scene.pending.offsets))
            scene.pending = None
        if scene.age >= _REFRESH and scene.pending is None:
            scene.age = 0
            self._find(scene, self._find_surroundings, scene.frame)

    def _find_surroundings(self, frame: RGBDFrame) -> Surroundings:
        self._statistics.refreshes += 1
        blocks = found_blocks(frame, self._extraction)
        clear_stage_cache(frame)
        return Surroundings(blocks.labels, edges_for(frame, self._parameters, self._extraction), blocks.notes)

    def _filtered(self, scene: Shot, edges: FrameEdges | None) -> dict[int, BlockResult]:
        """Complete the blocks without correction."""
        tasks = [
            BlockTask(scene.frame, block, self._uncorrected, self._extraction, found=edges, carried=scene.expected)
            for block in find_blocks(scene.labels).values()
        ]
        results = {}
        threads = self._threads if scene.pending is None else max(1, self._threads - 1)
        with closing(filter_steps(tasks, threads, {})) as steps:
            for progress in steps:
                if progress.result is not None:
                    found = replace(progress.result, parameters=self._parameters)
                    results[progress.label] = scene.with_expected(found)
        return results

    def _correct(self, scene: Shot, completed: Array, edges: FrameEdges) -> None:
        """Find the correction again if blocks and edges are new."""
        if scene.corrected is scene.surroundings.value or scene.pending is not None:
            return
        scene.corrected = scene.surroundings.value
        if scene.change is None:
            scene.adopt(scene.of_this_frame(change_of(scene.frame, completed, edges)))
        else:
            self._find(scene, change_of, scene.frame, completed, edges)

    def _find(self, scene: Shot, work: Callable[P, Surroundings | Change], *args: P.args, **kwargs: P.kwargs) -> None:
        """Find something in the current frame: in the thread if there is one, else now."""
        if self._thread is None:
            scene.adopt(scene.of_this_frame(work(*args, **kwargs)))
            return

        def aside() -> Surroundings | Change:
            with cancelled_by(self._closed), short_switches():
                return work(*args, **kwargs)

        scene.pending = scene.of_this_frame(self._thread.submit(aside))
