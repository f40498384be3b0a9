"""Commands on the guide."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command(
        "load_guide",
        "Load &guide…",
        "ph.compass",
        "",
        "Follow depth or inverse depth of the frame from elsewhere, as far as the known depth bears it out",
    ),
    Command("remove_guide", "Remove guide", "ph.x-circle", "", "Complete the frame without a guide"),
)
