"""What of the state has changed: the window draws by these parts."""

from __future__ import annotations

from enum import Flag, auto


class Part(Flag):
    """A part of the state of the current frame, or of the window. Several changes of one turn of the event loop are one
    set of parts."""

    FRAME = auto()
    """Another frame is the current one, or none is: everything shown is of another frame."""
    LIST = auto()
    """Frames were added, opened, closed or removed, or their summaries, notes or order changed."""
    LABELS = auto()
    """The label map; `STROKE` while a stroke is in progress, which may still be cancelled."""
    STROKE = auto()
    REPLACED = auto()
    """All blocks were replaced, or restored by undo; not an edit."""
    INFOS = auto()
    """Names, colours, locks and visibility of blocks."""
    SELECTION = auto()
    INVALID_MASK = auto()
    GUIDE = auto()
    NEIGHBOURS = auto()
    BY_HAND = auto()
    PROPOSAL = auto()
    """Depth that is shown in place of the completed one until it is taken or dropped."""
    GROUND_TRUTH = auto()
    REGION = auto()
    """The rectangle."""
    MARKS = auto()
    """The profile line or the measurements."""
    IGNORED = auto()
    """Flagged places that are ignored."""
    PARAMETERS = auto()
    """Of the filter: common, own or shared ones."""
    EXTRACTION = auto()
    """Parameters of the extraction."""
    RESULTS = auto()
    """Results changed, were removed, or may be stale after an edit of what depth depends on; or a run has ended."""
    SOME_RESULTS = auto()
    """The run in progress has new results; up to several times a second."""
    RECORDS = auto()
    """Running blocks have new records."""
    PREVIEWS = auto()
    """The depth of running blocks."""
    EXPECTED_ERROR = auto()
    BLOCK_ERRORS = auto()
    """The known errors of blocks."""
    HISTORY = auto()
    """The run history."""
    COMPARED = auto()
    """The runs that are compared with the current result."""
    ITERATION = auto()
    """The earlier iteration that the views show."""
    RUNNING = auto()
    """A run has started, paused, gone on or ended."""
    CONTENT = auto()
    """Content of a frame that a project stores has changed."""
    LOADING = auto()
    """Frames are being read, or are not any more."""
    DEPTH = FRAME | LABELS | RESULTS | INVALID_MASK | NEIGHBOURS | ITERATION
    """All that the depth in the views depends on, but for a run in progress."""


NO_PART = Part(0)
EVERY_PART = ~NO_PART
