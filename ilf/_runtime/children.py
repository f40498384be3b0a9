"""Python for a process of its own: the interpreter, or this program itself where it is frozen and has none."""

from __future__ import annotations

import sys
from importlib import import_module

_CHILD = "--ilf-child"
"""First argument of a frozen program that is such a process; the second is the module whose `main` it runs."""


def child_command(module: str) -> list[str]:
    """The command that runs the `main` of one of this program's modules in a process of its own.

    Parameters
    ----------
    module : str
        Its full name.
    """
    if _is_frozen():
        return [sys.executable, _CHILD, module]
    # -P: none of the modules in the folder that happens to be the current one
    return [sys.executable, "-P", "-c", f"from {module} import main; main()"]


def serve_as_child() -> None:
    """Called first by every entry point. In a frozen program that was started as a child of itself, by `child_command`
    or by `multiprocessing`, it does that child's work and does not return."""
    if not _is_frozen():
        return
    import multiprocessing

    multiprocessing.freeze_support()
    if sys.argv[1:2] == [_CHILD]:
        import_module(sys.argv[2]).main()
        sys.exit()


def _is_frozen() -> bool:
    """Whether a packager, such as PyInstaller, has made one program of this and Python."""
    return bool(getattr(sys, "frozen", False))
