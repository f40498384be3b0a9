"""The pages of a printed report."""

import pytest
from PySide6.QtCore import QSizeF
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
        pdf.pdf_of(Report("a report", ("<p>line</p>" * before + what,)))
    assert 0 < sum(begins) <= lines


def test_no_page_ends_within_a_row(qapp, monkeypatch):
    torn = []

    class Document(QTextDocument):
        def print_(self, printer):
            self.documentLayout().setPaintDevice(printer)
            margins = self.rootFrame().frameFormat()
            margins.setMargin(pdf._MARGIN)
            self.rootFrame().setFrameFormat(margins)
            self.setPageSize(QSizeF(printer.width(), printer.height()))
            table = self.rootFrame().childFrames()[0]
            for row in range(table.rows()):
                cell = table.cellAt(row, 0)
                blocks = cell.firstCursorPosition().block(), cell.lastCursorPosition().block()
                rects = map(self.documentLayout().blockBoundingRect, blocks)
                first, last = (rect.center().y() // printer.height() for rect in rects)
                torn.append(first != last)

    monkeypatch.setattr(pdf, "QTextDocument", Document)
    row = "<tr><td><p>Run 1</p><p>2026-01-01, best</p><p>note</p></td><td>2</td></tr>"
    for before in range(3):
        pdf.pdf_of(Report("a report", ("<p>line</p>" * before + f"<table>{row * 40}</table>",)))
    assert not any(torn)
    assert len(torn) == 120
