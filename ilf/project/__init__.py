"""Projects: the work on frames, kept whole. See `frame_state.py` for what is kept of a frame."""

from .block_notes import BlockInfo, BlockNotes
from .carrying import Carried, carry
from .frame_state import FrameState, Looked
from .journal import Journal, JournalInUse, JournalNote
from .kept_run import Guess, KeptRun
from .parts import Parts
from .project import FrameSummary, Project, ProjectFrame, Stage

__all__ = [
    "BlockInfo",
    "BlockNotes",
    "Carried",
    "FrameState",
    "FrameSummary",
    "Guess",
    "Journal",
    "JournalInUse",
    "JournalNote",
    "KeptRun",
    "Looked",
    "Parts",
    "Project",
    "ProjectFrame",
    "Stage",
    "carry",
]
