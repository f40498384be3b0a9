"""Commands on blocks that go from frame to frame."""

from __future__ import annotations

from gui.command import Command

HOW = "carry_auto", "carry_copied", "carry_flow"
"""Commands that choose how blocks are carried; what comes after `carry_` is what the library calls it."""

COMMANDS = (
    Command(
        "carry_next",
        "Carry blocks to the next &frame",
        "ph.arrow-bend-down-right",
        "Alt+PgDown",
        "Carry the blocks to the next frame of the list, with names, locks and values, and show it",
    ),
    Command(
        "carry_previous",
        "&Take blocks from the previous frame",
        "ph.arrow-bend-right-down",
        "Alt+PgUp",
        "Carry the blocks of the frame before in the list to this one, with names, locks and values",
    ),
    Command(
        "carry_through",
        "Carry t&hrough the next frames…",
        "ph.fast-forward",
        "",
        "Carry the blocks from frame to frame, through as many as you choose",
    ),
    Command("stop_carrying", "&Stop", "ph.stop", "", "Carry no further; frames that have the blocks keep them"),
    Command(
        "carry_auto",
        "&Automatic",
        "",
        "",
        "By the camera's poses where files tell them; else copy what has not changed, and follow what has moved",
        group="carry_how",
    ),
    Command(
        "carry_copied",
        "&Copied",
        "",
        "",
        "Every pixel keeps its block: for frames from the very same camera position",
        group="carry_how",
    ),
    Command(
        "carry_flow",
        "Optical &flow",
        "",
        "",
        "Follow what moves in the picture, then snap to the edges of the new frame: for a moving camera",
        group="carry_how",
    ),
)
