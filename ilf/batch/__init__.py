"""Many frames: completed by several processes or machines, a folder each, begun again where it was left."""

from .batch import Batch, open_batch
from .frame_record import FrameOutcome, FrameStatus
from .frames import BatchFrame, frames_of_files, frames_of_sources, named_frames, selected, shard_of
from .manifest import MANIFEST_FILE, read_outcomes
from .settings import BatchSettings

__all__ = [
    "MANIFEST_FILE",
    "Batch",
    "BatchFrame",
    "BatchSettings",
    "FrameOutcome",
    "FrameStatus",
    "frames_of_files",
    "frames_of_sources",
    "named_frames",
    "open_batch",
    "read_outcomes",
    "selected",
    "shard_of",
]
