"""What a command needs, and the sentences that say what is missing."""

from __future__ import annotations

from enum import Flag, auto


class Need(Flag):
    """What must be there for a command."""

    NOT_PLAYING = auto()
    _OPEN = auto()
    IDLE = auto()
    """No frame is being read, and this one is not being extracted or run."""
    GOING = auto()
    """The frame is being run."""
    _SOME = auto()
    _CHOSEN = auto()
    _FREE = auto()
    _TWO_FREE = auto()
    _RESULTS = auto()
    _RUNS = auto()
    _GROUND_TRUTH = auto()
    _GUIDE = auto()
    _NEIGHBOURS = auto()
    _BY_HAND = auto()
    LISTED = auto()
    """The list has a frame, which need not be open."""
    OTHERS = auto()
    """The list has several frames."""
    FRAME = NOT_PLAYING | _OPEN
    """A frame is open, and frames are not played."""
    BLOCKS = FRAME | _SOME
    """The frame has blocks."""
    SELECTION = BLOCKS | _CHOSEN
    """A block is selected."""
    UNLOCKED = SELECTION | _FREE
    """A selected block is not locked."""
    SEVERAL = BLOCKS | _TWO_FREE
    """Two or more of the selected blocks are not locked."""
    RESULTS = FRAME | _RESULTS
    """The frame has completed depth."""
    RUNS = FRAME | _RUNS
    """The frame's run history has a run."""
    GROUND_TRUTH = FRAME | _GROUND_TRUTH
    GUIDE = FRAME | _GUIDE
    NEIGHBOURS = FRAME | _NEIGHBOURS
    """Depth of neighbours is used."""
    BY_HAND = FRAME | _BY_HAND
    """The frame has depth by hand."""


NOTHING = Need(0)

_SENTENCES = {
    Need.NOT_PLAYING: "Pause playing first.",
    Need.FRAME: "Open a frame first.",
    Need.LISTED: "Open a frame first.",
    Need.OTHERS: "The list has no other frame: open more frames, or a folder of frames.",
    Need.IDLE: "Wait until the work in progress has ended, or cancel it.",
    Need.GOING: "Nothing is running.",
    Need.BLOCKS: "There are no blocks: extract or draw some first.",
    Need.SELECTION: "Select a block first.",
    Need.UNLOCKED: "The selected blocks are locked: unlock them first.",
    Need.SEVERAL: "Select two or more unlocked blocks first.",
    Need.RESULTS: "There are no results yet: run the blocks first.",
    Need.RUNS: "There are no runs yet: run the blocks first.",
    Need.GROUND_TRUTH: "This frame has no ground truth.",
    Need.GUIDE: "This frame has no guide.",
    Need.NEIGHBOURS: "No depth of neighbours is used in this frame.",
    Need.BY_HAND: "There is no depth by hand.",
}
"""In this order: what is missing first is told."""


def sentence(missing: Need) -> str:
    """Return what to do first, given what is missing; "" if nothing is."""
    return next((text for need, text in _SENTENCES.items() if need & missing), "")
