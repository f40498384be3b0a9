"""Features whose dialogs are seldom needed are made by the first of their commands, once."""

import subprocess
import sys
from importlib.util import find_spec

from gui.app.main_window import MainWindow
from gui.features.palette import PaletteFeature

NOT_AT_START = {f"gui.features.{name}" for name in ("export.feature", "palette", "sequence.live", "sweep.feature")}


def test_the_first_command_makes_the_feature(shown):
    window = shown(MainWindow(persistent=False))

    def made() -> list[PaletteFeature]:
        return [feature for feature in window.features if isinstance(feature, PaletteFeature)]

    assert made() == []
    window.actions_["palette"].trigger()
    (feature,) = made()
    assert feature.palette.isVisible()
    window.actions_["palette"].trigger()
    assert made() == [feature]
    assert not feature.palette.isVisible()


def test_what_is_seldom_used_is_not_imported_at_the_start():
    assert all(find_spec(name) for name in NOT_AT_START)
    code = "import sys, gui.app.main_window; print(*sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "gui.features.views" in told
    assert NOT_AT_START.isdisjoint(told)
