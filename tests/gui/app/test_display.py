"""What is said where no window can be shown, and which libraries Qt needs."""

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import ilf
from gui.app.start import main
from gui.base import display
from ilf._runtime.installation import asset_path, system_package

ROOT = Path(__file__).resolve().parents[3]
X11 = ("libX11-xcb.so.1", "libxcb-cursor.so.0", "libxkbcommon-x11.so.0")


@pytest.fixture
def bare_linux(lacking, monkeypatch):
    """A Linux machine without a display, all libraries there."""
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(display.ctypes, "CDLL", x_server(1))
    lacking()
    return monkeypatch


@pytest.fixture
def lacking(monkeypatch, tmp_path):
    """Lets the plugin of a platform lack libraries of the system, as `ldd` tells it."""
    if not sys.platform.startswith("linux"):
        pytest.skip("Qt needs libraries of the system under Linux only")
    (tmp_path / "bin").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=os.pathsep)

    def lack(platform: str = "", *libraries: str) -> None:
        told = "".join(f"\t{name} => not found\n" for name in libraries)
        there = f"case \"$*\" in *libq{platform}*) printf '{told}';; esac\n" if libraries else ""
        (tmp_path / "bin" / "ldd").write_text(f"#!/bin/sh\n{there}")
        (tmp_path / "bin" / "ldd").chmod(0o755)

    return lack


def x_server(connection: int | None):
    return lambda _: SimpleNamespace(XOpenDisplay=lambda name: connection, XCloseDisplay=lambda display: 0)


def test_no_display(bare_linux):
    assert display.display_problem().endswith("there is no display. Set DISPLAY or WAYLAND_DISPLAY.")


def test_all_that_a_bare_machine_lacks_is_named_at_once(bare_linux, lacking):
    lacking("xcb", *X11)
    told = [display.display_problem()]
    bare_linux.setenv("DISPLAY", ":0")
    told.append(display.display_problem())
    for problem in told:
        assert set(problem.rpartition("apt install ")[2].rstrip(".").split()) == set(map(system_package, X11))
    assert "no display" in told[0]


@pytest.mark.parametrize(
    ("name", "value"),
    [("DISPLAY", ":0"), ("WAYLAND_DISPLAY", "wayland-0"), ("QT_QPA_PLATFORM", "offscreen:size=800x600")],
)
def test_a_display_or_a_platform_that_was_asked_for(bare_linux, name, value):
    bare_linux.setenv(name, value)
    assert display.display_problem() == ""


def test_x11_libraries_matter_under_x11_only(bare_linux, lacking):
    lacking("xcb", "libxcb-cursor.so.0")
    bare_linux.setenv("DISPLAY", ":0")
    assert display.qt_problem() == ""
    assert "apt install libxcb-cursor0" in display.display_problem()
    bare_linux.setenv("QT_QPA_PLATFORM", "offscreen")
    assert display.display_problem() == ""
    bare_linux.setenv("QT_QPA_PLATFORM", "xcb")
    assert "libxcb-cursor.so.0" in display.display_problem()
    bare_linux.delenv("QT_QPA_PLATFORM")
    bare_linux.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert display.display_problem() == "", "Qt takes the one that works"


def test_an_x_server_that_does_not_answer(bare_linux):
    bare_linux.setattr(display.ctypes, "CDLL", x_server(None))
    bare_linux.setenv("DISPLAY", ":4711")
    assert "':4711' does not respond" in display.display_problem()
    bare_linux.setenv("QT_QPA_PLATFORM", "offscreen")
    assert display.display_problem() == ""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Qt needs these libraries under Linux")
