"""The journals that windows have left behind."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs

SUFFIX = ".journal"


def journal_folder() -> Path:
    """Where windows keep their journals: `ILF_AUTOSAVE`, or a folder in the user's data folder."""
    chosen = os.environ.get("ILF_AUTOSAVE")
    return Path(chosen) if chosen else platformdirs.user_data_path("ilf-studio", appauthor=False) / "autosave"
