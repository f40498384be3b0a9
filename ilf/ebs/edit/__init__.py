"""Pure edits of a label map. Each gives a patch that can be applied and reverted, or None if nothing changes.

Blocks that are locked keep every pixel they have, whatever the edit, and gain none but where they are the block that is
edited on purpose.
"""

from .areas import assign_outline, give, inside_outline, paint
from .border import redraw_border
from .brush import Stroke, brush_stroke
from .cleaning import clean_up, count_slivers
from .cutting import cut_off, run_on, split
from .erasing import erase
from .outlines import grow, shrink, smooth
from .patches import LabelPatch, Labels, Points, patch_between
from .whole import delete, merge, parts_touch, pixels_apart

__all__ = [
    "LabelPatch",
    "Labels",
    "Points",
    "Stroke",
    "assign_outline",
    "brush_stroke",
    "clean_up",
    "count_slivers",
    "cut_off",
    "delete",
    "erase",
    "give",
    "grow",
    "inside_outline",
    "merge",
    "paint",
    "parts_touch",
    "patch_between",
    "pixels_apart",
    "redraw_border",
    "run_on",
    "shrink",
    "smooth",
    "split",
]
