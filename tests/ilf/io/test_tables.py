"""Tables as CSV: spreadsheets take no cell for a formula, and numbers stay numbers."""

import csv
import io
import re

import pytest

from ilf.io.tables import csv_text, write_csv


@pytest.mark.parametrize(
    "text", ["=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1+1", "\r=1+1", " =1+1", "-2+3;4", "＝1+1", "=cmd|' /C calc'!A0"]
)
def test_what_would_be_a_formula_stands_behind_an_apostrophe(text):
    ((cell,),) = csv.reader(io.StringIO(csv_text([[text]]), newline=""))
    assert cell.startswith("'")
    assert cell.replace("'", "") == text.replace("'", "").replace("\r", "\n")


@pytest.mark.parametrize("text", ["a;=1+1", "a\t=1+1", "a\n=1+1", "a\r@SUM(A1)"])
def test_nor_is_one_behind_what_divides_cells_elsewhere(text):
    ((cell,),) = csv.reader(io.StringIO(csv_text([[text]]), newline=""))
    assert re.search(r"[;\t\r\n][=@]", cell) is None


@pytest.mark.parametrize("name", ["x", "a-b", "1+1", "2025-01-01", "a=b, c@d", "it's", "a; b", "–", ""])
def test_other_texts_stay_as_they_are(name):
    ((cell, _),) = csv.reader(io.StringIO(csv_text([[name, 1]]), newline=""))
    assert cell == name


def test_numbers_stay_numbers():
    assert csv_text([[-1, -0.25, "-1.50000", "+2", None, float("-inf"), True]]) == "-1,-0.25,-1.50000,+2,,-inf,True\n"


def test_a_name_that_is_no_text_can_be_written(tmp_path):
    write_csv(tmp_path / "table.csv", [["name"], ["\udce9"]])
    assert (tmp_path / "table.csv").read_text() == "name\n\\udce9\n"
