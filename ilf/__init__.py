"""ILF Studio's library: complete the missing depth in RGB-D frames by iterative low-pass filtering."""

from .completion import complete, iterate
from .confidence import expected_error, unvouched
from .dense import fill_rest
from .ebs import extract_blocks
from .edges import edge_strength
from .errors import DepthWarning, IlfError
from .frame import CameraIntrinsics, RGBDFrame
from .io import load_frame
from .outcomes import Completion
from .parameters import BlockParameters, Parameters, preset
from .run import Run, replay, write
from .sources import Source, open_source
from .version import __version__

__all__ = [
    "BlockParameters",
    "CameraIntrinsics",
    "Completion",
    "DepthWarning",
    "IlfError",
    "Parameters",
    "RGBDFrame",
    "Run",
    "Source",
    "__version__",
    "complete",
    "edge_strength",
    "expected_error",
    "extract_blocks",
    "fill_rest",
    "iterate",
    "load_frame",
    "open_source",
    "preset",
    "replay",
    "unvouched",
    "write",
]
