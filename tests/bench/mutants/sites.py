"""Possible faults in a file, and a sample of them. The operators are those of cosmic-ray."""

import ast
import difflib
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import islice, zip_longest
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

_BINARY = {
    "Add": ("Sub",),
    "Sub": ("Add",),
    "Mul": ("Div", "Add"),
    "Div": ("Mul",),
    "FloorDiv": ("Div", "Mul"),
    "Mod": ("FloorDiv",),
    "Pow": ("Mul",),
    "LShift": ("RShift",),
    "RShift": ("LShift",),
    "BitOr": ("BitAnd",),
    "BitAnd": ("BitOr",),
    "BitXor": ("BitAnd",),
}
_COMPARISONS = {
    "Eq": ("NotEq",),
    "NotEq": ("Eq",),
    "Lt": ("LtE", "GtE"),
    "LtE": ("Lt", "Gt"),
    "Gt": ("GtE", "LtE"),
    "GtE": ("Gt", "Lt"),
    "Is": ("IsNot",),
    "IsNot": ("Is",),
}
# most of the twelve and eight replacements of an operator fail at once and give no information about the tests
OPERATORS = (
    *(f"core/ReplaceBinaryOperator_{old}_{new}" for old, others in _BINARY.items() for new in others),
    *(f"core/ReplaceComparisonOperator_{old}_{new}" for old, others in _COMPARISONS.items() for new in others),
    "core/ReplaceUnaryOperator_USub_UAdd",
    "core/ReplaceUnaryOperator_Delete_Invert",
    "core/ReplaceUnaryOperator_Delete_Not",
    "core/AddNot",
    "core/ReplaceTrueWithFalse",
    "core/ReplaceFalseWithTrue",
    "core/ReplaceAndWithOr",
    "core/ReplaceOrWithAnd",
    "core/ReplaceBreakWithContinue",
    "core/ReplaceContinueWithBreak",
    "core/ExceptionReplacer",
    "core/NumberReplacer",
    "core/RemoveDecorator",
    "core/ZeroIterationForLoop",
)


@dataclass(frozen=True, order=True)
class Mutant:
    """One fault: an operator applied at one place of a file.

    Attributes
    ----------
    path : str
        Path of the file, relative to the root of the tree.
    line : int
        Line of the fault, from 1.
    operator : str
        Name of cosmic-ray's operator.
    occurrence : int
        Number of the place in the file, from 0.
    """

    path: str
    line: int
    operator: str
    occurrence: int

    def code(self, source: str) -> str:
        """Return the file with the fault."""
        return str(mutate_code(source, get_operator(self.operator)(), self.occurrence))

    def diff(self, source: str) -> str:
        """Return the changed lines."""
        lines = difflib.unified_diff(
            source.splitlines(), self.code(source).splitlines(), self.path, self.path, lineterm="", n=1
        )
        return "\n".join(lines)


def mutants_of(tree: Path, path: str) -> list[Mutant]:
    """Return all possible faults in a file, except in annotations and other code that is not run."""
    source = (tree / path).read_text(encoding="utf-8")
    left_out = [*_annotations(source), *_keyword_markers(source)]
    return [
        Mutant(path, line, operator, occurrence)
        for operator in OPERATORS
        for occurrence, (line, column) in enumerate(_places(source, operator))
        if not any(start <= (line, column) < end for start, end in left_out)
    ]


def sample(tree: Path, files: Sequence[str], size: int, seed: int) -> list[Mutant]:
    """Sample faults over the files in proportion to their lines, each on a different line while possible.

    The same seed gives the same faults for the same files; the faults of a file do not depend on other files, except
    for their number.
    """
    mutants = {path: found for path in files if (found := mutants_of(tree, path))}
    lines = {path: (tree / path).read_text(encoding="utf-8").count("\n") for path in mutants}
    chosen: list[Mutant] = []
    for path, share in _shares(lines, size, random.Random(seed)).items():
        source = (tree / path).read_text(encoding="utf-8")
        rng = random.Random(f"{seed}:{path}")
        by_line: dict[int, list[Mutant]] = {}
        for mutant in rng.sample(mutants[path], len(mutants[path])):
            by_line.setdefault(mutant.line, []).append(mutant)
        columns = [by_line[line] for line in rng.sample(sorted(by_line), len(by_line))]
        # one of every line, then a second of every line that has two, and so on
        in_turn = (mutant for turn in zip_longest(*columns) for mutant in turn if mutant is not None)
        chosen += islice((mutant for mutant in in_turn if _is_other(mutant, source)), share)
    return chosen


def _shares(lines: dict[str, int], size: int, rng: random.Random) -> dict[str, int]:
    """Return whole numbers that add up to the size, each its exact share of the lines rounded up or down; with many
    files most shares are less than one, and those that are rounded up are random."""
    total, shares = sum(lines.values()), {}
    before = rng.randrange(total)
    for path in rng.sample(list(lines), len(lines)):
        after = before + size * lines[path]
        shares[path] = after // total - before // total
        before = after
    return shares


@cache
def _tree(source: str) -> Any:
    return get_ast(source)


def _places(source: str, operator: str) -> Iterator[tuple[int, int]]:
    """Return line and column of every place where the operator applies, in cosmic-ray's order."""
    applies = get_operator(operator)()
    for node in ast_nodes(_tree(source)):
        for start, _ in applies.mutation_positions(node):
            yield start


def _annotations(source: str) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    for node in ast.walk(ast.parse(source)):
        for name in ("annotation", "returns"):
            part = getattr(node, name, None)
            if part is not None:
                yield (part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset)


def _keyword_markers(source: str) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Return the bare stars of parameter lists, which are not multiplications."""
    for node in ast_nodes(_tree(source)):
        if node.type == "operator" and node.value == "*" and node.parent.type in ("parameters", "lambdef"):
            yield node.start_pos, node.end_pos


def _is_other(mutant: Mutant, source: str) -> bool:
    """Return whether the result is valid Python and differs from the original."""
    try:
        return ast.dump(ast.parse(mutant.code(source))) != ast.dump(ast.parse(source))
    except (SyntaxError, AttributeError):  # cosmic-ray fails to replace an exception that is named with its module
        return False
