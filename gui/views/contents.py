"""What a cell of the linked views can show: the names of contents, their titles and units. No Qt.

A content's name is that of a kind alone ("strength"), of a depth ("result", "run-2"), or of a difference with its two
depths ("difference:result:run-1"). Some stand for what is best as things are, and `Material.concrete` says what that
is: "difference", "judgement", and the two sides of a comparison, "a" and "b".
"""

from __future__ import annotations

RUNS = ("run-1", "run-2", "run-3", "run-4")
"""Depths of the runs that are ticked for comparison, in their order."""
EARLIER, INTERPOLATED = "earlier", "interpolated"
"""Depth of the kept run before the present result, and depth in with its holes interpolated: to compare with."""
DEPTHS = ("depth-in", "result", *RUNS, "truth", "guide")
"""Depths that a cell can show."""
COMPARABLE = (*DEPTHS, EARLIER, INTERPOLATED)
"""Depths that a difference can be of."""

DIFFERENCE, JUDGEMENT = "difference", "judgement"
SIDES = ("a", "b")

TITLES = {
    "colour": "Colour + blocks",
    "depth-in": "Depth in",
    "result": "Depth out",
    "truth": "Truth",
    "guide": "Guide, fitted",
    DIFFERENCE: "Difference",
    "error": "Error: result \N{MINUS SIGN} truth",
    "expected-error": "Expected error",
    "strength": "Edge strength",
    "creases": "Creases",
    "extraction": "Extraction",
    "guessed": "Guessed",
    "distrusted": "Distrusted",
    "spectrum": "Spectrum",
}
"""Titles of the contents that need no more than their name."""

_SHORT = {"depth-in": "depth in", "result": "result", "truth": "truth", "guide": "guide", INTERPOLATED: "interpolated"}


def difference_of(first: str, second: str) -> str:
    """Name of the difference of two depths: the first less the second.

    Examples
    --------
    >>> difference_of("result", "run-1")
    'difference:result:run-1'
    """
    return f"{DIFFERENCE}:{first}:{second}"


def compared_by(content: str) -> tuple[str, str] | None:
    """The two depths of a difference; None for other contents.

    Examples
    --------
    >>> compared_by("difference:truth:result")
    ('truth', 'result')
    >>> compared_by("error")
    ('result', 'truth')
    """
    if content == "error":
        return "result", "truth"
    kind, *depths = content.split(":")
    return (depths[0], depths[1]) if kind == DIFFERENCE and len(depths) == 2 else None


def checked(content: str) -> str:
    """The same name; raises ValueError if it is none of a content."""
    pair = compared_by(content)
    if content in (*TITLES, *DEPTHS, JUDGEMENT, *SIDES) or (pair and set(pair) <= set(COMPARABLE)):
        return content
    raise ValueError(f"a cell cannot show {content!r}; it can show {', '.join((*TITLES, *RUNS, *SIDES))}")


def short_title(depth: str, names: dict[str, str]) -> str:
    """What a depth is called in the title of a difference; `names` are those of runs."""
    return names.get(depth) or _SHORT.get(depth) or depth.replace("-", " ")


def capital(text: str) -> str:
    """The same text with a capital letter at its beginning, all others as they are.

    Examples
    --------
    >>> capital("run of Tuesday")
    'Run of Tuesday'
    """
    return text[:1].upper() + text[1:]
