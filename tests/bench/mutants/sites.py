"""Possible faults in the functions of a file, and a sample of them."""

import ast
import difflib
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

_SLIPS = (
    *((ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.FloorDiv, ast.Mult), (ast.Mod, ast.FloorDiv), (ast.Pow, ast.Mult)),
    *((ast.BitOr, ast.BitAnd), (ast.BitXor, ast.BitAnd), (ast.And, ast.Or), (ast.Break, ast.Continue)),
    *((ast.Eq, ast.NotEq), (ast.Lt, ast.LtE), (ast.Lt, ast.GtE), (ast.Gt, ast.GtE), (ast.Gt, ast.LtE)),
    *((ast.Is, ast.IsNot), (ast.In, ast.NotIn)),
)
"""What is taken for each other."""

_NEVER = ast.Constant(False)
"""Before what is left out, so that the function refers to the same names around it."""


@dataclass(frozen=True, order=True)
class Mutant:
    """One fault.

    Attributes
    ----------
    path : str
        Path of the file, relative to the root of the tree.
    first, last : int
        Lines of the statement with the fault, from 1, without its block.
    number : int
        Number of the fault in the file, from 0.
    """

    path: str
    first: int
    last: int
    number: int

    def tree(self, source: str) -> ast.Module:
        """Return the file with the fault."""
        tree = ast.parse(source)
        _, put = list(_places(tree))[self.number]
        put()
        return ast.fix_missing_locations(tree)

    def diff(self, source: str) -> str:
        """Return the changed lines, as `ast.unparse` writes them."""
        texts = (ast.unparse(tree).splitlines() for tree in (ast.parse(source), self.tree(source)))
        changed = list(difflib.unified_diff(*texts, n=0, lineterm=""))[3:]
        return "\n".join([f"{self.path}:{self.first}", *changed])


def mutants_of(tree: Path, path: str) -> list[Mutant]:
    """Return all possible faults in the functions of a file."""
    parsed = ast.parse((tree / path).read_text(encoding="utf-8"))
    spans = sorted(
        (_head(node) for node in ast.walk(parsed) if isinstance(node, ast.stmt)), key=lambda of: of[1] - of[0]
    )
    found = []
    for number, (line, _) in enumerate(_places(parsed)):
        first, last = next(span for span in spans if span[0] <= line <= span[1])
        found.append(Mutant(path, first, last, number))
    return found


def sample(tree: Path, files: Sequence[str], size: int, seed: int) -> list[Mutant]:
    """Sample faults in different statements. The same seed gives the same faults for the same files."""
    rng, statements = random.Random(seed), {}
    for path in files:
        for mutant in mutants_of(tree, path):
            statements.setdefault((path, mutant.first), []).append(mutant)
    chosen = rng.sample(sorted(statements), min(size, len(statements)))
    return [rng.choice(statements[place]) for place in chosen]


def _head(node: ast.stmt) -> tuple[int, int]:
    """First and last line of a statement, without its block."""
    body = getattr(node, "body", None)
    return node.lineno, max(node.lineno, body[0].lineno - 1) if body else node.end_lineno or node.lineno


def _places(tree: ast.Module) -> Iterator[tuple[int, Callable[[], None]]]:
    """Every fault that is possible in a function: its line, and what makes it in the tree."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    nodes = dict.fromkeys(node for function in functions for part in function.body for node in ast.walk(part))
    outermost = {function: None for function in functions if function not in nodes}
    for parent in (*outermost, *nodes):
        for name in ("body",) if parent in outermost else parent._fields:
            value = getattr(parent, name, None)
            for at, node in enumerate(value if isinstance(value, list) else [value]):
                for other in _others(node):
                    yield getattr(node, "lineno", 0) or parent.lineno, partial(_put, parent, name, at, other)


def _put(parent: ast.AST, name: str, at: int, other: Any) -> None:
    value = getattr(parent, name)
    if isinstance(value, list):
        value[at] = ast.copy_location(other, value[at])
    else:
        setattr(parent, name, ast.copy_location(other, value))


def _others(node: Any) -> Iterator[ast.AST]:
    """What may stand in the place of a node by a slip."""
    for one, other in _SLIPS:
        if isinstance(node, one | other):
            yield other() if isinstance(node, one) else one()
    match node:
        case ast.UnaryOp(op=ast.Not() | ast.USub() | ast.Invert(), operand=operand):
            yield operand
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value) | float(value)):
            yield ast.Constant(value + 1)
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test):
            yield type(node)(**{**vars(node), "test": ast.UnaryOp(ast.Not(), test)})
        case ast.For():
            yield ast.For(**{**vars(node), "iter": ast.IfExp(_NEVER, node.iter, ast.Tuple([], ast.Load()))})
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            yield ast.If(_NEVER, [node], [])
