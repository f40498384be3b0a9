"""What runs were made with, in words: their names, and what the list of kept runs says of them. No widgets."""

from __future__ import annotations

from functools import lru_cache

from ilf.data.parameters import Parameters, in_words, likeness
from ilf.project.frame_state import own_values
from ilf.run.run import Run

from .session import Session

_IN_NAMES = 2
"""Values that a name has at most."""


def values_text(session: Session, run: Run, most: int | None = None) -> str:
    """The nearest preset, what differs from it, and what blocks have of their own; `most` values of each at most."""
    texts = [_likeness_text(run.parameters, most)]
    own = {label: _own_words(parameters, run.parameters, most) for label, parameters in run.own.items()}
    own = {label: words for label, words in own.items() if words}
    if most is not None and len(own) > 1:
        return f"{texts[0]}; {len(own)} blocks with own values"
    texts += [f"{session.info(label).name}: {words}" for label, words in own.items()]
    return "; ".join(texts)


def run_name(session: Session, number: int, run: Run, edit: str = "", live: bool = False) -> str:
    """What a kept run is called at first: its number, what was edited before it if it came of that, and its values."""
    what = "; ".join(([edit] if edit else []) + [values_text(session, run, _IN_NAMES)])
    return f"{'Live' if live else 'Run'} {number}: {what}"


def title_of(name: str, session: Session, run: Run) -> str:
    """A name without the values that it was given at first; as it is, if they are not in it."""
    return name.removesuffix(values_text(session, run, _IN_NAMES)).rstrip(":; ") or name


# every row asks for these whenever the list changes


@lru_cache(maxsize=512)
def _likeness_text(parameters: Parameters, most: int | None) -> str:
    return likeness(parameters).text(most)


@lru_cache(maxsize=2048)
def _own_words(parameters: Parameters, common: Parameters, most: int | None) -> str:
    return ", ".join(in_words(own_values(parameters, common), most))
