"""Features whose dialogs are seldom needed are imported by the first of their commands."""

import subprocess
import sys
from importlib.util import find_spec

NOT_AT_START = {f"gui.features.{name}" for name in ("export.feature", "sequence.live", "sweep.feature")}


def test_what_is_seldom_used_is_not_imported_at_the_start():
    assert all(find_spec(name) for name in NOT_AT_START)
    code = "import sys, gui.app.main_window; print(*sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "gui.features.views" in told
    assert NOT_AT_START.isdisjoint(told)
