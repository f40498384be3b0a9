"""What paths are, by their names and folders. Does not import Qt: the command line uses it too, also where Qt fails."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

from ilf.sources.frame_folder import is_frame_folder
from ilf.sources.naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from ilf.sources.opening import is_recording

PROJECT_SUFFIX = ".ilf"


def contains_frames(path: str) -> bool:
    """Return whether a path is a folder of frames or a recording; a single frame's folder is not."""
    return is_recording(path) or (Path(path).is_dir() and not is_frame_folder(path))


def sort_paths(paths: Iterable[Path]) -> tuple[list[Path], list[Path], list[Path], list[Path]]:
    """Return project files, folders and recordings, run records, and image files among paths, in the given order. A
    MATLAB file after a colour image is its depth, not a recording."""
    chosen = list(paths)
    of_pairs = {
        depth
        for rgb, depth in pairwise(chosen)
        if rgb.suffix.lower() in COLOUR_SUFFIXES and depth.suffix.lower() in DEPTH_FILE_SUFFIXES
    }
    folders = [path for path in chosen if path.is_dir() or (is_recording(path) and path not in of_pairs)]
    files = [path for path in chosen if path not in folders]
    projects = [path for path in files if path.suffix.lower() == PROJECT_SUFFIX]
    records = [path for path in files if path.suffix == ".json"]
    return projects, folders, records, [path for path in files if path not in projects and path not in records]
