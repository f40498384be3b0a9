"""What is said when blocks have been carried."""

from __future__ import annotations

from gui.carrying.carrier import Arrival, Journey
from ilf.number_words import counted

_DONE = {"copied": "copied", "flow": "carried along optical flow", "pose": "carried by the camera's pose"}
_MOST_NAMED = 3


def summary(journey: Journey) -> str:
    """What has come of a journey, in a few sentences; "" for nothing."""
    texts = [_of_one(journey.done[0]) if len(journey.done) == 1 else _of_many(journey)] if journey.done else []
    if journey.kept:
        kept = counted(len(journey.kept), "frame")
        texts.append(f"{kept} ({_named(journey.kept)}) had been edited or run: blocks were carried on from there.")
    if journey.stopped:
        texts.append(f"Stopped after {journey.over} of {counted(journey.total, 'frame')}.")
    return " ".join(texts)


def notes_of(journey: Journey) -> list[str]:
    """What the user should know of single frames, a sentence each."""
    return [*journey.problems, *(f"{one.name}: {note}" for one in journey.done for note in one.notes)]


def to_check(journey: Journey) -> int:
    """Blocks that need a look."""
    return sum(one.to_check for one in journey.done)


def _of_one(one: Arrival) -> str:
    parts = [f"{one.name}: {counted(one.blocks, 'block')} {_DONE[one.how]}"]
    parts += [f"{one.new} of them new"] * (one.new > 0) + [f"{one.gone} gone"] * (one.gone > 0)
    parts += [f"{one.to_check} need{'s' * (one.to_check == 1)} a look"] if one.to_check else ["none needs a look"]
    return ", ".join(parts) + "."


def _of_many(journey: Journey) -> str:
    ways = [one.how for one in journey.done]
    how = " and ".join(f"{ways.count(way)} {_DONE[way]}" for way in _DONE if way in ways)
    text = f"Blocks of {journey.source.name} are in {counted(len(ways), 'further frame')}: {how}."
    look, marked = to_check(journey), sum(one.to_check > 0 for one in journey.done)
    need = f"{counted(look, 'block')} in {counted(marked, 'frame')} need{'s' * (look == 1)} a look."
    return f"{text} {need if look else 'No block needs a look.'}"


def _named(names: list[str]) -> str:
    return ", ".join(names[:_MOST_NAMED]) + ", …" * (len(names) > _MOST_NAMED)
