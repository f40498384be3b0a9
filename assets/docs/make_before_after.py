"""Make README's picture: `python assets/docs/make_before_after.py`.

Completes the bundled sample by `best` and draws colour with blocks, measured depth and completed depth side by side.
The completed depth has the colours of the measured depth.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

import ilf
from ilf._runtime.installation import asset_path
from ilf.drawing.blocks import block_overlay
from ilf.drawing.colours import depth_colours, robust_depth_levels, to_indices

PICTURE = Path(__file__).parent / "images" / "before-after.jpg"
_GAP = 8
"""White pixels between two pictures."""
_QUALITY = 90


def main() -> None:
    """Complete the sample and write the picture."""
    frame = ilf.load_frame(asset_path("samples/room"))
    blocks = ilf.extract_blocks(frame)
    completed = ilf.complete(frame, blocks).depth
    levels = robust_depth_levels(completed)
    measured, filled = (depth_colours()[to_indices(depth, *levels)] for depth in (frame.depth, completed))
    gap = np.full((frame.shape[0], _GAP, 3), 255, np.uint8)
    row = np.hstack([block_overlay(frame.rgb, blocks), gap, measured, gap, filled])
    cv2.imwrite(str(PICTURE), row[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])


if __name__ == "__main__":
    main()