def test_nothing_is_said_where_qt_works(monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    assert (display.qt_problem(), display.display_problem()) == ("", "")


@pytest.mark.parametrize(
    ("library", "package"),
    [
        ("libEGL.so.1", "libegl1"),
        ("libX11-xcb.so.1", "libx11-xcb1"),
        ("libdbus-1.so.3", "libdbus-1-3"),
        ("libwayland-egl.so.1", "libwayland-egl1"),
        ("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
        ("libglib-2.0.so.0", "libglib2.0-0"),
        ("libz.so.1", "zlib1g"),
    ],
)
def test_the_package_of_a_library(library, package):
    assert system_package(library) == package


@pytest.mark.parametrize("arguments", [["--sample"], [], [str(asset_path("samples")), "--frame", "room"]])
def test_without_display_one_line_says_what_to_do(bare_linux, capsys, arguments):
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no display" in error
    assert error.endswith(". Without a window: ilf complete --help.\n")


def test_a_frame_is_found_by_its_key_alone(bare_linux, capsys):
    samples = str(asset_path("samples"))
    assert main([samples, "--frame", "hall"]) == 1
    assert "hall" in capsys.readouterr().err.splitlines()[-1]
    for arguments in ([samples, samples, "--frame", "room"], [samples, "--sample", "--frame", "room"]):
        with pytest.raises(SystemExit):
            main(arguments)


@pytest.mark.parametrize("arguments", [["gone/rgb.png", "gone/depth.png"], ["gone"], ["--live", "gone"]])
def test_a_missing_path_is_told_before_anything_else(arguments, bare_linux, capsys):
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert error.startswith("ilf-gui: error: gone")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("platform", "libraries", "packages"),
    [
        ("offscreen", ("libEGL.so.1", "libxkbcommon.so.0"), "libegl1 libxkbcommon0"),
        ("xcb", ("libxcb-sync.so.1",), "libxcb-sync1"),
    ],
)
def test_a_picture_that_qt_cannot_make_is_one_line(
    bare_linux, lacking, capsys, tmp_path, platform, libraries, packages
):
    lacking(platform, *libraries)
    bare_linux.setenv("QT_QPA_PLATFORM", platform.replace("offscreen", ""))
    assert main(["--sample", "--run", "--screenshot", str(tmp_path / "x.png")]) == 1
    error = capsys.readouterr().err
    assert f"apt install {packages}" in error
    assert error.count("\n") == 1


def _child(program: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
    )  # fmt: skip


@pytest.mark.parametrize("package", ["PySide6", "pyqtgraph"])
def test_a_package_that_is_not_installed_is_named_with_its_extra(package):
    run = _child(
        f"import sys\nsys.modules[{package!r}] = None\nfrom gui.app.start import main\nsys.exit(main(['--sample']))\n",
        QT_QPA_PLATFORM="offscreen",
    )
    assert run.returncode == 1
    assert f"needs the package {package}, " in run.stderr
    assert 'pip install "ilf-studio[app]"' in run.stderr
    assert run.stderr.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_the_program_ends_quietly_while_it_is_still_importing():
    run = _child(
        "import os, signal, sys\n"
        "class AskedMeanwhile:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name.startswith('PySide6'):\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "            while True: pass\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "sys.meta_path.insert(0, AskedMeanwhile())\n"
        "from gui.app.start import main\n"
        "main(['--sample'])\n",
        QT_QPA_PLATFORM="offscreen",
    )
    assert (run.returncode, run.stderr) == (130, "ilf-gui: error: interrupted\n")


def test_something_is_shown_before_the_window_is_imported():
    run = _child(
        "import os, sys\n"
        "class Import:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'gui.app.main_window':\n"
        "            from PySide6.QtWidgets import QApplication\n"
        "            print([widget.isVisible() for widget in QApplication.topLevelWidgets()], flush=True)\n"
        "            os._exit(0)\n"
        "sys.meta_path.insert(0, Import())\n"
        "from gui.app.start import main\n"
        "main(['--sample'])\n",
        QT_QPA_PLATFORM="offscreen",
    )
    assert run.stdout == "[True]\n"


def test_the_version_and_what_is_missing_are_printed_without_importing_qt(tmp_path, bare_linux, lacking):
    """Where libraries that Qt needs are missing, importing it would fail before anything could be said."""
    lacking("offscreen", "libEGL.so.1")
    run = _child(
        "import sys\n"
        "from gui.app.start import main\n"
        "sys.platform = 'linux'\n"
        "try: main(['--version'])\n"
        "except SystemExit as end: print(end.code)\n"
        f"status = main([{str(tmp_path)!r}])\n"
        "sys.exit(2 if 'PySide6.QtCore' in sys.modules else status)\n",
        QT_QPA_PLATFORM="offscreen",
    )
    assert (run.returncode, run.stdout.split("\n")[:2]) == (1, [f"ilf-gui {ilf.__version__}", "0"])
    assert "apt install libegl1" in run.stderr
    assert "ilf complete" in run.stderr
    assert "Traceback" not in run.stderr
