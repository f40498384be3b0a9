"""The commands that have to do with layouts of the window."""

from __future__ import annotations

from gui.command import Command
from gui.layouts.layout import BUILT_IN, CORRECT, INSPECT, OWN, STANDARD, TUNE

_ICONS = {STANDARD: "ph.layout", INSPECT: "ph.eye", CORRECT: "ph.pencil-line", TUNE: "ph.sliders"}
_KEYS = {INSPECT: "F3", CORRECT: "F4", TUNE: "F12"}

COMMANDS = (
    *(
        Command(
            f"layout_{layout.name}",
            f"&{layout.text}",
            _ICONS[layout.name],
            _KEYS.get(layout.name, ""),
            f"{layout.hint}; or back",
            checkable=True,
        )
        for layout in BUILT_IN
    ),
    *(
        Command(f"layout_{name}", name, "", f"Ctrl+Alt+{number}", "A layout of your own; or back", checkable=True)
        for number, name in enumerate(OWN, 1)
    ),
    Command(
        "save_layout",
        "&Save layout as…",
        "ph.floppy-disk",
        "",
        "Keep the views, what they show, and the panels as they are now under a name, with a key",
    ),
    Command("rename_layout", "Re&name layout…", "", "", "Give the present layout, one of your own, another name"),
    Command("delete_layout", "&Delete layout", "ph.trash", "", "Delete the present layout, one of your own"),
    Command("restore_layout", "Restore layout", "", "", "Bring back the layout that was deleted last"),
    Command(
        "reset_layout",
        "&Reset layout",
        "ph.arrow-counter-clockwise",
        "",
        "Bring the present layout back to what it is from the first, or was saved as",
    ),
)
