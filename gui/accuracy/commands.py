"""Commands on the truth, and on judging without one."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "load_truth", "Load &truth…", "ph.check-circle", "", "Take the true depth of the frame, to judge results by"
    ),
    Command("remove_truth", "Remove truth", "ph.x-circle", "", "Judge the frame by no truth any more"),
    Command(
        "test_hidden",
        "Test on &hidden depth…",
        "ph.test-tube",
        "",
        "Hide some of the known depth, complete the frame without it, and see how far off it comes out",
    ),
)
