"""Names that a user lists, separated by commas."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from ..errors import ParameterError


def chosen_names(
    names: str, known: Collection[str], groups: Mapping[str, Sequence[str]] | None = None, what: str = "method"
) -> list[str]:
    """What a comma-separated list means, each name once.

    Parameters
    ----------
    names : str
        Any of `known` and of the names of `groups`.
    known : collection of str
    groups : mapping, optional
        Name -> members, all of them among `known`.
    what : str
        What is named, for the message.

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    groups = groups or {}
    chosen: dict[str, None] = {}
    for name in filter(None, (name.strip() for name in names.split(","))):
        if name not in groups and name not in known:
            raise ParameterError(f"There is no {what} {name!r}. Known: {', '.join([*groups, *known])}.")
        chosen.update(dict.fromkeys(groups.get(name, (name,))))
    if not chosen:
        raise ParameterError(f"No {what} is named. Known: {', '.join([*groups, *known])}.")
    return list(chosen)
