"""What a batch has written of a frame."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf.io.depth import depth_in_metres, read_depth_values
from ilf.run.options import DEPTH_FILES


class BatchResult(NamedTuple):
    """Where a batch has written the completed depth of a frame: its folder, and the units per metre of a depth PNG."""

    folder: Path
    units: float

    def read(self) -> NDArray[np.float32] | None:
        """Read the depth [m], float32 (H, W), NaN = missing; None if it was not written.

        Raises
        ------
        IlfError
            If it cannot be read.
        """
        for name, units in (("npy", 1.0), ("tiff", 1.0), ("png", self.units)):
            path = self.folder / DEPTH_FILES[name]
            if path.exists():
                return depth_in_metres(read_depth_values(path), units)
        return None
