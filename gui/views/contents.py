"""Names of the contents of the linked views. No Qt.

A content's name is a kind ("strength"), a depth ("result", "run-2"), or a difference with its two depths
("difference:result:run-1"). Some names depend on the data and are resolved by `ViewData.concrete`: "difference",
"evaluation", and the two sides of a comparison, "a" and "b".
"""

from __future__ import annotations

RUNS = ("run-1", "run-2", "run-3", "run-4")
"""Depths of the runs ticked for comparison, in their order."""
EARLIER, INTERPOLATED = "earlier", "interpolated"
"""Depth of the stored run before the current result, and depth in with interpolated holes: to compare with."""
BEFORE_IN, BEFORE_OUT = "before-in", "before-out"
"""Depth in and depth out of the frame before, where the current frame shows their points."""
DEPTHS = ("depth-in", "result", *RUNS, "ground_truth", "guide")
"""Depths that a cell can show."""
COMPARABLE = (*DEPTHS, EARLIER, INTERPOLATED)
"""Depths that a difference can be of."""

DIFFERENCE, EVALUATION = "difference", "evaluation"
FLICKERS = {"flicker": ("result", BEFORE_OUT), "flicker-in": ("depth-in", BEFORE_IN)}
"""Differences against the frame before, and their two depths."""
_NAMED = {"error": ("result", "ground_truth"), **FLICKERS}
"""Differences with a name of their own."""
SIDES = ("a", "b")

_SHORT = {BEFORE_IN: "the frame before", BEFORE_OUT: "the frame before"}


def difference_of(first: str, second: str) -> str:
    """Name of the difference of two depths: the first minus the second.

    Examples
    --------
    >>> difference_of("result", "run-1")
    'difference:result:run-1'
    """
    return f"{DIFFERENCE}:{first}:{second}"


def operands_of(content: str) -> tuple[str, str] | None:
    """The two depths of a difference; None for other contents.

    Examples
    --------
    >>> operands_of("difference:ground_truth:result")
    ('ground_truth', 'result')
    >>> operands_of("error")
    ('result', 'ground_truth')
    """
    if content in _NAMED:
        return _NAMED[content]
    kind, *depths = content.split(":")
    return (depths[0], depths[1]) if kind == DIFFERENCE and len(depths) == 2 else None


def short_title(depth: str, names: dict[str, str]) -> str:
    """Short name of a depth in the title of a difference; `names` are those of runs."""
    return names.get(depth) or _SHORT.get(depth) or depth.replace("-", " ").replace("_", " ")


def capital(text: str) -> str:
    """Capitalise the first letter of a text and leave the others as they are.

    Examples
    --------
    >>> capital("run of Tuesday")
    'Run of Tuesday'
    """
    return text[:1].upper() + text[1:]
