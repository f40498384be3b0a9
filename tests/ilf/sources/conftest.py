"""No recording stays open after a test."""

import pytest

from ilf.sources.opening import close_all


@pytest.fixture(autouse=True)
def nothing_left_open():
    yield
    close_all()
