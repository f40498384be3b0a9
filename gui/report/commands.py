"""Commands of reports."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "report",
        "&Report…",
        "ph.file-text",
        "",
        "Write a page on this frame or all frames, as HTML or PDF: pictures, blocks, parameters, curves, errors",
    ),
)
