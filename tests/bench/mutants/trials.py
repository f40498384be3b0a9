"""One fault against the tests that it concerns."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from .covering import Covering
from .sites import Mutant
from .trees import environment, put

_MEMORY = 8 << 30
"""A fault may ask for any amount of memory; this much it gets [bytes]."""

_START_S, _FACTOR, _LONGEST_S = 60.0, 5.0, 900.0
"""Time limit: so long to start, so many times what the tests usually take, and never longer than this."""


@dataclass(frozen=True)
class Trial:
    """What became of a fault.

    Attributes
    ----------
    outcome : str
        "killed", "survived" or "timeout".
    tests : int
        How many tests it concerns.
    killer : str
        The test that found it, "" for none.
    """

    outcome: str
    tests: int
    killer: str = ""


class Trials:
    """Tries faults, in a copy of the tree at a time; tests that found faults in a file go first there."""

    def __init__(self, tree: Path, covering: Covering) -> None:
        self._tree = tree
        self._covering = covering
        self._killers: dict[str, Counter[str]] = {}
        self._reliable: dict[str, bool] = {}

    def run(self, mutant: Mutant, copy: Path) -> Trial:
        """Make the fault in the copy, run its tests until one fails, and mend it again.

        A test that fails alone without any fault, because it needs others before it, finds nothing: it is left out.

        Raises
        ------
        RuntimeError
            If pytest could not do what it was asked to.
        """
        source = (self._tree / mutant.path).read_text(encoding="utf-8")
        killers = self._killers.setdefault(mutant.path, Counter())
        while True:
            tests = [test for test in self._covering.tests_of(mutant.path, mutant.line, source) if self._counts(test)]
            if not tests:
                return Trial("survived", 0)
            first = [test for test, _ in killers.most_common(5) if test in set(tests)]
            put(copy, mutant.path, mutant.code(source))
            try:
                outcome, killer = self._pytest(copy, list(dict.fromkeys(first + tests)))
            finally:
                put(copy, mutant.path, source)
            if killer not in self._covering.seconds:
                return Trial(outcome, len(tests), killer)
            if killer not in self._reliable:
                self._reliable[killer] = self._pytest(copy, [killer])[0] == "survived"
            if self._reliable[killer]:
                killers[killer] += 1
                return Trial(outcome, len(tests), killer)
            print(f"left out, since it fails without any fault: {killer}", flush=True)

    def _counts(self, test: str) -> bool:
        return self._reliable.get(test, True)

    def _pytest(self, tree: Path, tests: list[str]) -> tuple[str, str]:
        names = tree.with_suffix(".tests")
        names.write_text("\n".join(tests), encoding="utf-8")
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "--tb=no", "-p", "no:cacheprovider", f"@{names}"]
        usual = sum(self._covering.seconds[test] for test in tests)
        process = subprocess.Popen(
            command, cwd=tree, env=environment(tree), text=True, start_new_session=True, preexec_fn=_limit_memory,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            output, _ = process.communicate(timeout=min(_START_S + _FACTOR * usual, _LONGEST_S))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return "timeout", ""
        if process.returncode == 0:
            return "survived", ""
        if process.returncode > 4 or "ERROR: not found" in output:
            raise RuntimeError(f"pytest ended with status {process.returncode}:\n{output[-2000:]}")
        found = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", output, re.MULTILINE)
        return "killed", found[1] if found else f"status {process.returncode}"


def _limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
