"""A source in words, for `ilf info`."""

from __future__ import annotations

from ..camera import camera_text
from ..number_words import counted
from ..sources import Source

_SHOWN = 3
"""Keys that are shown at either end of many."""


def source_facts(source: Source) -> list[tuple[str, str]]:
    """What frames a source has, as pairs of name and fact."""
    facts = [("source", f"{source.path}, {counted(len(source), 'frame')}"), ("keys", _some(source.keys))]
    times = source.timestamps
    if times is not None:
        facts.append(("time", f"{min(times):.6f} to {max(times):.6f} s, {max(times) - min(times):.3f} s in all"))
    first = source.calibration(source.keys[0])
    facts += [("colour camera", camera_text(first.colour)), ("depth camera", camera_text(first.depth))]
    is_recorded = source.frame_source(source.keys[0]).frame is not None
    facts.append(
        (
            "registered",
            "yes" if source.is_registered else f"no: {'done as it is read' if is_recorded else 'read as it is'}",
        )
    )
    return facts


def _some(keys: tuple[str, ...]) -> str:
    if len(keys) <= 2 * _SHOWN:
        return ", ".join(keys)
    return f"{', '.join(keys[:_SHOWN])} ... {', '.join(keys[-_SHOWN:])}"
