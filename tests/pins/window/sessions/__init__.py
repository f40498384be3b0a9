"""Sessions of a user in the window: each is a function of a hand, named after what the user does."""

from collections.abc import Callable
from types import ModuleType

from ..hand import Hand
from . import editing, inspecting, projects, running, sequences

Session = Callable[[Hand], None]

MODULES: tuple[ModuleType, ...] = (editing, running, inspecting, sequences, projects)

SESSIONS: dict[str, Session] = {
    name: session
    for module in MODULES
    for name, session in vars(module).items()
    if callable(session) and not name.startswith("_") and getattr(session, "__module__", "") == module.__name__
}
