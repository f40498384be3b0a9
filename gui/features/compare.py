"""Contents of the views, what workers find for them, and the comparison of two depths."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.completion.edge_aware.fitted_guide import fit_guide
from ilf.completion.interpolation import linear
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.data.results import PassBandRecord
from ilf.drawing.colours import depth_spectrum
from ilf.segmentation.edges.frame_edges import find_edges

from ..base.commands import command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..views.layouts import COMPARE
from ..views.view_data import Spectrum
from .context import Context, Feature

# Data derived from the current frame for visible views: edges, interpolated holes, guide, spectrum.

_BANDS_SHOWN = 3.0
"""Shown extent of the spectrum, as a multiple of the pass band."""
_MIN_EXTENT = 24
"""Minimum extent of the shown spectrum [wave numbers], where the grid has them."""


_DERIVED_FROM = Part.FRAME | Part.REPLACED | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS

_NOTHING: dict[str, Any] = {"edges": None, "interpolated": None, "guide": None, "spectrum": ""}
"""Each kind of derived data -> what is shown while there is none."""


class DerivedFeature(Feature):
    """Edges, interpolated holes and the spectrum of the selected block, each while visible; and the fitted guide."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = context.workspace
        self._document: Document | None = None
        self._requested: dict[str, tuple[Any, ...]] = {}
        """What each kind is derived from; the same data are derived once, also if that fails."""
        views, add = context.views, context.refresh.add
        add("derived", self.show, _DERIVED_FROM, also=(views.shownChanged,))
        add(
            "spectrum",
            self._show_spectrum,
            Part.FRAME | Part.LABELS | Part.RESULTS | Part.SELECTION,
            Part.SOME_RESULTS,
            also=(views.shownChanged,),
            when=partial(views.shows, "spectrum"),
        )

    def show(self) -> None:
        """Request what is visible and not yet computed."""
        document = self._workspace.current if self._workspace.has_current else None
        if document is not self._document:
            self._document = document
            for name in _NOTHING:
                self._tell(name)
        if document is None:
            return
        frame, extraction = document.frame, document.blocks.extraction or BlockParameters()
        if self.context.views.shows("edges"):
            self._ask("edges", (frame, extraction), lambda: find_edges(frame, extraction))
        if self.context.views.shows("interpolated"):
            self._ask("interpolated", (frame,), lambda: linear(frame))
        # also while it is not visible: a run needs it, too
        if frame.guide is None:
            self._tell("guide")
        else:
            self._ask("guide", (frame,), lambda: _fitted(frame))

    def _ask(self, name: str, key: tuple[Any, ...], find: Callable[[], Any]) -> None:
        """Request derived data unless it is there or pending."""
        if key != self._requested.get(name):
            self._requested[name] = key
            take, fail = partial(self._take, name, key), partial(self._fail, name, key)
            self.requests.ask(find, take, fail, kind=name, key=key)

    def _tell(self, name: str, instead: str = "") -> None:
        """Show nothing of a kind, also when it comes, or a text instead."""
        self._requested.pop(name, None)
        shown = instead or _NOTHING[name]
        if getattr(self.context.views.data, name) is not shown:
            self.context.views.show_found(**{name: shown})

    def _take(self, name: str, key: tuple[Any, ...], found: Any) -> None:
        # another frame may be shown that nothing was asked of yet
        if key == self._requested.get(name) and self._document is not None and self._workspace.is_shown(self._document):
            self.context.views.show_found(**{name: found})

    def _fail(self, name: str, key: tuple[Any, ...], error: Exception) -> None:
        if key == self._requested.get(name):
            self.context.notes.report("View content", error)

    def _show_spectrum(self) -> None:
        """Request the spectrum of the selected block."""
        if not self._workspace.has_current:
            return
        document = self._workspace.current
        label = self._workspace.chosen
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


def _fitted(frame: RGBDFrame) -> NDArray[np.float32] | None:
    """Return the frame's guide, fitted to its known depth [m]."""
    fitted = fit_guide(frame)
    return None if fitted is None else fitted.depth


