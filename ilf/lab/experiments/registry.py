"""All experiments by name, and the function that runs one."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from ..._runtime.installation import optional
from ...errors import ParameterError
from ...evaluation.bench.frames import parse_names
from .convergence import compare_convergence, draw_convergence, run_convergence
from .cylinder import CYLINDER, CYLINDER_NOISE
from .experiment import Experiment, Progress, Result, Settings
from .limits import LIMITS
from .real import compare_real, draw_real, run_real
from .sphere import SPHERE
from .table import compare_table, draw_table, run_table
from .unknowns import compare_unknowns, draw_unknowns, run_unknowns

_CONVERGENCE = Experiment(
    name="convergence",
    title="Convergence of the iteration",
    source="Fig. 2 and 3",
    about="One block with exact ground truth: sigma_i, the L1 norm and the error against iteration, with and without "
    "colour.",
    run=run_convergence,
    draw=draw_convergence,
    compare=compare_convergence,
)

_REAL = Experiment(
    name="real",
    title="Real frames, and a halogen-like spot",
    source="Fig. 7 and 8",
    about="Frames of several sensors, raw and completed, and their clouds; a round spot of 15 cm is cut out of known "
    "depth.",
    run=run_real,
    draw=draw_real,
    compare=compare_real,
    needs_frames=True,
)

_TABLE = Experiment(
    name="table",
    title="Errors over all operation blocks",
    source="Fig. 9 and Table 1",
    about="Known depth is held out and completed by every method; errors are means over all blocks, weighted by "
    "pixels, beside the paper's selective mean.",
    run=run_table,
    draw=draw_table,
    compare=compare_table,
    needs_frames=True,
)

_UNKNOWNS = Experiment(
    name="unknowns",
    title="Open points of the text",
    source="Fig. 4, 5 and 6",
    about="The preset paper with every combination of values that the text leaves open, on cylinders and spheres that "
    "it does not specify: which combinations reproduce 10.28 mm and the wins over polynomials?",
    run=run_unknowns,
    draw=draw_unknowns,
    compare=compare_unknowns,
)

EXPERIMENTS: dict[str, Experiment] = {
    experiment.name: experiment
    for experiment in (_CONVERGENCE, CYLINDER, SPHERE, CYLINDER_NOISE, _UNKNOWNS, _REAL, _TABLE, LIMITS)
}
"""Name -> experiment, in the order of the paper."""

ALL = "all"
"""Name that means all experiments."""


def selected_experiments(names: str) -> list[str]:
    """Parse a comma-separated list of experiments, each named once; "all" means all of them.

    Raises
    ------
    ParameterError
        For an unknown name.
    """
    return parse_names(names, EXPERIMENTS, {ALL: tuple(EXPERIMENTS)}, what="experiment")


def run_experiment(
    name: str, settings: Settings | None = None, on_progress: Callable[[Progress], None] | None = None
) -> Result:
    """Run one experiment.

    Parameters
    ----------
    name : str
        One of `EXPERIMENTS`.
    settings : Settings, optional
    on_progress : callable, optional
        Called with every `Progress`; raise `Cancelled` in it to cancel.

    Raises
    ------
    ParameterError
        For an unknown name.
    InputError, FormatError
        If the data cannot be used, or the package for figures is missing.
    """
    if name not in EXPERIMENTS:
        raise ParameterError(f"There is no experiment {name!r}. Known: {', '.join(EXPERIMENTS)}.")
    optional("matplotlib", "ilf-studio[plot]", "Drawing an experiment's figures")  # fail before the work, not after it
    chosen = settings or Settings()
    report = on_progress or (lambda progress: None)
    started = time.perf_counter()
    result = EXPERIMENTS[name].run(chosen, lambda done, total: report(Progress(name, done, total)))
    return replace(result, experiment=name, seed=chosen.seed, quick=chosen.quick, seconds=time.perf_counter() - started)
