"""The documents of the window name commands and keys that there are, and show pictures that there are."""

import re
from pathlib import Path

import pytest

from gui.app.main_window import MainWindow

DOCS = Path(__file__).parents[3] / "assets" / "docs"


@pytest.mark.parametrize("document", ["window.md", "tour.md"])
def test_the_documents_name_what_there_is(document, qtbot):
    text = " ".join((DOCS / document).read_text(encoding="utf-8").split())
    window = MainWindow(persistent=False)
    qtbot.addWidget(window)
    actions = {action.text().replace("&", "").rstrip("…"): action for action in window.actions() if action.text()}
    named = re.findall(r"\*([^*]+?)…?\* \(((?:Ctrl|Shift|F\d)[^)]*)\)", text)
    assert len(named) >= 6
    unknown = [(name, keys) for name, keys in named if name.split(" > ")[-1] not in {*actions, *PANELS}]
    assert unknown == []
    for name, keys in named:
        action = actions[PANELS.get(name, name.split(" > ")[-1])]
        assert keys in [sequence.toString() for sequence in action.shortcuts()], name
    for picture in re.findall(r"\]\((images/[^)]+)\)", text):
        assert (DOCS / picture).stat().st_size > 10_000
    window.close()


PANELS = {"Runs": "Run history"}
"""A panel that the tour names by its title, and the command that opens it."""
