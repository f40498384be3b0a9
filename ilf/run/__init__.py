"""One run, from frame to files: what it is made of, its record, its replay and its files."""

from .checks import missing_or_changed
from .effect import Effect, edit_effect
from .key_frames import KeyFrames
from .nerfstudio import depth_weight, write_nerfstudio
from .options import ExportOptions, output_folder_name
from .recipe import Recipe
from .record import RunRecord, make_record
from .record_file import read_record
from .replaying import Replay, replay
from .run import GUESS, Run, RunSteps
from .writing import Written, check_not_an_input, check_write, filenames, write

__all__ = [
    "GUESS",
    "Effect",
    "ExportOptions",
    "KeyFrames",
    "Recipe",
    "Replay",
    "Run",
    "RunRecord",
    "RunSteps",
    "Written",
    "check_not_an_input",
    "check_write",
    "depth_weight",
    "edit_effect",
    "filenames",
    "make_record",
    "missing_or_changed",
    "output_folder_name",
    "read_record",
    "replay",
    "write",
    "write_nerfstudio",
]
