"""Size of the code: lines without blanks, comments and docstrings, files, records, names that several classes have.

A record is a dataclass, a named tuple or a struct.
"""

import ast
import io
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
_NO_CODE = {*(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE), *(tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)}
_RECORDS = ("dataclass", "NamedTuple", "Struct")


def show_sizes() -> None:
    """Print a table of the program's packages, and of the tests, of which only lines and files count."""
    print(f"{'':10} {'lines':>7} {'files':>6} {'records':>8} {'class names more than once':>27}")
    for folders in (("ilf",), ("gui",), ("ilf", "gui"), ("tests",)):
        sources = [path.read_text("utf-8") for folder in folders for path in (ROOT / folder).rglob("*.py")]
        lines = sum(len(code_lines(source)) for source in sources)
        classes = [one for source in sources for one in _classes(source)]
        records = sum(is_record(one) for one in classes)
        repeated = sum(count > 1 for count in Counter(one.name for one in classes).values())
        of_classes = "" if folders == ("tests",) else f" {records:8} {repeated:27}"
        print(f"{' + '.join(folders):10} {lines:7} {len(sources):6}{of_classes}")


def code_lines(source: str) -> set[int]:
    """Return the numbers of the lines with code."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in _NO_CODE:
            lines.update(range(token.start[0], token.end[0] + 1))
    return lines - _docstring_lines(source)


def _docstring_lines(source: str) -> set[int]:
    """Return the lines of strings that stand alone: docstrings, and those below attributes."""
    alone = (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Expr))
    texts = (node for node in alone if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str))
    return {line for node in texts for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}


def _classes(source: str) -> Iterator[ast.ClassDef]:
    return (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ClassDef))


def is_record(one: ast.ClassDef) -> bool:
    """Return whether a class is a record by its decorators or bases."""
    said = " ".join(ast.unparse(part) for part in one.decorator_list + one.bases)
    return any(word in said for word in _RECORDS)
