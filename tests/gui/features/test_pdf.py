"""The pages of a printed report."""

import pytest
from PySide6.QtGui import QTextDocument, QTextFormat

from gui.features.export import pdf
from ilf.report.report import Report

PICTURE = "data:image/svg+xml;utf8,<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'/>"
WITH_TEXT = "<h2>Title</h2><p>text</p>"
WITH_PICTURE = (
    f'<h2>Title</h2><table><tr><td><h3>Picture</h3><img src="{PICTURE}" width="100" height="100"></td></tr></table>'
)


@pytest.mark.parametrize(("what", "lines"), [(WITH_TEXT, 2), (WITH_PICTURE, 9)])
def test_a_heading_is_on_the_page_of_what_follows(qapp, monkeypatch, what, lines):
    begins = []

    class Document(QTextDocument):
        def print_(self, printer):
            block = self.begin()
            while block.text() != "Title":
                block = block.next()
            begins.append(block.blockFormat().pageBreakPolicy() == QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore)
            super().print_(printer)

    monkeypatch.setattr(pdf, "QTextDocument", Document)
    for before in range(30, 80):
        list(pdf.pdf_steps(Report("a report", ("<p>line</p>" * before + what,))))
    assert 0 < sum(begins) <= lines
