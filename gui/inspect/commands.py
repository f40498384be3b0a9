"""Commands on what is looked at closely."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command("remove_marks", "Remo&ve line and rectangle", "ph.x", "", "Remove the profile line and the rectangle"),
    Command("save_profile", "Save profile as &table…", "ph.table", "", "Write the depth along the profile line as CSV"),
    Command("save_profile_picture", "Save profile as p&icture…", "ph.image", "", "Write the plot as PNG or SVG"),
    Command("copy_statistics", "Copy &statistics", "ph.copy", "", "Copy the statistics as a table for other programs"),
    Command(
        "copy_measurements", "&Copy measurements", "ph.copy", "", "Copy the measurements as a table for other programs"
    ),
    Command("save_measurements", "Save m&easurements…", "ph.floppy-disk", "", "Write the measurements as CSV"),
    Command(
        "delete_measurements",
        "&Delete measurements",
        "ph.trash",
        "",
        "Delete the measurements that are chosen in the list, or all if none is",
    ),
    Command("restore_measurements", "Take back", "", "", "Have the measurements again that were deleted last"),
)
