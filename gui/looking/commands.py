"""Commands on what the views show, and on two depths that are compared there."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "view_content",
        "Choose what a &view shows…",
        "ph.list",
        "Ctrl+Shift+V",
        "Choose what the view under the pointer shows, or the one clicked last; the same as a click on its title",
    ),
    Command("reset_contents", "R&eset what views show", "", "", "Let every view show what it showed at first"),
    Command(
        "compare_two",
        "Compare &two",
        "ph.columns",
        "Shift+F4",
        "Show sides A and B, their difference, and the error or the expected error; or back",
        checkable=True,
    ),
    Command(
        "swipe",
        "S&wipe between two",
        "ph.arrows-left-right",
        "Ctrl+Shift+X",
        "Part the depth out by a handle: side A is left of it, side B right of it",
        checkable=True,
    ),
    Command(
        "blink",
        "Look at side &A",
        "ph.eye",
        "",
        "Show side A in place of the result in all views; the same while V is held",
        checkable=True,
    ),
    Command("swap_sides", "Swap A and &B", "ph.swap", "", "Let the two sides of the comparison change places"),
)
