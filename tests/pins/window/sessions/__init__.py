"""Sessions of a user in the window: each is a function of a hand, named after what the user does."""

from collections.abc import Callable
from types import ModuleType

from ..frames import room
from ..hand import Hand
from . import editing, inspecting, projects, running, sequences

Session = Callable[[Hand], None]

MODULES: tuple[ModuleType, ...] = (editing, running, inspecting, sequences, projects)

WITH_A_FRAME = editing, running, inspecting
"""Modules whose sessions begin with the bundled sample, open."""


def _session(module: ModuleType, name: str) -> Session:
    def whole(user: Hand) -> None:
        if module in WITH_A_FRAME:
            user.open(room(user.folder))
        getattr(module, name)(user)

    return whole


SESSIONS: dict[str, Session] = {
    name: _session(module, name)
    for module in MODULES
    for name, session in vars(module).items()
    if callable(session) and not name.startswith("_") and getattr(session, "__module__", "") == module.__name__
}
