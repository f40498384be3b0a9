"""Commands on the range of the colours."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "show_range",
        "&Range of the colours",
        "ph.chart-bar",
        "Ctrl+Shift+G",
        "Open the histogram of what is shown, with the ends of the colours",
    ),
    Command(
        "lock_range",
        "Loc&k the range",
        "ph.lock",
        "",
        "Keep the ends of the colours as they are, in all views, for all runs and frames",
        checkable=True,
    ),
)
