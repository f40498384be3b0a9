"""Progress bars: of a run, and of judging several."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from tqdm import tqdm

from ..judgement import Step
from ..outcomes import Progress
from ..run import GUESS, RunSteps


class Bar(tqdm):
    """tqdm without its monitor thread."""

    # otherwise the first bar starts a thread that outlives it
    monitor_interval = 0


class RunProgress:
    """A bar on stderr: blocks done, and the last iteration of a block that runs.

    Parameters
    ----------
    run : RunSteps
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, run: RunSteps, *, shown: bool) -> None:
        self._bar = Bar(
            total=len(run.blocks),
            disable=not shown,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format="{n_fmt}/{total_fmt} blocks |{bar:30}| {elapsed}{postfix}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()

    def update(self, step: Progress) -> None:
        """Show a step of the run."""
        record = step.record
        if record is None:
            self._bar.update(1)
            return
        what = "guessing the rest" if step.label == GUESS else f"block {step.label}"
        self._bar.set_postfix_str(
            f"{what}: iteration {record.i}, stage {record.stage}, sigma {record.sigma_i * 1000:.3g} mm",
            refresh=False,
        )
        self._bar.update(0)


class ShareProgress:
    """A bar on stderr for what tells the share that is done and what is under way.

    Parameters
    ----------
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, *, shown: bool) -> None:
        self._bar = Bar(
            total=1.0,
            disable=not shown,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format="{percentage:3.0f} % |{bar:30}| {elapsed}{postfix}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()

    def update(self, step: Step) -> None:
        """Show a step."""
        self._bar.set_postfix_str(step.text, refresh=False)
        self._bar.update(max(min(step.share, 1.0) - self._bar.n, 0.0))
