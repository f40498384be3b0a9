"""What a command needs, and the sentences that say what is missing."""

from __future__ import annotations

from enum import Flag, auto


class Need(Flag):
    """What must be there for a command. What is missing first, in the order of the definition, is told."""

    NOT_PLAYING = auto()
    _OPEN = auto()
    IDLE = auto()
    """The frame is not being read, extracted or run."""
    _SOME = auto()
    _CHOSEN = auto()
    _FREE = auto()
    FRAME = NOT_PLAYING | _OPEN
    """A frame is open, and frames are not played."""
    BLOCKS = FRAME | _SOME
    """The frame has blocks."""
    SELECTION = BLOCKS | _CHOSEN
    """A block is selected."""
    UNLOCKED = SELECTION | _FREE
    """A selected block is not locked."""


NOTHING = Need(0)

_SENTENCES = {
    Need.NOT_PLAYING: "Pause playing first.",
    Need.FRAME: "Open a frame first.",
    Need.IDLE: "Wait until the work in progress has ended, or cancel it.",
    Need.BLOCKS: "There are no blocks: extract or draw some first.",
    Need.SELECTION: "Select a block first.",
    Need.UNLOCKED: "The selected blocks are locked: unlock them first.",
}


def sentence(missing: Need) -> str:
    """Return what to do first, given what is missing; "" if nothing is."""
    return next((text for need, text in _SENTENCES.items() if need & missing), "")
