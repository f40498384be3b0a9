"""A source in words, for `ilf info`."""

from __future__ import annotations

from ..camera import camera_text
from ..errors import IlfError
from ..io.doubts import first_of_each
from ..number_words import counted
from ..sources import Source

_SHOWN = 3
"""Keys that are shown at either end of many."""


def source_facts(source: Source) -> list[tuple[str, str]]:
    """What frames a source has, as pairs of name and fact."""
    facts = [("source", f"{source.path}, {counted(len(source), 'frame')}"), ("keys", _some(source.keys))]
    times = source.timestamps
    if times is not None:
        start, end = min(times), max(times)
        span = f"{start:.6f} to {end:.6f} s, {end - start:.3f} s in all" if len(times) > 1 else f"{start:.6f} s"
        facts.append(("time", span))
    first = source.calibration(source.keys[0])
    facts += [("colour camera", camera_text(first.colour)), ("depth camera", camera_text(first.depth))]
    way = "done as it is read" if source.frame_source(source.keys[0]).frame is not None else "read as it is"
    facts.append(("registered", "yes" if source.is_registered else f"no: {way}"))
    return facts


def doubt_facts(source: Source) -> list[tuple[str, str]]:
    """What speaks against the way that the first, the middle and the last frame are read, and what keeps them from it,
    as pairs of name and fact."""
    known: set[str] = set()
    facts = []
    for key in dict.fromkeys(source.keys[at] for at in (0, len(source) // 2, -1)):
        try:
            found = [("doubt", text) for text in source.frame_source(key).load().doubts]
        except IlfError as error:
            found = [("problem", str(error))]
        facts += [(name, f"{key}: {text}") for name, text in found if first_of_each([text], known)]
    return facts


def _some(keys: tuple[str, ...]) -> str:
    if len(keys) <= 2 * _SHOWN:
        return ", ".join(keys)
    return f"{', '.join(keys[:_SHOWN])} ... {', '.join(keys[-_SHOWN:])}"
