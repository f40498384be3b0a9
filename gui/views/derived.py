"""What is worked out of the present frame for those who look at it: edges, holes interpolated, the spectrum."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.views.contents.material import Spectrum
from gui.views.linked_views import LinkedViews
from gui.work.latest_question import LatestQuestion
from ilf.bench.peers.interpolation import linear
from ilf.drawing.spectrum import depth_spectrum
from ilf.edges.frame_edges import find_edges
from ilf.filter.pass_band.record import PassBandRecord
from ilf.parameters import BlockParameters

_BANDS_SHOWN = 3.0
"""How far the spectrum is shown, in times the pass band."""
_LEAST_REACH = 24
"""Wave numbers that are shown at least, where the grid has them."""


@dataclass(frozen=True, eq=False)
class _Question:
    """What is to be worked out, by a function off the GUI's thread; questions of the same key have the same answer."""

    key: tuple[Any, ...]
    find: Callable[[], Any]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Question) and _same(self.key, other.key)

    __hash__ = None  # type: ignore[assignment]


def _same(one: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    """Frames and results are the same only if they are the very same."""
    return len(one) == len(other) and all(
        a is b or (isinstance(a, (int, BlockParameters)) and a == b) for a, b in zip(one, other, strict=True)
    )


class _Derived(QObject):
    """One thing that is worked out: asked for when it is looked at and is another one, and shown when it is there.

    Signals
    -------
    failed(object)
        The exception that kept it from being found.
    """

    failed = Signal(object)

    def __init__(self, part: str, show: Callable[[Any], None], nothing: Any, parent: QObject) -> None:
        super().__init__(parent)
        self.part = part
        self._show = show
        self._nothing = nothing
        self._asked: _Question | None = None
        self._questions = LatestQuestion[_Question, Any](lambda question: question.find(), self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._questions.busy

    def want(self, question: _Question | None, otherwise: Any = None) -> None:
        """Look for an answer, unless it has been found or is being looked for; None shows something else at once."""
        if question is None:
            self._asked = None
            self._questions.forget()
            self._show(self._nothing if otherwise is None else otherwise)
        elif question != self._asked:
            self._asked = question
            self._questions.ask(question)

    def shutdown(self) -> bool:
        """Stop for good. True if the thread has ended."""
        return self._questions.shutdown()

    def _take(self, question: _Question, answer: Any) -> None:
        if self._asked is not None and question == self._asked:
            self._show(answer)

    def _fail(self, question: _Question, error: Exception) -> None:
        if self._asked is not None and question == self._asked:
            self.failed.emit(error)


class DerivedPresenter(QObject):
    """Edges, interpolated holes and the spectrum of the chosen block, each while it is to be seen.

    Signals
    -------
    failed(object)
        The exception that kept one of them from being found. It is not tried again.
    """

    failed = Signal(object)

    def __init__(self, workspace: Workspace, views: LinkedViews) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._session: Session | None = None
        self._edges = _Derived("edges", views.set_edges, None, self)
        self._interpolated = _Derived("interpolated", views.set_interpolated, None, self)
        self._spectrum = _Derived("spectrum", views.set_spectrum, "", self)
        self._all = self._edges, self._interpolated, self._spectrum
        for one in self._all:
            one.failed.connect(self.failed)

    @property
    def busy(self) -> bool:
        """Whether something is to come."""
        return any(one.busy for one in self._all)

    def show(self) -> None:
        """Ask for what is looked at and not known yet."""
        session = self._workspace.session if self._workspace.has_session else None
        if session is not self._session:
            self._session = session
            for one in self._all:
                one.want(None)
        if session is None:
            return
        frame, extraction = session.frame, session.notes.extraction or BlockParameters()
        if self._views.shows("edges"):
            self._edges.want(_Question((frame, extraction), lambda: find_edges(frame, extraction)))
        if self._views.shows("interpolated"):
            self._interpolated.want(_Question((frame,), lambda: linear(frame)))
        if self._views.shows("spectrum"):
            self._ask_spectrum(session)

    def _ask_spectrum(self, session: Session) -> None:
        label = self._workspace.chosen
        result = session.valid_results().get(label)
        if not label:
            self._spectrum.want(None, "Choose a block")
        elif result is None or not result.history:
            self._spectrum.want(None, f"{session.info(label).name} has not been run")
        elif not isinstance(last := result.history[-1], PassBandRecord):
            self._spectrum.want(
                None,
                f"{session.info(label).name} has no pass band: it was run without the presets of the paper",
            )
        else:
            radii, name, padding = last.radii, session.info(label).name, result.parameters.padding
            depth = np.full(result.block.mask.shape, np.nan, np.float32)
            depth[result.block.mask] = result.depth
            self._spectrum.want(_Question((result,), lambda: _spectrum(depth, padding, radii, name)))

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if all threads have ended."""
        ended = [one.shutdown() for one in self._all]
        return all(ended)


def _spectrum(depth: NDArray[np.float32], padding: float, radii: tuple[float, float], name: str) -> Spectrum:
    reach = tuple(max(math.ceil(_BANDS_SHOWN * radius), _LEAST_REACH) for radius in radii)
    text = f"{name}: band {radii[1]:.0f} across, {radii[0]:.0f} down [cycles/grid]"
    return Spectrum(depth_spectrum(depth, padding, (reach[0], reach[1])), radii, text)
