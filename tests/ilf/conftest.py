"""Fixtures of many rooms."""

from collections.abc import Callable
from typing import Any

import pytest

from ilf.cli import main


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Gives a command, checks its exit status, and returns what was printed since the last look: `.out` and `.err`."""

    def give(*words: object, status: int = 0) -> Any:
        try:
            ended = main([str(word) for word in words])
        except SystemExit as stopped:  # of argparse
            ended = stopped.code
        assert ended == status
        return capsys.readouterr()

    return give
