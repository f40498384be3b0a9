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


class _Shown:
    """A bar on stderr, as long as the context lasts; none at all unless it is shown."""

    def __init__(self, total: float, count: str, shown: bool) -> None:
        self._bar = Bar(
            total=total,
            disable=not shown,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format=count + " |{bar:30}| {elapsed}{postfix}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()


class RunProgress(_Shown):
    """A bar on stderr: blocks done, and the last iteration of a block that runs.

    Parameters
    ----------
    run : RunSteps
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, run: RunSteps, *, shown: bool) -> None:
        super().__init__(len(run.blocks), "{n_fmt}/{total_fmt} blocks", shown)

    def update(self, step: Progress) -> None:
        """Show a step of the run."""
        record = step.record
        if record is None:
            self._bar.update(step.result is not None)
            return
        what = "guessing the rest" if step.label == GUESS else f"block {step.label}"
        self._bar.set_postfix_str(
            f"{what}: iteration {record.i}, stage {record.stage}, sigma {record.sigma_i * 1000:.3g} mm",
            refresh=False,
        )
        self._bar.update(0)


class ShareProgress(_Shown):
    """A bar on stderr for what tells the share that is done and what is under way.

    Parameters
    ----------
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, *, shown: bool) -> None:
        super().__init__(1.0, "{percentage:3.0f} %", shown)

    def update(self, step: Step) -> None:
        """Show a step."""
        self._bar.set_postfix_str(step.text, refresh=False)
        self._bar.update(max(min(step.share, 1.0) - self._bar.n, 0.0))
