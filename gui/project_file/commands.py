"""The commands that have to do with projects."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command("new_project", "&New project", "ph.file-plus", "", "Close all frames, and begin with none"),
    Command(
        "open_project",
        "Open pro&ject…",
        "ph.folder-notch-open",
        "Ctrl+Alt+O",
        "Open a project file: all its frames with the work on them",
    ),
    Command("save_project", "&Save project", "ph.floppy-disk", "Ctrl+S", "Save all frames with the work on them"),
    Command(
        "save_project_as",
        "Save project &as…",
        "",
        "Ctrl+Shift+S",
        "Save all frames with the work on them to another file, with the frames' own files in it if you like",
    ),
)
