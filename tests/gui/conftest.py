from unittest.mock import Mock

import numpy as np
import pytest

import ilf
from gui.base.commands import Actions, Command
from gui.base.needs import NOTHING
from gui.features.edit_summary import EditSummaryFeature
from gui.state.document import Document
from gui.state.workspace import Workspace
from gui.views.linked_views import LinkedViews
from gui.work.jobs import stop_workers

from .scripted_runs import Bench, Script, ScriptedSteps
from .states import QUICK, Told
from .tool_host import ToolHost


@pytest.fixture(autouse=True)
def _patient(monkeypatch):
    """Threads have time to end, however busy the machine is: whether they do is what tests ask."""
    monkeypatch.setattr("gui.work.jobs.SHUTDOWN_LIMIT_S", 20.0)


@pytest.fixture
def script(monkeypatch):
    script = Script()
    monkeypatch.setattr(ilf.Run, "steps", lambda run, threads=None, watch=None: ScriptedSteps(script, run, threads))
    return script


@pytest.fixture
def bench(qtbot, small_frame, small_labels, script):
    bench = Bench(small_frame, small_labels, script, qtbot.waitUntil)
    yield bench
    script.allow()
    assert stop_workers(bench.runs)


@pytest.fixture
def views(bench, qtbot):
    views = LinkedViews(bench.workspace)
    qtbot.addWidget(views)
    views.look_back(None)
    return views


@pytest.fixture
def context(bench, views):
    """What features of the bench may use: its state and runs, views, and commands; the rest is not there."""
    actions = Actions(views, lambda: NOTHING)
    actions.add([Command("live", "Live", "Solve blocks after edits", checkable=True, on=True)])
    context = Mock(window=views, workspace=bench.workspace, runs=bench.runs, views=views, actions=actions, features=[])
    context.feature = lambda kind: next((one for one in context.features if isinstance(one, kind)), Mock())
    yield context
    assert stop_workers(views)


@pytest.fixture
def live(context):
    """The action of *Live*, which is on."""
    return context.actions["live"]


@pytest.fixture
def summary(context):
    """The summary of edits."""
    EditSummaryFeature.declare(context)
    summary = EditSummaryFeature(context)
    summary.line.resize(1200, 24)
    return summary


@pytest.fixture
def clock(monkeypatch):
    """The time that runs are measured by [s]; tests let it go on."""
    now = [100.0]
    monkeypatch.setattr("gui.work.frame_runs.time.perf_counter", lambda: now[0])
    return now


@pytest.fixture
def until(qtbot):
    return qtbot.waitUntil


def extracted(labels: np.ndarray) -> ilf.Blocks:
    return ilf.Blocks(labels, extraction=ilf.BlockParameters(), extracted=labels)


@pytest.fixture
def document(small_frame, small_labels, qapp):
    """`small_frame` with its two blocks, as an extraction gave them."""
    return Document.of(ilf.Run(small_frame, extracted(small_labels)), "origin", "key")


@pytest.fixture
def other(small_frame, small_labels, qapp):
    """Another frame, of the same pixels."""
    return Document.of(ilf.Run(small_frame, extracted(small_labels)), "other origin", "other key")


@pytest.fixture
def host(small_frame, small_labels, qapp):
    """Of tools: block 1 on the left, 2 on the right, which meet at x = 30; no snapping, a brush of 3 px."""
    return ToolHost(small_frame, small_labels)


@pytest.fixture
def workspace(document, other):
    """Both frames, the first the present one."""
    workspace = Workspace()
    workspace.open_document(other)
    workspace.open_document(document)
    return workspace


@pytest.fixture
def told(workspace):
    """What the workspace tells from now on."""
    return Told(workspace)


@pytest.fixture
def results(document):
    """What a short run of both blocks gives."""
    return list(ilf.complete(document.frame, document.labels, QUICK).results.values())
