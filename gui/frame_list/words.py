"""What the list says of a frame."""

from __future__ import annotations

from gui.state.entries import Entry
from ilf.project import FrameSummary, Stage

STAGE_WORDS: dict[str, str] = {
    Stage.UNTOUCHED: "Untouched",
    Stage.EXTRACTED: "Extracted",
    Stage.CARRIED: "Carried",
    Stage.EDITED: "Edited",
    Stage.RUN: "Run",
    Stage.FAILED: "Failed",
}


def state_line(entry: Entry) -> str:
    """How the work on it stands, in a line."""
    summary = entry.summary
    parts = [STAGE_WORDS[summary.stage]]
    if summary.completed:
        parts.append(f"{summary.completed} of {_blocks(summary.blocks)}")
    elif summary.blocks:
        parts.append(_blocks(summary.blocks))
    parts += [f"{summary.to_check} to check"] * bool(summary.to_check)
    return ", ".join(parts)


def size_line(summary: FrameSummary) -> str:
    """How large it is, how much is missing, and whether it has values of its own where others have those of all; "" as
    long as nobody has read it."""
    size = "" if summary.shape is None else f"{summary.shape[1]} x {summary.shape[0]}"
    missing = "" if summary.missing is None else f"{summary.missing:.1%} missing"
    own = "own values" if summary.own_parameters else ""
    return ", ".join(filter(None, (size, missing, own)))


def last_line(entry: Entry) -> str:
    """What there is room for in its row: the user's note, or why it cannot be opened, or how large it is."""
    summary = entry.summary
    problem = summary.problem.replace(entry.key, "").lstrip(" :/\\")
    return summary.note.partition("\n")[0] or problem or size_line(summary)


def whole_text(entry: Entry) -> str:
    """All that there is to say of it, a line each."""
    summary = entry.summary
    lines = (
        entry.name,
        state_line(entry),
        summary.problem,
        size_line(summary),
        f"Note: {summary.note}" if summary.note else "",
        "Has work that is not saved" if entry.unsaved else "",
        entry.key,
    )
    return "\n".join(filter(None, lines))


def _blocks(count: int) -> str:
    return f"{count} block{'s' * (count != 1)}"
