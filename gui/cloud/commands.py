"""The commands of the 3D view."""

from __future__ import annotations

from gui.command import Command

COMMANDS: tuple[Command, ...] = (
    Command(
        "cloud_beside",
        "&3D beside the images",
        "ph.columns",
        "Ctrl+Shift+B",
        "Show the point cloud beside the images instead of in a tab of its own",
        checkable=True,
    ),
    Command(
        "cloud_raw",
        "3D: ra&w depth",
        "ph.eye",
        "",
        "Show the cloud as it was before the completion; the same in 3D while X is held",
        checkable=True,
    ),
    Command(
        "cloud_chosen_only",
        "3D: chosen blocks onl&y",
        "ph.selection",
        "",
        "Show only the chosen blocks in 3D",
        checkable=True,
    ),
)
