"""ILF Studio's library: complete the missing depth in RGB-D frames by iterative low-pass filtering.

Names are imported when they are first used, from where `__init__.pyi` says: all of them take a second.
"""

import lazy_loader

from ._runtime.installation import __version__

__getattr__, __dir__, _ = lazy_loader.attach_stub(__name__, __file__)

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
