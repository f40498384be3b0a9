"""Which tests run which lines, and how long they take: `python -m tests.bench.mutants.covering FILE SUITE ...`."""

import json
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import coverage
import pytest

PACKAGES = ("ilf", "gui")
"""The program."""


def function_of(test: str) -> str:
    """Return a test's name without its parameters."""
    return test.partition("[")[0]


class _Recorder:
    """A pytest plugin that sets coverage's context to the running test; in its set-up, to the file.

    What a fixture runs may be for all tests of its file.
    """

    def __init__(self, measured: coverage.Coverage) -> None:
        self._measured = measured
        self.seconds: dict[str, float] = defaultdict(float)
        self.failed: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        self._measured.switch_context(item.nodeid.partition("::")[0])
        yield

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        self._measured.switch_context(function_of(item.nodeid))
        yield

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        test = function_of(report.nodeid)
        self.seconds[test] += report.duration
        if report.failed:
            self.failed.add(test)


def main(kept: str, *suites: str) -> None:
    """Run the suites, and write the duration of every test that passes, and the tests of every line."""
    measured = coverage.Coverage(data_file=None, include=[f"{package}/*" for package in PACKAGES])
    measured.set_option("run:relative_files", True)
    recorder = _Recorder(measured)
    measured.start()
    status = pytest.main(["-q", "-p", "no:cacheprovider", *suites], plugins=[recorder])
    measured.stop()
    if status not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        sys.exit(int(status))
    seconds = {test: took for test, took in recorder.seconds.items() if test not in recorder.failed}
    of_file = defaultdict(list)
    for test in seconds:
        of_file[test.partition("::")[0]].append(test)
    data, lines = measured.get_data(), {}
    for path in data.measured_files():
        lines[path] = {
            line: sorted({test for name in names for test in of_file.get(name, [name]) if test in seconds})
            for line, names in data.contexts_by_lineno(path).items()
        }
    found = {"seconds": seconds, "lines": lines, "failed": sorted(recorder.failed)}
    Path(kept).write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
