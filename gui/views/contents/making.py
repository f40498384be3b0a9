"""Which painter draws which content."""

from __future__ import annotations

from gui.views.overlay import BlockOverlay
from gui.views.view_cell import ViewCell

from .colour import ColourPainter
from .depth import DepthPainter
from .difference import DifferencePainter
from .expected import ExpectedErrorPainter
from .masks import MaskPainter
from .material import Material
from .names import COMPARABLE, compared_by
from .painter import Painter
from .spectrum import SpectrumPainter
from .stages import StageBoard, StagePainter
from .strength import StrengthPainter


class Studio:
    """Makes painters over one material, one overlay of blocks and one board of stages."""

    def __init__(self, material: Material, overlay: BlockOverlay, board: StageBoard) -> None:
        self.material = material
        self._overlay = overlay
        self._board = board

    def painter(self, content: str, cell: ViewCell) -> Painter:
        """A painter of a concrete content for a cell."""
        material = self.material
        if content == "colour":
            return ColourPainter(content, cell, material, self._overlay)
        if content == "extraction":
            return StagePainter(content, cell, material, self._board)
        if content in COMPARABLE:
            return DepthPainter(content, cell, material)
        if compared_by(content):
            return DifferencePainter(content, cell, material)
        return _OTHERS[content](content, cell, material)


_OTHERS: dict[str, type[Painter]] = {
    "expected-error": ExpectedErrorPainter,
    "strength": StrengthPainter,
    "creases": StrengthPainter,
    "guessed": MaskPainter,
    "distrusted": MaskPainter,
    "spectrum": SpectrumPainter,
}
