"""A batch, step by step, in any thread."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from ilf.batch import Batch, BatchFrame, BatchSettings, FrameOutcome, open_batch
from ilf.batch.sequence import write_contact_sheet, write_video
from ilf.stopping import heed


@dataclass(frozen=True)
class BatchWish:
    """What the user wants done.

    Attributes
    ----------
    frames : tuple of BatchFrame
        All of the list.
    only : tuple of BatchFrame
        Those that are to be completed.
    folder : Path
        For the results.
    settings : BatchSettings
    jobs : int
        Processes.
    retry_failed, anew : bool
        As `open_batch` takes them.
    sheet, video : bool
        Whether a contact sheet and a video are made of the previews.
    """

    frames: tuple[BatchFrame, ...]
    only: tuple[BatchFrame, ...]
    folder: Path
    settings: BatchSettings
    jobs: int = 1
    retry_failed: bool = False
    anew: bool = False
    sheet: bool = False
    video: bool = False


@dataclass(frozen=True)
class Opened:
    """What there is of a batch before it begins."""

    batch: Batch


def batch_steps(wish: BatchWish) -> Generator[Opened | FrameOutcome, None, list[FrameOutcome]]:
    """Complete the frames: what there was, then what comes of each; returns what there is at the end.

    However it ends, the manifest says what there is.

    Raises
    ------
    IlfError
        As `open_batch` and `Batch.outcomes` do, or if a picture cannot be made.
    """
    batch = open_batch(
        wish.frames, wish.folder, wish.settings, only=wish.only, anew=wish.anew, retry_failed=wish.retry_failed
    )
    yield Opened(batch)
    try:
        with closing(batch.outcomes(jobs=wish.jobs)) as outcomes:
            yield from outcomes
    except BaseException:
        heed()  # also when it was cancelled
        batch.write_manifest()
        raise
    found = batch.write_manifest()
    for write in _pictures(wish):
        write(wish.folder, found)
    return found


def _pictures(wish: BatchWish) -> Sequence[Callable[[Path, Sequence[FrameOutcome]], Path]]:
    return [write_contact_sheet] * wish.sheet + [write_video] * wish.video
