"""Starting child processes: by the Python interpreter, or by this program itself if it is frozen."""

from __future__ import annotations

import sys
from importlib import import_module

_CHILD = "--ilf-child"
"""First argument of a frozen program that runs as a child; the second is the module whose `main` it runs."""


def child_command(module: str) -> list[str]:
    """Return the command that runs the `main` of one of this program's modules in a separate process.

    Parameters
    ----------
    module : str
        Its full name.
    """
    if is_frozen():
        return [sys.executable, _CHILD, module]
    # -P: do not import modules from the current folder
    return [sys.executable, "-P", "-c", f"import sys; from {module} import main; sys.exit(main())"]


def run_if_child() -> None:
    """Run the child's work if this is a frozen program started as a child of itself, by `child_command` or by
    `multiprocessing`, and do not return. Every entry point calls this first."""
    if not is_frozen():
        return
    import multiprocessing

    multiprocessing.freeze_support()
    if sys.argv[1:2] == [_CHILD]:
        module = sys.argv[2]
        del sys.argv[1:3]  # the rest are the arguments of that `main`, which may be an entry point, too
        sys.exit(import_module(module).main())


def is_frozen() -> bool:
    """Whether a packager, such as PyInstaller, has bundled this program with Python."""
    return bool(getattr(sys, "frozen", False))
