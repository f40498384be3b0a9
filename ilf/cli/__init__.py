"""The command line: `ilf complete`, `blocks`, `info`, `evaluate` and the others (`commands`); no Qt."""

from __future__ import annotations

from collections.abc import Sequence

from .._runtime.installation import run_if_child
from .._runtime.termination import terminating_immediately


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; default: those of the process.

    Returns
    -------
    int
        Exit status, one of `usage.EXIT_STATUSES`. An error is one line on stderr; no incomplete files are left behind.
    """
    run_if_child()
    with terminating_immediately("ilf"):
        from .commands import run

        return run(argv)
