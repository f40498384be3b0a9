"""Commands of batches."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "batch",
        "&Batch…",
        "ph.film-strip",
        "",
        "Complete many frames of the list from their files, in the background, each into a folder of its own",
    ),
)
