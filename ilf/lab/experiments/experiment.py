"""An experiment: its settings, result, figures and comparisons."""

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
"""One line of a table: name -> text, number, bool, or None where there is no value."""

PAPER_PRESETS = ("paper", "released-code")
"""The presets that follow the paper's text and the authors' program."""

METHOD_PRESETS = (*PAPER_PRESETS, *(name for name in PRESETS if name not in PAPER_PRESETS))
"""All presets, those of the paper first."""


@dataclass(frozen=True)
class Settings:
    """Settings of an experiment.

    Attributes
    ----------
    data : Path or None
        Folder of frame folders, one frame folder, or an NYU labelled file; None means the bundled sample.
    split : Path or None
        File with the selected frames of an NYU labelled file; None means splits.mat beside it, or all without one.
    limit : int or None
        Use only the first so many frames.
    quick : bool
        Fewer points, smaller grids, few frames: a check that everything works, without reliable numbers.
    seed : int
        Of noise and held-out pixels, not negative.
    jobs : int
        Processes that share the work. Only the timings depend on it.
    """

    data: Path | None = None
    split: Path | None = None
    limit: int | None = None
    quick: bool = False
    seed: int = 0
    jobs: int = 1


@dataclass(frozen=True)
class Progress:
    """Progress of an experiment: units done, and their total."""

    experiment: str
    done: int
    total: int


OnProgress = Callable[[int, int], None]
"""Called with the units done and their total; an exception from it ends the experiment."""


@dataclass(frozen=True, eq=False)
class Result:
    """Result of an experiment.

    Attributes
    ----------
    rows : list of Row
        The numbers; every row has "method", and "defect_rate" (0-1), "acc_mm", "prs_mm", "rmse_mm" where they apply.
    parameters : dict
        All inputs of the numbers, ready for JSON; "chosen" describes values that the paper does not give.
    notes : list of str
        Remarks for the reader, one sentence each.
    tables : dict of str to list of Row
        Longer tables: curves, the rows of single blocks. Written as CSV only.
    pictures : dict of str to ndarray
        uint8 (H, W, 3), for the figures only.
    experiment : str
    seed : int
    quick : bool
    seconds : float
        Set by `run_experiment`, like the previous three.
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
        Used in file names.
    caption : str
    figure : Figure
    shows_data : bool
        Whether the figure shows parts of the user's frames, which may not be free to distribute.
    """

    key: str
    caption: str
    figure: Figure
    shows_data: bool = False


@dataclass(frozen=True)
class Comparison:
    """A value of the paper beside ours, with a comment."""

    what: str
    paper: str
    ours: str
    text: str

    @property
    def label(self) -> str:
        """`what`, with "preset" before the name of a preset at its end, to tell the preset "paper" from the paper."""
        *subject, last = self.what.split(", ")
        return ", ".join((*subject, f"preset {last}" if last in PRESETS else last))


@dataclass(frozen=True)
class Experiment:
    """One of the paper's experiments.

    Attributes
    ----------
    name, title : str
    source : str
        Place in the paper.
    about : str
        Description in one or two sentences.
    run : callable
        Takes settings and a progress callback; the same settings give the same rows, except for seconds.
    draw : callable
        Makes the figures from a result.
    compare : callable
        Compares rows, in memory or read from a file, with the paper.
    needs_frames : bool
        Whether the experiment uses the settings' data.
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
    """Return name -> parameters of every preset as the experiments run it, ready for JSON."""
    return {name: PRESETS[name].replace(**changes).to_dict() for name in METHOD_PRESETS}


# Units of an experiment's work, with progress.

Outcome = TypeVar("Outcome")


def run_counted(
    function: Callable[..., Outcome], units: Sequence[tuple[Any, ...]], jobs: int, on_progress: OnProgress
) -> list[Outcome]:
    """Return the results of a function for every unit, in their order; it must be at the top level of a module."""
    done = 0

    def count(_: int) -> None:
        nonlocal done
        done += 1
        on_progress(done, len(units))

    on_progress(0, len(units))
    return run_units(function, units, jobs=jobs, on_done=count)
