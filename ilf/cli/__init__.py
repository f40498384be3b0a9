"""The command line: `ilf complete`, `blocks`, `info`, `evaluate` and the others (`commands`); no Qt."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from .._runtime.installation import run_if_child
from .._runtime.memory import check_address_space
from .._runtime.termination import terminating_immediately
from .._runtime.threads import available_cores
from ..errors import InputError


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
    try:
        check_address_space(available_cores())
    except InputError as error:
        print("ilf: error:", error, file=sys.stderr)
        return 1
    with terminating_immediately("ilf"):
        from .commands import run

        return run(argv)
