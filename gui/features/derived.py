"""What workers find for visible views: edges, interpolated holes, guide, spectrum, depth of the frame before."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.completion.edge_aware.fitted_guide import fit_guide
from ilf.completion.interpolation import linear
from ilf.data.parameters import BlockParameters
from ilf.data.results import PassBandRecord
from ilf.drawing.colours import depth_spectrum
from ilf.segmentation.edges.frame_edges import find_edges

from ..base.needs import Need
from ..state.document import Document
from ..state.parts import NO_PART, Part
from ..views.view_data import Before, Spectrum
from ..widgets.notices import error_text
from .context import Context, Feature
from .frame_list.feature import FramesFeature
from .sequence.moment import moment_reader

_BANDS_SHOWN = 3.0
"""Shown extent of the spectrum, as a multiple of the pass band."""
_MIN_EXTENT = 24
"""Minimum extent of the shown spectrum [wave numbers], where the grid has them."""

_OF_FRAME = Part.FRAME | Part.REPLACED | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS
_OF_RESULT = Part.FRAME | Part.RESULTS

_KINDS: dict[str, tuple[Any, Part, Part]] = {
    "edges": (None, _OF_FRAME, NO_PART),
    "interpolated": (None, _OF_FRAME, NO_PART),
    "guide": (None, _OF_FRAME, NO_PART),
    "spectrum": ("", _OF_RESULT | Part.LABELS | Part.SELECTION, Part.SOME_RESULTS),
    "before": (Before(), _OF_RESULT | Part.LIST | Part.INVALID_MASK, Part.SOME_RESULTS),
}
"""Each kind of derived data -> what is shown while there is none, and the parts it depends on, at once and later."""


class DerivedFeature(Feature):
    """Finds each kind of derived data while a view shows it; the guide always, because a run needs it, too."""

    awaits = Need.GUIDE
    contents = tuple(_KINDS)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._requested: dict[str, tuple[Any, ...]] = {}
        """What each kind is derived from; the same data are derived once, also if that fails."""
        context.workspace.on(Part.FRAME, self._turn)
        for name, (_, parts, later) in _KINDS.items():
            seen = partial(self.views.shows, name) if name != "guide" else lambda: True
            show = partial(self.show, name)
            context.refresh.add(name, show, parts, later, also=(self.views.shownChanged,), when=seen)

    def show(self, name: str) -> None:
        """Ask for a kind, unless it is there or pending."""
        if self.workspace.shown is not None:
            getattr(self, f"_ask_{name}")(self.workspace.shown)

    def _turn(self) -> None:
        """Forget what was of another frame."""
        for name in _KINDS:
            self._tell(name)

    def _ask(self, name: str, key: tuple[Any, ...], find: Callable[[], Any], again: bool = False) -> None:
        """Ask for derived data; `again` also if the key is the same, for what changes in place."""
        if again or key != self._requested.get(name):
            self._requested[name] = key
            take, fail = partial(self._take, name, key), partial(self._take_error, name, key)
            self.requests.ask(find, take, fail, kind=name, key=None if again else key)

    def _tell(self, name: str, instead: Any = None) -> None:
        """Show nothing of a kind, also when it comes, or a text instead."""
        self._requested.pop(name, None)
        shown = instead or _KINDS[name][0]
        if getattr(self.views.data, name) is not shown:
            self.views.show_found(**{name: shown})

    def _take(self, name: str, key: tuple[Any, ...], found: Any) -> None:
        if key == self._requested.get(name):
            self.views.show_found(**{name: found})

    def _take_error(self, name: str, key: tuple[Any, ...], error: Exception) -> None:
        if name == "before":
            self._take(name, key, Before(text=error_text(error)))
        elif key == self._requested.get(name):
            self.notes.report("View content", error)

    def _ask_edges(self, document: Document) -> None:
        frame, extraction = document.frame, document.blocks.extraction or BlockParameters()
        self._ask("edges", (frame, extraction), lambda: find_edges(frame, extraction))

    def _ask_interpolated(self, document: Document) -> None:
        frame = document.frame
        self._ask("interpolated", (frame,), lambda: linear(frame))

    def _ask_guide(self, document: Document) -> None:
        frame = document.frame
        if frame.guide is None:
            self._tell("guide")
        else:
            self._ask("guide", (frame,), lambda: fit_guide(frame).depth)

    def _ask_spectrum(self, document: Document) -> None:
        """Ask for the spectrum of the selected block."""
        label = self.workspace.chosen
        result = document.valid_results().get(label)
        if not label:
            self._tell("spectrum", "Select a block")
        elif result is None or not result.history:
            self._tell("spectrum", f"{document.info(label).name} has not been run")
        elif not isinstance(last := result.history[-1], PassBandRecord):
            self._tell(
                "spectrum",
                f"{document.info(label).name} has no pass band: select a preset of the paper and run it again",
            )
        else:
            radii, name, padding = last.radii, document.info(label).name, result.parameters.padding
            depth = np.full(result.block.mask.shape, np.nan, np.float32)
            depth[result.block.mask] = result.depth
            self._ask("spectrum", (result,), lambda: _spectrum(depth, padding, radii, name))

    def _ask_before(self, document: Document) -> None:
        """Ask for the depth of the frame before in the list."""
        entry, (listed, _) = self.workspace.current_entry, self.context.feature(FramesFeature).shown()
        row = listed.index(entry) if entry in listed else 0
        if entry is None or row == 0:
            self._tell("before", Before(text="The list has no frame before this one"))
            return
        before, now = (moment_reader(one, self.context.recorder.store) for one in (listed[row - 1], entry))
        self._ask("before", (document,), lambda: now().since(before()), again=True)


def _spectrum(depth: NDArray[np.float32], padding: float, radii: tuple[float, float], name: str) -> Spectrum:
    reach = tuple(max(math.ceil(_BANDS_SHOWN * radius), _MIN_EXTENT) for radius in radii)
    text = f"{name}: band {radii[1]:.0f} across, {radii[0]:.0f} down [cycles/grid]"
    return Spectrum(depth_spectrum(depth, padding, (reach[0], reach[1])), radii, text)
