"""Names of runs and descriptions of their parameters, for the run history. No widgets."""

from __future__ import annotations

from functools import lru_cache

from ilf.data.parameters import Parameters, nearest_preset, to_text
from ilf.project.frame_state import own_values
from ilf.run.run import Run

from .session import Session

_IN_NAMES = 2
"""Maximum number of parameters in a name."""


def parameters_text(session: Session, run: Run, max_values: int | None = None) -> str:
    """Return the nearest preset, the parameters that differ from it and own parameters of blocks; `max_values` of
    each."""
    texts = [_likeness_text(run.parameters, max_values)]
    own = {label: _own_words(parameters, run.parameters, max_values) for label, parameters in run.own.items()}
    own = {label: words for label, words in own.items() if words}
    if max_values is not None and len(own) > 1:
        return f"{texts[0]}; {len(own)} blocks with own parameters"
    texts += [f"{session.info(label).name}: {words}" for label, words in own.items()]
    return "; ".join(texts)


def run_name(session: Session, number: int, run: Run, edit: str = "", live: bool = False) -> str:
    """Return the default name of a run: its number, the edit that started it if any, and its parameters."""
    what = "; ".join(([edit] if edit else []) + [parameters_text(session, run, _IN_NAMES)])
    return f"{'Live' if live else 'Run'} {number}: {what}"


def title_of(name: str, session: Session, run: Run) -> str:
    """Return a name without the parameters of its default name; unchanged if they are not in it."""
    return name.removesuffix(parameters_text(session, run, _IN_NAMES)).rstrip(":; ") or name


# cached: every row needs these whenever the list changes


@lru_cache(maxsize=512)
def _likeness_text(parameters: Parameters, max_values: int | None) -> str:
    return nearest_preset(parameters).text(max_values)


@lru_cache(maxsize=2048)
def _own_words(parameters: Parameters, common: Parameters, max_values: int | None) -> str:
    return ", ".join(to_text(own_values(parameters, common), max_values))