def _spectrum(depth: NDArray[np.float32], padding: float, radii: tuple[float, float], name: str) -> Spectrum:
    reach = tuple(max(math.ceil(_BANDS_SHOWN * radius), _MIN_EXTENT) for radius in radii)
    text = f"{name}: band {radii[1]:.0f} across, {radii[0]:.0f} down [cycles/grid]"
    return Spectrum(depth_spectrum(depth, padding, (reach[0], reach[1])), radii, text)


class CompareFeature(Feature):
    """Contents of the views, and the commands of the comparison of two depths."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._was_compared = False
        self._replaced: dict[str, str] = {}
        """Content of a view before the result replaced it: name of its cell -> content."""
        blink = context.actions["blink"]
        # an edit must show its effect on the result
        edits = _DERIVED_FROM | Part.LABELS | Part.STROKE
        context.refresh.add("blink", partial(blink.setChecked, False), edits)
        context.views.sheet.layoutChanged.connect(self._follow_layout)

    @command("view_content", "&View content…", icon="ph.list", keys="Ctrl+Shift+V", needs=Need.FRAME)
    def _choose_content(self) -> None:
        """Choose the content of the view under the pointer, or of the view clicked last; same as a click on its
        title."""
        self.context.views.choose_content()

    @command("reset_contents", "R&eset view contents")
    def _reset_contents(self) -> None:
        """Restore the default content of every view."""
        self.context.views.reset_contents()

    @command("swap_sides", "Swap A and &B", icon="ph.swap", needs=Need.FRAME)
    def _swap_sides(self) -> None:
        """Swap the two sides of the comparison."""
        views = self.context.views
        views.sides.choose(*reversed(views.data.sides))

    @command("blink", "Show side &A", icon="ph.eye", checkable=True, held="V", needs=Need.FRAME)
    def _show_side_a(self, on: bool) -> None:
        """Show side A instead of the result in all views; also while V is held."""
        views = self.context.views
        views.sides.show_a_as_result(on)

    @command("compare_two", "Compare &two", icon="ph.columns", keys="Shift+F4", checkable=True, needs=Need.FRAME)
    def _compare_two(self, on: bool) -> None:
        """Show sides A and B, their difference, and the error or the expected error; again to go back."""
        if on != (self.context.views.sheet.layout_name == COMPARE):
            self.context.views.sheet.toggle_layout(COMPARE)

    def _follow_layout(self, name: str) -> None:
        """Switch swiping off in the side-by-side layout; in others, show the result while swiping."""
        self._was_compared = False
        self.context.actions["compare_two"].setChecked(name == COMPARE)
        if name == COMPARE:
            self.context.actions["swipe"].setChecked(False)
        elif self.context.views.sides.is_divided:
            self._restore_contents()
            self._show_result()

    @command(
        "swipe",
        "S&wipe between two",
        icon="ph.arrows-left-right",
        keys="Ctrl+Shift+X",
        checkable=True,
        needs=Need.FRAME,
    )
    def _swipe(self, on: bool) -> None:
        """Compare with a draggable divider: side A on the left, side B on the right.

        It is shown instead of both sides side by side; if no view shows the result, one does until it is switched off.
        """
        views = self.context.views
        if not on:
            views.sides.divide(False)
            self._restore_contents()
            if self._was_compared:
                views.sheet.toggle_layout(COMPARE)
            return
        was_compared = views.sheet.layout_name == COMPARE
        if was_compared:
            views.sheet.toggle_layout(COMPARE)
        self._was_compared = was_compared  # until another layout is chosen
        self._show_result()
        views.sides.divide(True)

    def _show_result(self) -> None:
        """Show the result in the active view if no view does."""
        views = self.context.views
        if not any(cell.concrete == "result" for cell in views.sheet.shown):
            name = next(name for name, cell in views.cells.items() if cell is views.active)
            self._replaced = {name: views.cells[name].content}
            views.set_content(name, "result")

    def _restore_contents(self) -> None:
        """Restore the content that the result has replaced, unless the user has chosen another since."""
        views, replaced = self.context.views, self._replaced
        self._replaced = {}
        for cell, content in replaced.items():
            if views.cells[cell].content == "result":
                views.set_content(cell, content)
