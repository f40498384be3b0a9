"""Names of the files of a run's results, but for those that depend on a format (`options`)."""

LABELS, CURVES = "blocks.png", "curves.csv"
EXTRAPOLATED, INVALID_MASK, DRAWN, OUTSIDE = "extrapolated.png", "invalid_mask.png", "drawn.png", "outside_view.png"
GUIDE = "guide_used.npy"

COLOUR = "rgb.png"
"""Colour of the frame, if no file contains it: from a recording, or undistorted."""

FROM_NEIGHBOURS = "from_neighbours.png"
"""Mask of the filled pixels that neighbours of the frame have measured."""

DEPTH_BY_HAND, BY_HAND = "depth_by_hand.npy", "by_hand.png"
"""Depth by hand as given, and the mask of the filled pixels that have it."""

UNSUPPORTED = "unsupported.png"
"""Mask, beside the expected errors, of the filled pixels that are unsupported by measurements."""
