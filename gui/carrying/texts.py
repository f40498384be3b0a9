"""What is said when blocks have been carried."""

from __future__ import annotations

from gui.carrying.carrier import Journey
from ilf.number_words import counted

_DONE = {"copied": "copied", "flow": "carried along optical flow", "pose": "carried by the camera's pose"}
_MOST_NAMED = 3


def summary(journey: Journey) -> str:
    """What has come of a journey, in a few sentences; "" for nothing."""
    texts = [_of_one(journey) if len(journey.done) == 1 else _of_many(journey)] if journey.done else []
    if journey.kept:
        kept = counted(len(journey.kept), "frame")
        texts.append(f"{kept} ({_named(journey.kept)}) had been edited or run: blocks were carried on from there.")
    if journey.stopped:
        texts.append(f"Stopped after {journey.over} of {counted(journey.total, 'frame')}.")
    return " ".join(texts)


def notes_of(journey: Journey) -> list[str]:
    """What the user should know of single frames, a sentence each."""
    followed = [f"{session.name}: {note}" for session, carried in journey.done for note in carried.followed.notes]
    return [*journey.problems, *followed]


def to_check(journey: Journey) -> int:
    """Blocks that need a look."""
    return sum(len(carried.state.to_check) for _, carried in journey.done)


def _of_one(journey: Journey) -> str:
    ((session, carried),) = journey.done
    blocks = len(session.counts())
    parts = [f"{session.name}: {counted(blocks, 'block')} {_DONE[carried.followed.how]}"]
    new, gone, look = len(carried.followed.new), len(carried.followed.gone), to_check(journey)
    parts += [f"{new} of them new"] * (new > 0) + [f"{gone} gone"] * (gone > 0)
    parts += [f"{look} need{'s' * (look == 1)} a look"] if look else ["none needs a look"]
    return ", ".join(parts) + "."


def _of_many(journey: Journey) -> str:
    ways = [carried.followed.how for _, carried in journey.done]
    how = " and ".join(f"{ways.count(way)} {_DONE[way]}" for way in _DONE if way in ways)
    marked = sum(bool(carried.state.to_check) for _, carried in journey.done)
    text = f"Blocks of {journey.source.name} are in {counted(len(ways), 'further frame')}: {how}."
    look = to_check(journey)
    return f"{text} {counted(look, 'block')} in {counted(marked, 'frame')} need a look." if look else text


def _named(names: list[str]) -> str:
    return ", ".join(names[:_MOST_NAMED]) + ", …" * (len(names) > _MOST_NAMED)
