"""Commands of the sweep."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "sweep",
        "S&weep a parameter…",
        "ph.chart-bar",
        "",
        "Try many values of a parameter, or pairs of two, and see which comes nearest to the truth or to hidden depth",
    ),
)
