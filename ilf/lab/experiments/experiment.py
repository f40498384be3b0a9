"""What an experiment is given, what it gives, and how it is told apart from the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..._runtime.processes import run_units
from ...data.parameters import PRESETS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]
"""One line of a table: name -> text, number, truth value, or None where there is nothing to say."""

PAPER_PRESETS = ("paper", "released-code")
"""The presets that follow the paper's text and the authors' program."""

METHOD_PRESETS = (*PAPER_PRESETS, *(name for name in PRESETS if name not in PAPER_PRESETS))
"""All presets, those of the paper first."""


@dataclass(frozen=True)
class Settings:
    """What a user can choose.

    Attributes
    ----------
    data : Path or None
        Folder of frame folders, one frame folder, or an NYU labelled file; None takes the bundled sample.
    split : Path or None
        Which frames of an NYU labelled file to take; None takes splits.mat beside it, or all if there is none.
    limit : int or None
        Take the first so many frames only.
    quick : bool
        Fewer points, smaller grids, few frames: to see that all works, not for numbers to rely on.
    seed : int
        What noise and hidden pixels follow from, not negative.
    jobs : int
        Processes that share the work. The numbers do not depend on it, but for the seconds.
    """

    data: Path | None = None
    split: Path | None = None
    limit: int | None = None
    quick: bool = False
    seed: int = 0
    jobs: int = 1


@dataclass(frozen=True)
class Progress:
    """So many units of an experiment's work are done."""

    experiment: str
    done: int
    total: int


OnProgress = Callable[[int, int], None]
"""Takes the units done and their number; what it raises ends the experiment."""


@dataclass(frozen=True, eq=False)
class Result:
    """What an experiment gave.

    Attributes
    ----------
    rows : list of Row
        The numbers; every row has "method", and "defect_rate" (0-1), "acc_mm", "prs_mm", "rmse_mm" where they apply.
    parameters : dict
        All that the numbers follow from, as JSON takes it; what the paper leaves open and how it was chosen under
        "chosen".
    notes : list of str
        What a reader has to know, one sentence each.
    tables : dict of str to list of Row
        Longer tables: curves, the rows of single blocks. Written as CSV only.
    pictures : dict of str to ndarray
        uint8 (H, W, 3), for the figures only.
    experiment : str
    seed : int
    quick : bool
    seconds : float
        Set by `run_experiment`, as the three before.
    """

    rows: list[Row]
    parameters: dict[str, Any]
    notes: list[str] = field(default_factory=list)
    tables: dict[str, list[Row]] = field(default_factory=dict)
    pictures: dict[str, NDArray[np.uint8]] = field(default_factory=dict)
    experiment: str = ""
    seed: int = 0
    quick: bool = False
    seconds: float = 0.0


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure.

    Attributes
    ----------
    key : str
        In file names.
    caption : str
    figure : Figure
    shows_data : bool
        Whether parts of the user's own frames are seen in it, which may not be anyone's to pass on.
    """

    key: str
    caption: str
    figure: Figure
    shows_data: bool = False


@dataclass(frozen=True)
class Comparison:
    """A value of the paper beside ours, and what to say about it."""

    what: str
    paper: str
    ours: str
    text: str

    @property
    def label(self) -> str:
        """`what`, with a preset at its end called one: the preset "paper" stands beside the paper itself."""
        *subject, last = self.what.split(", ")
        return ", ".join((*subject, f"preset {last}" if last in PRESETS else last))


@dataclass(frozen=True)
class Experiment:
    """One of the paper's experiments.

    Attributes
    ----------
    name, title : str
    source : str
        Where in the paper it is.
    about : str
        What is done, in a sentence or two.
    run : callable
        Takes settings and a function to report progress to; the same settings give the same rows, but for seconds.
    draw : callable
        Makes the figures from a result.
    compare : callable
        Takes rows, in memory or read from a file, and sets them beside the paper.
    needs_frames : bool
        Whether the settings' data matter.
    """

    name: str
    title: str
    source: str
    about: str
    run: Callable[[Settings, OnProgress], Result]
    draw: Callable[[Result], list[Drawing]]
    compare: Callable[[list[Row]], list[Comparison]]
    needs_frames: bool = False


def preset_parameters(**changes: object) -> dict[str, Any]:
    """Name -> parameters of every preset as the experiments run it, ready for JSON."""
    return {name: PRESETS[name].replace(**changes).to_dict() for name in METHOD_PRESETS}


# Units of an experiment's work, counted as they are done.

Outcome = TypeVar("Outcome")


def run_counted(
    function: Callable[..., Outcome], units: Sequence[tuple[Any, ...]], jobs: int, on_progress: OnProgress
) -> list[Outcome]:
    """What a function at the top level of a module makes of every unit, in the units' order."""
    done = 0

    def count(_: int) -> None:
        nonlocal done
        done += 1
        on_progress(done, len(units))

    on_progress(0, len(units))
    return run_units(function, units, jobs=jobs, on_done=count)
