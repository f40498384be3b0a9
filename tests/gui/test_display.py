"""What is said where no window can be shown."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gui import display
from gui.app import main


@pytest.fixture
def bare_linux(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A Linux machine without a display, all libraries there."""
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(display.ctypes, "CDLL", lambda name: None)
    return monkeypatch


def _lacking(*names: str):
    def load(name: str) -> None:
        if name in names:
            raise OSError(name)

    return load


def test_no_display(bare_linux: pytest.MonkeyPatch) -> None:
    assert "no display" in display.display_problem()


@pytest.mark.parametrize("name", ["DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"])
def test_a_display_or_a_platform_that_was_asked_for(bare_linux: pytest.MonkeyPatch, name: str) -> None:
    bare_linux.setenv(name, "something")
    assert display.display_problem() == ""


def test_missing_libraries_are_named_with_their_packages(bare_linux: pytest.MonkeyPatch) -> None:
    bare_linux.setattr(display.ctypes, "CDLL", _lacking("libEGL.so.1"))
    assert "libEGL.so.1" in display.display_problem()
    assert "apt install libegl1" in display.display_problem()


def test_missing_x11_libraries_matter_under_x11_only(bare_linux: pytest.MonkeyPatch) -> None:
    bare_linux.setattr(display.ctypes, "CDLL", _lacking("libxcb-icccm.so.4", "libxcb-keysyms.so.1"))
    bare_linux.setenv("DISPLAY", ":0")
    assert "libxcb-icccm4 libxcb-keysyms1" in display.display_problem()
    bare_linux.setenv("QT_QPA_PLATFORM", "offscreen")
    assert display.display_problem() == ""


def test_without_display_the_sample_is_completed_by_the_command_line(
    bare_linux: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    called: list[list[str]] = []

    def command_line(arguments: list[str]) -> int:
        called.append(arguments)
        return 0

    bare_linux.setattr("ilf.cli.main", command_line)
    assert main(["--sample"]) == 0
    assert called[0][0] == "complete"
    assert called[0][1].endswith("room")
    assert "no display" in capsys.readouterr().err
    assert main([]) == 1
    assert "ilf complete" in capsys.readouterr().err


def test_the_command_line_takes_over_without_importing_qt(tmp_path: Path) -> None:
    """Where libraries that Qt needs are missing, importing it would fail before anything could be said."""
    program = (
        "import sys\n"
        "sys.modules['PySide6'] = None\n"
        "from gui import display\n"
        "from gui.app import main\n"
        "display._missing = lambda libraries: {'libEGL.so.1': 'libegl1'}\n"
        "sys.platform = 'linux'\n"
        f"sys.exit(main([{str(tmp_path)!r}]))\n"
    )
    root = Path(__file__).resolve().parents[2]
    environment = os.environ | {"PYTHONPATH": str(root)}
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=False)
    assert run.returncode == 1
    assert "apt install libegl1" in run.stderr
    assert "Running this instead: ilf complete" in run.stderr
    assert "meta.json" in run.stderr, "the empty folder is refused by the command line, in words"
    assert "Traceback" not in run.stderr
