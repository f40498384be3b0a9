"""Which tests run which lines, and how long they take."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import coverage
import pytest

from .trees import environment

_NO_TIME_S = 0.02
"""What a test takes at most that looks at definitions alone."""

SUITES = ("tests/ilf", "tests/gui", "tests/e2e")


@dataclass(frozen=True)
class Covering:
    """What is known of the tests.

    Attributes
    ----------
    seconds : dict
        Test -> how long it takes.
    lines : dict
        File -> line -> the tests that run it.
    """

    seconds: dict[str, float]
    lines: dict[str, dict[int, list[str]]]

    def tests_of(self, path: str, line: int, source: str) -> list[str]:
        """The tests that a fault in this line of a file concerns, the quick ones first.

        What stands outside functions runs once, when the file is imported: it concerns all tests of the file, and as
        any test may look at what a file defines, all others that take no time.
        """
        known = self.lines.get(path, {})
        span = _statement(source, line)
        numbers = known if span is None else range(span[0], span[1] + 1)
        tests = {test for number in numbers for test in known.get(number, [])}
        if span is None:
            tests |= {test for test, seconds in self.seconds.items() if seconds < _NO_TIME_S}
        return sorted(tests, key=lambda test: (self.seconds[test], test))


def collect(tree: Path, files: Sequence[str], suites: Sequence[str], jobs: int, folder: Path) -> Covering:
    """Run the suites once, side by side. Tests that fail without any fault are said and left out.

    Raises
    ------
    RuntimeError
        If the tests cannot be run.
    """

    def run(suite: str) -> dict[str, dict[str, object]]:
        out = folder / f"{suite.replace('/', '-')}.json"
        command = [sys.executable, "-m", __name__, suite, str(out), *files]
        done = subprocess.run(command, cwd=tree, env=environment(tree), capture_output=True, text=True, check=False)
        if done.returncode > 1:
            raise RuntimeError(f"{suite} cannot be run:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
        found: dict[str, dict[str, object]] = json.loads(out.read_text(encoding="utf-8"))
        return found

    with ThreadPoolExecutor(jobs) as pool:
        parts = list(pool.map(run, suites))
    seconds: dict[str, float] = {}
    lines: dict[str, dict[int, list[str]]] = {path: {} for path in files}
    for part in parts:
        for test in part["failed"]:
            print(f"left out, since it fails without any fault: {test}", flush=True)
        seconds |= part["seconds"]  # type: ignore[arg-type]
        for path, tests_of_line in part["lines"].items():
            for line, tests in tests_of_line.items():  # type: ignore[attr-defined]
                lines[path].setdefault(int(line), []).extend(tests)
    return Covering(seconds, lines)


class _Recorder:
    """A plugin of pytest's that tells coverage which test runs."""

    def __init__(self, measured: coverage.Coverage) -> None:
        self._measured = measured
        self.seconds: dict[str, float] = {}
        self.failed: list[str] = []

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        self._measured.switch_context(f"setup|{item.nodeid}")
        yield

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        self._measured.switch_context(f"call|{item.nodeid}")
        yield

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration
        if report.failed:
            self.failed.append(report.nodeid)


def _record(suite: str, out: Path, files: Sequence[str]) -> int:
    """Run a suite in this process, and write what its tests run."""
    measured = coverage.Coverage(data_file=None, include=[str(Path(path).absolute()) for path in files])
    recorder = _Recorder(measured)
    measured.start()
    status = int(pytest.main(["-q", "-p", "no:cacheprovider", suite], plugins=[recorder]))
    measured.stop()
    passed = {test: seconds for test, seconds in recorder.seconds.items() if test not in recorder.failed}
    data = measured.get_data()
    lines = {}
    for path in files:
        if str(Path(path).absolute()) in data.measured_files():
            by_line = data.contexts_by_lineno(str(Path(path).absolute()))
            lines[path] = _tests_by_line(by_line, passed)
    found = {"seconds": passed, "failed": recorder.failed, "lines": lines}
    out.write_text(json.dumps(found), encoding="utf-8")
    return status


def _tests_by_line(contexts: dict[int, list[str]], tests: Collection[str]) -> dict[int, list[str]]:
    """Line -> tests. What the set-up of one test does may serve all tests of its file: fixtures of a module do."""
    found: dict[int, list[str]] = {}
    for line, names in contexts.items():
        of_line: set[str] = set()
        for name in filter(None, names):
            phase, test = name.split("|", 1)
            if phase == "setup":
                module = test.split("::")[0]
                of_line.update(other for other in tests if other.split("::")[0] == module)
            else:
                of_line.add(test)
        found[line] = sorted(of_line.intersection(tests))
    return found


def _statement(source: str, line: int) -> tuple[int, int] | None:
    """First and last line of the smallest statement around a line; None outside functions.

    Of a statement that goes over several lines, not every one counts as run.
    """
    tree = ast.parse(source)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    if not any(function.body[0].lineno <= line <= (function.end_lineno or 0) for function in functions):
        return None
    spans = [(node.lineno, _head_end(node)) for node in ast.walk(tree) if isinstance(node, ast.stmt)]
    around = [span for span in spans if span[0] <= line <= span[1]]
    return min(around, key=lambda span: span[1] - span[0], default=(line, line))


def _head_end(node: ast.stmt) -> int:
    """Last line of a statement, without the block that it may have."""
    body = getattr(node, "body", None)
    return max(node.lineno, body[0].lineno - 1) if body else node.end_lineno or node.lineno


if __name__ == "__main__":
    sys.exit(_record(sys.argv[1], Path(sys.argv[2]), sys.argv[3:]))
