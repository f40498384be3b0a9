"""Frames that lie inside recordings: one file per kind, behind `Recording`.

A recording is a file or a folder whose frames are not two image files that `ilf.load_frame` reads. What it has of a
frame is told as it is stored; depth encodings, doubts and registration are applied in one place (`ilf/io/recorded.py`).
"""

from .opening import close_all, is_recording, kind_of, opened, recording_suffixes
from .recording import Cameras, RecordedFrame, Recording, RecordingIndex, Topics

__all__ = [
    "Cameras",
    "RecordedFrame",
    "Recording",
    "RecordingIndex",
    "Topics",
    "close_all",
    "is_recording",
    "kind_of",
    "opened",
    "recording_suffixes",
]
