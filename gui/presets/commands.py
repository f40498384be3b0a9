"""Commands on the user's own presets."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command("save_preset", "&Save preset as…", "ph.floppy-disk", "", "Keep the filter's values as your own preset"),
    Command("rename_preset", "&Rename preset…", "ph.pencil-simple", "", "Give your chosen preset another name"),
    Command("delete_preset", "&Delete preset…", "ph.trash", "", "Delete your chosen preset"),
    Command(
        "import_preset",
        "&Import preset…",
        "ph.download-simple",
        "",
        "Take a preset from a file among your own",
    ),
    Command(
        "export_preset",
        "&Export preset…",
        "ph.upload-simple",
        "",
        "Write the filter's values to a file, for another computer or for 'ilf complete --preset FILE'",
    ),
)
