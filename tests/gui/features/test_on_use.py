"""Features whose dialogs are seldom needed are made by the first of their commands, once."""

from __future__ import annotations

import subprocess
import sys

import pytest
from pytestqt.qtbot import QtBot

from gui.app.main_window import MainWindow
from gui.features.palette.palette import PaletteFeature

NOT_AT_START = "batch.feature", "batch.dialog", "report.feature", "sweep.feature", "live", "export_all"


def test_the_first_command_makes_the_feature(qtbot: QtBot) -> None:
    window = MainWindow(persistent=False)
    qtbot.addWidget(window)
    window.show()

    def made() -> list[PaletteFeature]:
        return [feature for feature in window.features if isinstance(feature, PaletteFeature)]

    assert made() == []
    window.actions_["palette"].trigger()
    (feature,) = made()
    assert feature.palette.isVisible()
    window.actions_["palette"].trigger()
    assert made() == [feature]
    assert not feature.palette.isVisible()


@pytest.fixture(scope="module")
def imported_at_start() -> set[str]:
    code = "import sys, gui.app.main_window; print(*sys.modules)"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


@pytest.mark.parametrize("name", NOT_AT_START)
def test_what_is_seldom_used_is_not_imported_at_the_start(imported_at_start: set[str], name: str) -> None:
    assert "gui.features.views" in imported_at_start
    assert f"gui.features.{name}" not in imported_at_start
