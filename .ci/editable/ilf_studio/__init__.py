"""The window by the name that it has in the wheel, for editable installs: its modules are those of the folder `gui`."""

from pathlib import Path

__path__ = [str(Path(__file__).resolve().parents[3] / "gui")]
