"""Where the work on the frames of a folder is kept, as long as nobody has given it a file."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import platformdirs

from .file import SUFFIX


def projects_of_folders() -> Path:
    """Where these project files are: `ILF_FOLDERS`, or a folder in the user's data folder."""
    chosen = os.environ.get("ILF_FOLDERS")
    return Path(chosen) if chosen else platformdirs.user_data_path("ilf-studio", appauthor=False) / "folders"


def project_of_folder(folder: str | os.PathLike[str]) -> Path:
    """The project file of a folder of frames: always the same for the same folder, whether it is there or not.

    Examples
    --------
    >>> path = project_of_folder("/data/desk")
    >>> path.name, path == project_of_folder("/data/more/../desk")
    ('desk.ilf', True)
    """
    place = os.path.realpath(folder)
    name = os.path.basename(place) or "frames"
    return projects_of_folders() / hashlib.sha256(os.fsencode(place)).hexdigest()[:16] / f"{name}{SUFFIX}"
