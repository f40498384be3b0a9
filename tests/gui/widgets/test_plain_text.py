"""Text from files is shown letter by letter, whatever it looks like."""

import re
from pathlib import Path

import pytest
from PySide6.QtGui import QTextDocument

import gui
from gui.widgets.basics import PlainLabel, literal_text

RICH = {
    "app/splash.py",
    "features/edit_summary.py",
    "features/extraction.py",
    "features/inspect/profile.py",
    "features/status.py",
}
"""Files that show text of their own as rich text, and escape what comes from elsewhere."""


def test_labels_are_plain_but_where_rich_text_is_meant():
    folder = Path(gui.__file__).parent
    found = {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*.py")
        if re.search(r"\bQLabel\(", path.read_text(encoding="utf-8"))
    }
    assert found == RICH


@pytest.mark.parametrize("text", ["<b>bold</b>", "a &lt;b", "plain", "a < b", "<img src='/etc/x'>\n  two  &amp; lines"])
def test_boxes_and_tips_show_text_as_it_is(text):
    document = QTextDocument()
    shown = literal_text(text)
    if shown == text:
        assert "<" not in text
        assert "&lt;" not in text
    else:
        document.setHtml(shown)
        assert document.toPlainText() == text


def test_a_label_shows_tags(qtbot):
    label = PlainLabel("<b>bold</b>")
    qtbot.addWidget(label)
    assert label.sizeHint().width() > label.fontMetrics().horizontalAdvance("bold</b>")
