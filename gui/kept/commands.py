"""Commands on kept runs."""

from __future__ import annotations

from gui.command import Command

COMMANDS = (
    Command("show_runs", "&Kept runs", "ph.list-numbers", "Ctrl+Shift+R", "Open the list of this frame's runs"),
    Command(
        "compare_runs",
        "Co&mpare with present",
        "ph.columns",
        "Ctrl+Shift+D",
        "Show the chosen runs, four at most, beside the present result, in views and curves; again to stop",
    ),
    Command(
        "restore_run",
        "Restore &parameters",
        "ph.arrow-u-up-left",
        "",
        "Set the parameters of the chosen run, those of all blocks and those of some; results stay as they are",
    ),
    Command(
        "accept_run",
        "&Accept as the result",
        "ph.check-circle",
        "Ctrl+Shift+A",
        "Let the results of the chosen run be the present ones, with its parameters, where blocks are as they were",
    ),
    Command("rename_run", "Re&name run", "ph.pencil-simple", "", "Give the chosen run another name (F2 in the list)"),
    Command("note_run", "Edit n&ote", "ph.note-pencil", "", "Say something of the chosen run"),
    Command("delete_runs", "&Delete runs", "ph.trash", "", "Keep the chosen runs no longer (Del in the list)"),
    Command(
        "export_runs", "Export runs as CS&V…", "ph.export", "", "Write the list of runs, with all parameters, as CSV"
    ),
    Command("clear_runs", "Clear ru&ns", "ph.backspace", "", "Keep none of the frame's runs"),
)
"""What the window has for them; `RUN_MENU` says in which order."""

RUN_MENU = "compare_runs accept_run restore_run | rename_run note_run delete_runs | export_runs clear_runs"
