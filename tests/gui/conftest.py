from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from pytestqt.qtbot import QtBot

from ilf import RGBDFrame
from ilf.run import Run

from .scripted_runs import WAIT_MS, Bench, Script, ScriptedSteps, Until


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Script:
    script = Script()
    monkeypatch.setattr(Run, "steps", lambda run, threads=None: ScriptedSteps(script, run, threads))
    return script


@pytest.fixture
def bench(qtbot: QtBot, small_frame: RGBDFrame, small_labels: NDArray[np.int32], script: Script) -> Iterator[Bench]:
    bench = Bench(small_frame, small_labels, script)
    yield bench
    script.allow()
    assert bench.runs.shutdown()


@pytest.fixture
def until(qtbot: QtBot) -> Until:
    return lambda condition: qtbot.waitUntil(condition, timeout=WAIT_MS)
