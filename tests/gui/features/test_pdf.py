"""The pages of a printed report."""

import pytest
from PySide6.QtCore import QSizeF
from PySide6.QtGui import QTextDocument

from gui.features.export import pdf
from ilf.report.report import Report

PICTURE = "data:image/svg+xml;utf8,<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'/>"
WITH_TEXT = "<h2>Title</h2><p>text</p>"
WITH_PICTURE = (
    f'<h2>Title</h2><table><tr><td><h3>Picture</h3><img src="{PICTURE}" width="100" height="100"></td></tr></table>'
)


@pytest.fixture
def printed(qapp, monkeypatch):
    """Print a part of a report; return the document as it is laid out, and the number of the page that a height is on,
    where what is below the lower margin is on the next one."""
    found = []

    class Document(QTextDocument):
        def print_(self, printer):
            self.documentLayout().setPaintDevice(printer)
            margins = self.rootFrame().frameFormat()
            margins.setMargin(pdf._MARGIN)
            self.rootFrame().setFrameFormat(margins)
            self.setPageSize(QSizeF(printer.width(), printer.height()))
            found.append(self)
            self.height, self.margin = printer.height(), pdf._MARGIN * printer.logicalDpiY() / 96

    monkeypatch.setattr(pdf, "QTextDocument", Document)

    def print_(part: str):
        pdf.pdf_of(Report("a report", (part,)))
        document = found.pop()
        return document, lambda height: (height + document.margin) // document.height

    return print_


@pytest.mark.parametrize("what", [WITH_TEXT, WITH_PICTURE])
def test_a_heading_is_on_the_page_of_what_follows(printed, what):
    pages = set()
    for before in range(30, 80):
        document, page = printed("<p>line</p>" * before + what)
        block = document.begin()
        while block.text() != "Title":
            block = block.next()
        following = []
        while block.isValid():
            following.append(document.documentLayout().blockBoundingRect(block).bottom() - 1)
            block = block.next()
        assert len({page(height) for height in following}) == 1, f"after {before} lines"
        pages.add(page(following[0]))
    assert pages == {0, 1}


def test_no_page_ends_within_a_row(printed):
    row = "<tr><td><p>Run 1</p><p>2026-01-01, best</p><p>note</p></td><td>2</td></tr>"
    for before in range(3):
        document, page = printed("<p>line</p>" * before + f"<table>{row * 40}</table>")
        table = document.rootFrame().childFrames()[0]
        for number in range(table.rows()):
            cell = table.cellAt(number, 0)
            ends = cell.firstCursorPosition().block(), cell.lastCursorPosition().block()
            rects = map(document.documentLayout().blockBoundingRect, ends)
            assert len({page(rect.center().y()) for rect in rects}) == 1, f"row {number} after {before} lines"
        assert page(document.documentLayout().blockBoundingRect(document.lastBlock()).bottom()) > 0
