"""Questions about what cannot be opened as it is: places that a file names, and frames whose work is unreadable."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QWidget

from ilf._runtime.named_places import NotAllowed, note_opened
from ilf.errors import one_line
from ilf.project.state_codec import UnreadableFrame

from ...widgets.notices import ask_yes_no


def ask_to_open(parent: QWidget, error: NotAllowed, yes: Callable[[], None], no: Callable[[], None]) -> None:
    """Ask whether to open places; call `yes` after they were noted as opened by the user, else `no`."""

    def agree() -> None:
        note_opened(*error.places, beside=True)
        yes()

    places = "\n".join(map(one_line, error.places))
    text = f"A file names this outside its own folder, which was never opened here:\n{places}"
    more = (
        "Open it, and files beside it that are named, only if you trust the file: opening may contact another computer."
    )
    ask_yes_no(parent, "Open what a file names?", text, more, agree, no)


def ask_to_open_anew(parent: QWidget, name: str, error: UnreadableFrame, yes: Callable[[], None]) -> None:
    """Ask whether to open the files of a frame without its unreadable work; call `yes` if so."""
    more = "Open its files as a new frame, without the work? The work stays in the project as it is."
    ask_yes_no(parent, f"Open {name} anew?", f"{name} cannot be opened. {error}", more, yes)
