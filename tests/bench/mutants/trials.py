"""Trials of faults: `python -m tests.bench.mutants.trials FILE`, whose output is the outcome of each, as JSON.

All tests and the files with faults are imported once. Every fault is then made in the functions of a fork of this
process, which runs the tests of its lines, fast ones first, until one fails.
"""

import gc
import importlib
import json
import os
import resource
import select
import signal
import sys
import time
from itertools import accumulate
from pathlib import Path
from types import CodeType, FunctionType

import pytest

from .covering import function_of
from .sites import Mutant

_MEMORY = 8 << 30
"""Memory limit [bytes], because a fault may request any amount."""

_START_S, _FACTOR = 60.0, 5.0
"""Time limit: seconds for the start, and a multiple of the tests' usual duration."""


class Trials:
    """Tries faults by the tests of their lines.

    Parameters
    ----------
    seconds : dict
        Duration of each test.
    longest : float
        Limit of the usual duration of a fault's tests [s].
    """

    def __init__(self, seconds: dict[str, float], longest: float) -> None:
        self._seconds, self._longest = seconds, longest
        self._reliable: dict[str, bool] = {}

    def run(self, mutant: Mutant, tests: list[str]) -> dict[str, object]:
        """Return the outcome of a fault ("killed", "survived", "timeout"), the number of its tests, and what found it.

        A test that fails alone without a fault, because it depends on other tests, is left out.
        """
        while True:
            in_order = sorted((test for test in tests if self._reliable.get(test, True)), key=self._seconds.__getitem__)
            until = accumulate(map(self._seconds.__getitem__, in_order))
            some = [test for test, end in zip(in_order, until, strict=True) if end <= self._longest]
            outcome, killer = self._try(mutant, some) if some else ("survived", "")
            if outcome != "killed" or self._is_reliable(killer):
                return {"outcome": outcome, "tests": len(some), "killer": killer}

    def _is_reliable(self, test: str) -> bool:
        if test not in self._reliable:
            self._reliable[test] = self._try(None, [test])[0] == "survived"
        return self._reliable[test]

    def _try(self, mutant: Mutant | None, tests: list[str]) -> tuple[str, str]:
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                os.setsid()
                resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
                if mutant is not None:
                    _make(mutant)
                first = _First()
                status = pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests], plugins=[first])
                os.write(writing, f"{first.failed or (tests[0] if status else '')}\n".encode())
            finally:
                os._exit(0)
        os.close(writing)
        told, end = b"", time.monotonic() + _START_S + _FACTOR * sum(map(self._seconds.__getitem__, tests))
        while not told.endswith(b"\n") and select.select([reading], [], [], max(end - time.monotonic(), 0))[0]:
            told += os.read(reading, 2**16) or f"{tests[0]}\n".encode()  # the process has ended
        os.close(reading)
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
        killer = told.decode().strip()
        return "killed" if killer else "survived" if told else "timeout", killer


class _First:
    """A pytest plugin that notes the first test that fails."""

    failed = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or function_of(report.nodeid)


def _make(mutant: Mutant) -> None:
    """Give all functions of the file, wherever they are, the code that they have with the fault."""
    path = os.path.abspath(mutant.path)
    codes = _codes(compile(mutant.tree(Path(path).read_text(encoding="utf-8")), path, "exec"))
    gc.unfreeze()
    functions = [one for one in gc.get_objects() if isinstance(one, FunctionType) and one.__code__.co_filename == path]
    for function in functions:
        old = function.__code__
        new = codes.get((old.co_qualname, old.co_firstlineno), old)
        if new.co_freevars == old.co_freevars:
            function.__code__ = new


def _codes(code: CodeType) -> dict[tuple[str, int], CodeType]:
    """All functions in compiled code, by name and first line."""
    found = {(code.co_qualname, code.co_firstlineno): code}
    for part in code.co_consts:
        if isinstance(part, CodeType):
            found |= _codes(part)
    return found


def main(asked: str) -> None:
    """Try faults and print their outcomes."""
    given = json.loads(Path(asked).read_text(encoding="utf-8"))
    out = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    mutants = [Mutant(**fields) for fields in given["mutants"]]
    if status := pytest.main(["--collect-only", "-q", "-p", "no:cacheprovider", *given["suites"]]):
        sys.exit(int(status))
    for name in {mutant.path for mutant in mutants}:
        importlib.import_module(name.removesuffix(".py").removesuffix("/__init__").replace("/", "."))
    trials = Trials(given["seconds"], given["longest"])
    for number, mutant in enumerate(mutants):
        print(json.dumps({"number": number, **trials.run(mutant, given["tests"][number])}), file=out, flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
