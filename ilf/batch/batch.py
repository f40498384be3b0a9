"""A batch: many frames completed with the same settings, a folder each; what is there already is not done again."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from ..io.folders import made_folder
from ..number_words import counted
from .cluster import outcomes_on_cluster
from .frame_record import FrameOutcome
from .frames import BatchFrame
from .local import Outcomes, outcomes_here
from .manifest import write_manifest
from .pictures import depth_levels
from .settings import BatchSettings, differences, read_settings, sha256_of, write_settings
from .states import State, frame_states
from .task import Task

_SHOWN = 3
_ANEW = (
    "Choose another folder, or complete them anew (--anew; in the window, Again: Frames of other settings or files)."
)
"""Differences and frames that a message names."""


@dataclass(frozen=True)
class Batch:
    """Frames to complete, and what is known of them before it begins; made by `open_batch`.

    Attributes
    ----------
    task : Task
    frames : tuple of BatchFrame
        All that results may be for.
    to_do : tuple of BatchFrame
        Those that are to be completed.
    finished : tuple of FrameOutcome
        What came of those that are there already.
    failed : tuple of FrameOutcome
        What came of those that failed before and are not tried again.
    """

    task: Task
    frames: tuple[BatchFrame, ...]
    to_do: tuple[BatchFrame, ...]
    finished: tuple[FrameOutcome, ...] = ()
    failed: tuple[FrameOutcome, ...] = ()

    @property
    def folder(self) -> Path:
        """Where the results are."""
        return Path(self.task.folder)

    def outcomes(self, *, jobs: int = 1, cluster: str | None = None) -> Outcomes:
        """Complete the frames, and tell what came of each, in the order of their ends.

        When this generator ends or is closed, so has the work; frames under way are given up, and done when the batch
        is opened again.

        Parameters
        ----------
        jobs : int
            Processes of this machine.
        cluster : str, optional
            A Dask scheduler in their place: its address, or the file that it has written that to.

        Raises
        ------
        IlfError
            For what keeps all frames from being completed. What is wrong with one is its outcome.
        """
        if cluster is not None and self.to_do:
            return outcomes_on_cluster(self.task, self.to_do, cluster)
        return outcomes_here(self.task, self.to_do, jobs)

    def write_manifest(self) -> list[FrameOutcome]:
        """Write manifest.csv over all results in the folder, whoever has made them, and return what is in it."""
        return write_manifest(self.folder, self.frames)


def open_batch(
    frames: Sequence[BatchFrame],
    folder: str | os.PathLike[str],
    settings: BatchSettings | None = None,
    *,
    only: Sequence[BatchFrame] | None = None,
    anew: bool = False,
    retry_failed: bool = False,
    strict: bool = False,
) -> Batch:
    """Look at what there is of a batch in a folder, and what is left to do.

    Parameters
    ----------
    frames : sequence of BatchFrame
        As `frames_of_sources` gives them.
    folder : path-like
        Of the results, made if missing; each frame has a folder in it.
    settings : BatchSettings, optional
        The defaults if left out.
    only : sequence of BatchFrame, optional
        Those of the frames that are completed here; all of them if left out.
    anew : bool
        Complete frames again that were completed with other settings, or whose files have changed since.
    retry_failed : bool
        Also take frames that failed before. One whose files have changed since is taken in any case.
    strict : bool
        Frames fail whose files are doubted to be read rightly (`RGBDFrame.doubts`).

    Raises
    ------
    InputError
        If there are results of other settings, or of files that have changed since, and `anew` is False. Nothing has
        changed then.
    ExportError
        If the folder cannot be written.
    """
    chosen, target = settings or BatchSettings(), Path(folder).absolute()
    before = read_settings(target)
    facts = chosen.facts()
    same = before is not None and before[0] == facts
    if before is not None and not same and not anew:
        raise InputError(
            f"{target} has frames that were completed with other settings "
            f"({_some(differences(before[0], facts))}). {_ANEW}"
        )
    # other settings may have other frames, and these other depths
    levels = before[1] if before is not None and same else depth_levels(frames)
    task = Task(str(target), chosen, sha256_of(facts), levels, strict)
    found = frame_states(task, frames if only is None else only)
    changed = [there.frame.key for there in found if there.state is State.CHANGED]
    if changed and not anew:
        raise InputError(
            f"The files of {counted(len(changed), 'frame')} have changed since they were completed into {target}: "
            f"{_some(changed)}. {_ANEW}"
        )
    if not same:
        write_settings(made_folder(target), facts, levels)
    kept = {State.FINISHED} if retry_failed else {State.FINISHED, State.FAILED}
    to_do = tuple(there.frame for there in found if there.state not in kept)
    finished, failed = (
        tuple(there.outcome for there in found if there.outcome is not None and there.state is state)
        for state in (State.FINISHED, State.FAILED)
    )
    return Batch(task, tuple(frames), to_do, finished, () if retry_failed else failed)


def _some(things: Sequence[str]) -> str:
    more = len(things) - _SHOWN
    return "; ".join(things[:_SHOWN]) + (f"; and {more} more" if more > 0 else "")
