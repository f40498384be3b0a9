"""Every test: offscreen Qt, settings of its own, nothing left running."""

import gc
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
# before numpy: as many processes as cores run tests, and threads of OpenBLAS that wait for each other keep cores busy
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import numpy as np
import pytest
from pytestqt.qtbot import QtBot

import ilf

# what tests open is remembered until they all have ended
_state = tempfile.TemporaryDirectory(prefix="ilf-tests-")
os.environ["XDG_STATE_HOME"] = _state.name

# no timed assertions; the same examples on every continuous run, new ones at home
hypothesis.settings.register_profile("home", deadline=None)
hypothesis.settings.register_profile("continuous", deadline=None, derandomize=True)
hypothesis.settings.load_profile("continuous" if os.environ.get("CI") else "home")


# pytest-qt waits for 5 s, which is too short on a busy machine
for _wait in (QtBot.waitUntil, QtBot.waitSignal, QtBot.waitSignals, QtBot.waitCallback, QtBot.waitExposed):
    _wait.__kwdefaults__["timeout"] = 60_000

_LONGEST_STEP_S = 60.0


@pytest.fixture(autouse=True)
def isolated_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Settings, edge networks, presets and the autosaves are in folders of the test's own."""
    from PySide6.QtCore import QCoreApplication, QSettings

    QCoreApplication.setOrganizationName("ILF Studio")
    QCoreApplication.setApplicationName("ilf-studio-tests")
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("ILF_MODELS", str(tmp_path / "models"))
    monkeypatch.setenv("ILF_PRESETS", str(tmp_path / "presets"))
    monkeypatch.setenv("ILF_AUTOSAVE", str(tmp_path / "autosave"))
    monkeypatch.setenv("ILF_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("ILF_LOG", str(tmp_path / "faults.log"))
    monkeypatch.delenv("ILF_DEVICE", raising=False)


@pytest.fixture(autouse=True)
def nothing_left_running(request: pytest.FixtureRequest) -> Iterator[None]:
    """Threads and timers that a test started must have ended when it ends; only one with an application has timers."""
    before = set(threading.enumerate())
    yield
    left = [thread for thread in threading.enumerate() if thread not in before and thread.name.startswith("ilf")]
    for thread in left:  # what was cancelled may be in the middle of something that cannot be stopped
        thread.join(_LONGEST_STEP_S)
    left = [thread for thread in left if thread.is_alive()]
    assert not left, f"threads left running: {left}"
    if "qapp" not in request.fixturenames:
        return
    from PySide6.QtCore import QCoreApplication, QEvent, QTimer

    # now, rather than in the middle of the next test, which would be slower for a second window
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    # not isinstance, which follows weak proxies to what may be gone
    timers = [item for item in gc.get_objects() if issubclass(type(item), QTimer) and _is_active(item)]
    assert not timers, f"timers left running: {[timer.parent() for timer in timers]}"
    gc.freeze()  # what is left stays, as caches do: the next collection need not look through it


def _is_active(timer: object) -> bool:
    try:
        return bool(timer.isActive())  # type: ignore[attr-defined]
    except RuntimeError:  # its C++ part is gone
        return False


@pytest.fixture
def heard() -> Iterator[object]:
    """How signals are heard, wherever these tests run: what a shell starts in the background ignores SIGINT."""
    before = {
        number: signal.signal(number, signal.default_int_handler)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    yield signal.default_int_handler
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def shown(qtbot: QtBot) -> Callable[..., Any]:
    """Shows a widget, in a size or its own, and returns it; it is deleted in the end."""

    def show(widget: Any, *size: int) -> Any:
        qtbot.addWidget(widget)
        if size:
            widget.resize(*size)
        widget.show()
        qtbot.waitExposed(widget)
        return widget

    return show


@pytest.fixture
def any_theme(qapp: Any) -> Iterator[None]:
    """A test may apply themes: the former one comes back."""
    palette, sheet = qapp.palette(), qapp.styleSheet()
    yield
    qapp.setStyleSheet(sheet)
    qapp.setPalette(palette)


@pytest.fixture
def small_frame() -> ilf.RGBDFrame:
    """48 x 64: two slanted planes that meet in a colour edge and a depth jump, with a hole in each."""
    rows, columns = np.mgrid[:48, :64]
    left = columns < 30
    depth = np.where(left, 1.5 + 0.004 * rows, 2.4 + 0.005 * columns)
    depth[10:22, 8:20] = np.nan
    depth[30:40, 40:56] = np.nan
    rgb = np.where(left[..., None], [200, 90, 40], [40, 110, 180]).astype(np.uint8)
    return ilf.RGBDFrame(rgb, depth, ilf.Camera(60.0, 66.0, 30.2, 24.9), name="two-planes")


@pytest.fixture
def small_labels() -> np.ndarray:
    """Label map of `small_frame`: block 1 on the left, 2 on the right."""
    labels = np.ones((48, 64), np.int32)
    labels[:, 30:] = 2
    return labels


def pytest_collection_finish() -> None:
    """What the modules have made stays for good: collecting garbage need not look through it after every test."""
    gc.collect()
    gc.freeze()
