"""Trial of one fault by its tests."""

import os
import re
import resource
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

import pytest

from .covering import TestCoverage
from .sites import Mutant
from .trees import environment, put

_MEMORY = 8 << 30
"""Memory limit [bytes], because a fault may request any amount."""

_START_S, _FACTOR = 60.0, 5.0
"""Time limit: seconds for the start, and a multiple of the tests' usual duration."""

_FEW = 30
"""Number of tests that run first."""


@dataclass(frozen=True)
class Trial:
    """Result of a fault.

    Attributes
    ----------
    outcome : str
        "killed", "survived" or "timeout".
    tests : int
        Number of its tests that were selected.
    killer : str
        Test that found it, "" for none.
    """

    outcome: str
    tests: int
    killer: str = ""


class Trials:
    """Tries faults in a copy of the tree; tests that found faults in a file run first for this file."""

    def __init__(self, tree: Path, covering: TestCoverage, longest: float) -> None:
        self._tree = tree
        self._covering = covering
        self._longest = longest
        self._killers: dict[str, Counter[str]] = {}
        self._reliable: dict[str, bool] = {}

    def run(self, mutant: Mutant, copy: Path) -> Trial:
        """Make the fault in the copy, run its tests until one fails, and restore the file.

        A test that fails alone without a fault, because it depends on other tests, is skipped.

        Raises
        ------
        RuntimeError
            If pytest also fails to run without a fault.
        """
        source = (self._tree / mutant.path).read_text(encoding="utf-8")
        killers = self._killers.setdefault(mutant.path, Counter())
        while True:
            tests = self._tests(mutant, source, [test for test, _ in killers.most_common(5)])
            put(copy, mutant.path, mutant.code(source))
            try:
                outcome, killer = self._try(copy, tests)
            finally:
                put(copy, mutant.path, source)
            if outcome != "killed":
                return Trial(outcome, len(tests))
            named = killer if killer in self._covering.seconds else ""
            if self._is_reliable(copy, named or tests[0]):
                killers.update([named] if named else [])
                return Trial(outcome, len(tests), killer)
            if not named:
                raise RuntimeError(f"The tests cannot be run without a fault: {killer}.")
            print(f"skipped, because it fails without a fault: {killer}", flush=True)

    def _tests(self, mutant: Mutant, source: str, first: list[str]) -> list[str]:
        """Return the tests of a fault in the order of trial, up to the time limit."""
        of_it = [
            test for test in self._covering.tests_of(mutant.path, mutant.line, source) if self._reliable.get(test, True)
        ]
        in_order = dict.fromkeys([test for test in first if test in of_it] + of_it)
        passed = accumulate(self._covering.seconds[test] for test in in_order)
        return [test for test, until in zip(in_order, passed, strict=True) if until <= self._longest]

    def _is_reliable(self, copy: Path, test: str) -> bool:
        """Return whether a test passes alone, without a fault."""
        if test not in self._reliable:
            self._reliable[test] = self._pytest(copy, [test])[0] == "survived"
        return self._reliable[test]

    def _try(self, copy: Path, tests: list[str]) -> tuple[str, str]:
        """Split off a few tests to run first: these find most faults, so the others need not be collected."""
        for some in (tests[:_FEW], tests[_FEW:]):
            if some and (found := self._pytest(copy, some))[0] != "survived":
                return found
        return "survived", ""

    def _pytest(self, tree: Path, tests: list[str]) -> tuple[str, str]:
        names = tree.with_suffix(".tests")
        names.write_text("\n".join(tests), encoding="utf-8")
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "--tb=no", "-p", "no:cacheprovider", f"@{names}"]
        asked = set(tests)
        usual = sum(seconds for test, seconds in self._covering.seconds.items() if {test, _function(test)} & asked)
        process = subprocess.Popen(
            command, cwd=tree, env=environment(tree), text=True, start_new_session=True, preexec_fn=_limit_memory,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            output, _ = process.communicate(timeout=_START_S + _FACTOR * usual)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return "timeout", ""
        if process.returncode == pytest.ExitCode.OK:
            return "survived", ""
        if found := re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", output, re.MULTILINE):
            return "killed", found[1]
        # a fault in a test's parameters changes its name: then the name without parameters is used
        gone = {name.removeprefix(f"{tree}/") for name in re.findall(r"^ERROR: not found: (.+)$", output, re.MULTILINE)}
        whole = list(dict.fromkeys(_function(test) if _function(test) in gone else test for test in tests))
        return ("killed", f"status {process.returncode}") if whole == tests else self._pytest(tree, whole)


def _function(test: str) -> str:
    """Return a test's name without its parameters."""
    return test.split("[")[0]


def _limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
