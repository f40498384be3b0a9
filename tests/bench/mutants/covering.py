"""Coverage by test: which tests run which lines, and their duration."""

import ast
import json
import subprocess
import sys
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coverage
import pytest

from .trees import PACKAGES, environment, file_hash, python_files, tree_hash

_NO_TIME_S = 0.02
"""Maximum duration of a test that only checks definitions [s]."""

_NO_TESTS = pytest.ExitCode.NO_TESTS_COLLECTED
SUITES = ("tests/ilf", "tests/gui", "tests/e2e")


@dataclass(frozen=True)
class TestCoverage:
    """Coverage and durations of the tests.

    Attributes
    ----------
    seconds : dict
        Test -> duration.
    lines : dict
        File -> line -> the tests that run it.
    """

    seconds: dict[str, float]
    lines: dict[str, dict[int, list[str]]]

    def tests_of(self, path: str, line: int, source: str) -> list[str]:
        """Return the tests for a fault in this line of a file, fast ones first.

        Code outside functions runs once, on import: it concerns all tests that run the file, and then, because any test
        may check definitions, all other fast tests.
        """
        known = self.lines.get(path, {})
        span = _statement(source, line)
        numbers = known if span is None else range(span[0], span[1] + 1)
        tests = {test for number in numbers for test in known.get(number, [])}
        others = {test for test, seconds in self.seconds.items() if seconds < _NO_TIME_S} if span is None else set()
        return [*self._quick_first(tests), *self._quick_first(others - tests)]

    def _quick_first(self, tests: Iterable[str]) -> list[str]:
        return sorted(tests, key=lambda test: (self.seconds[test], test))


def collect(tree: Path, paths: Iterable[str], suites: Sequence[str], jobs: int, folder: Path) -> TestCoverage:
    """Run every test file once, separately, and collect which tests run the lines of some files.

    The coverage of a test file is stored in the folder until the program or the test file changes. Tests that fail
    without a fault are reported and skipped.

    Raises
    ------
    RuntimeError
        If the tests cannot be run.
    """
    program = tree_hash(tree, lambda name: not _is_of_tests(name))
    folder.mkdir(parents=True, exist_ok=True)

    def known(name: str) -> tuple[Path, dict[str, Any]]:
        kept = folder / f"{name.replace('/', '-').removesuffix('.py')}.json"
        of = f"{program} {file_hash(tree, name)}"
        found = json.loads(kept.read_text(encoding="utf-8")) if kept.is_file() else {}
        if found.get("of") != of:
            started = time.monotonic()
            command = [sys.executable, "-m", __name__, name, str(kept), of]
            done = subprocess.run(command, cwd=tree, env=environment(tree), capture_output=True, text=True, check=False)
            if done.returncode not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED, _NO_TESTS):
                raise RuntimeError(f"{name} cannot be run:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
            found = json.loads(kept.read_text(encoding="utf-8"))
            print(f"{len(found['seconds'])} tests in {time.monotonic() - started:.0f} s: {name}", flush=True)
        return kept, found

    with ThreadPoolExecutor(jobs) as pool:
        running = [pool.submit(known, name) for name in _files_of(tree, suites)]
        try:
            parts = [one.result() for one in running]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    seconds: dict[str, float] = {}
    lines: dict[str, dict[int, list[str]]] = {path: {} for path in paths}
    for kept, found in parts:
        for test in found["failed"]:
            print(f"skipped, because it fails without a fault: {test}", flush=True)
        seconds |= found["seconds"]
        data = coverage.CoverageData(str(kept.with_suffix(".lines")))
        data.read()
        for path, of_path in lines.items():
            for line, tests in _tests_by_line(data.contexts_by_lineno(path), found["seconds"]).items():
                of_path.setdefault(line, []).extend(tests)
        data.close()
    return TestCoverage(seconds, lines)


def _is_of_tests(name: str) -> bool:
    return Path(name).name.startswith("test_")


def _files_of(tree: Path, suites: Iterable[str]) -> list[str]:
    """Return the test files in the suites, relative to the root."""
    return [name for name in python_files(tree, suites) if _is_of_tests(name)]


class _Recorder:
    """A pytest plugin that sets coverage's context to the running test."""

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


def _record(name: str, kept: Path, of: str) -> int:
    """Run a test file in this process, and write its coverage, with the hash of its inputs at the end."""
    lines = kept.with_suffix(".lines")
    for old in (kept, lines):
        old.unlink(missing_ok=True)
    measured = coverage.Coverage(data_file=lines, include=[f"{package}/*" for package in PACKAGES])
    measured.set_option("run:relative_files", True)
    recorder = _Recorder(measured)
    measured.start()
    status = int(pytest.main(["-q", "-p", "no:cacheprovider", name], plugins=[recorder]))
    measured.stop()
    measured.save()
    passed = {test: seconds for test, seconds in recorder.seconds.items() if test not in recorder.failed}
    found = {"of": of, "seconds": passed, "failed": recorder.failed}
    kept.write_text(json.dumps(found), encoding="utf-8")
    return status


def _tests_by_line(contexts: dict[int, list[str]], tests: Collection[str]) -> dict[int, list[str]]:
    """Return line -> tests. Lines run in the set-up of a test count for all tests of its file (module fixtures)."""
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

    Coverage does not list all lines of a statement over several lines.
    """
    tree = ast.parse(source)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    if not any(function.body[0].lineno <= line <= (function.end_lineno or 0) for function in functions):
        return None
    spans = [(node.lineno, _head_end(node)) for node in ast.walk(tree) if isinstance(node, ast.stmt)]
    around = [span for span in spans if span[0] <= line <= span[1]]
    return min(around, key=lambda span: span[1] - span[0], default=(line, line))


def _head_end(node: ast.stmt) -> int:
    """Last line of a statement, without its block."""
    body = getattr(node, "body", None)
    return max(node.lineno, body[0].lineno - 1) if body else node.end_lineno or node.lineno


if __name__ == "__main__":
    sys.exit(_record(sys.argv[1], Path(sys.argv[2]), sys.argv[3]))
