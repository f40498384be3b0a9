"""Runs of the current frame, also after each edit."""

from __future__ import annotations

from weakref import WeakSet

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QToolButton

from ilf._runtime.formatting import counted

from ..base.commands import Command, command, keys_text
from ..base.needs import Need, sentence
from ..state.document import Document
from ..state.parts import Part
from ..work.frame_runs import LiveSolver, RunState
from .context import Context, Feature
from .edit_summary import EditSummaryFeature
from .propagation import PropagationFeature
from .run_history.panel import RunsPanel

_LIVE = "Complete blocks again after each edit and each change of the filter's parameters, the selected ones first"


class RunsFeature(Feature):
    """The commands of runs."""

    at_start = True
    more_commands = (
        Command("live", "&Live", _LIVE, "ph.lightning", "Ctrl+Shift+L", checkable=True, on=True, remembered="live"),
    )

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._waiting = WeakSet[Document]()
        """Frames that run once their blocks are extracted."""
        context.loader.busy_changed.connect(self._run_waiting)
        self._pause = context.actions["pause"]
        self.live = LiveSolver(self.workspace, context.runs, context.actions["live"])
        self._rest = QToolButton()
        self._rest.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._rest.setToolTip(
            "Their depth is of other parameters or an earlier state of the block; the views show it in grey"
        )
        self._rest.clicked.connect(lambda: context.actions["run"].trigger())
        row = context.feature(EditSummaryFeature).line.row
        row.addWidget(self._rest)
        row.addStrut(self._rest.sizeHint().height())  # so that the images do not move when it comes
        self._rest.hide()
        later = Part.RESULTS | Part.SOME_RESULTS | Part.RUNNING
        context.refresh.add("stale blocks", self._offer_rest, Part.FRAME | Part.LABELS | Part.PARAMETERS, later)
        context.refresh.add("run state", self._show_state, Part.FRAME | Part.RUNNING | Part.LOADING)
        first = Qt.ConnectionType.SingleShotConnection  # it keeps the history from the first run on
        context.runs.state_changed.connect(lambda: context.feature(RunsPanel), first)
        context.runs.ended.connect(context.notes.show_message)
        context.runs.failed.connect(lambda error: context.notes.report("The run failed", error))

    def _offer_rest(self) -> None:
        """Offer to run the blocks with stale depth, unless they are running."""
        stale: set[int] = set()
        if (document := self.workspace.shown) is not None and self.context.runs.state.free:
            document.update_depth()
            stale = set(document.stale_blocks()).difference(self.context.runs.current.resolving)
        self._rest.setVisible(bool(stale))
        is_are = "is" if len(stale) == 1 else "are"
        keys = keys_text(self.context.actions["run"].shortcuts())
        self._rest.setText(f"{counted(len(stale), 'block')} {is_are} stale: run" + (f" ({keys})" if keys else ""))

    @command("run_all", "Run &all blocks", keys="Ctrl+F5", needs=Need.BLOCKS | Need.IDLE)
    def _run_all(self) -> None:
        """Complete all blocks, also those with an up-to-date result."""
        self.context.runs.current.start()

    @command(
        "run_selected", "Run selec&ted blocks", icon="ph.play-circle", keys="Shift+F5", needs=Need.SELECTION | Need.IDLE
    )
    def _run_selected(self) -> None:
        """Complete the selected blocks only."""
        self.context.runs.current.start_selected()

    def _why_no_step(self) -> str:
        return "" if self._is_paused or self.context.runs.state.free else "Pause the run first."

    @command("step", "&Step", icon="ph.skip-forward", keys="F7", needs=Need.BLOCKS, why_off=_why_no_step)
    def _step(self) -> None:
        """Run one iteration, then pause."""
        self.context.runs.current.step()

    @property
    def _propagation(self) -> PropagationFeature | None:
        """What propagates blocks, while it does."""
        feature = self.context.made(PropagationFeature)
        return feature if feature is not None and feature.run is not None else None

    def _why_no_cancel(self) -> str:
        rests = self.context.runs.state in (RunState.IDLE, RunState.STOPPING) and self._propagation is None
        return sentence(Need.GOING) if rests else ""

    @command("cancel", "&Cancel run", icon="ph.stop", keys="Shift+F6", needs=Need.FRAME, why_off=_why_no_cancel)
    def _cancel(self) -> None:
        """Cancel the run, or what is completed again, and a propagation; completed blocks keep their results."""
        if self._propagation is not None:
            self._propagation.stop()
        self.context.runs.current.cancel()

    def _why_no_extrapolation(self) -> str:
        document = self.workspace.current
        if not document.valid_results():
            return "Run the blocks first."
        return "The rest is extrapolated already." if document.extrapolated else ""

    @command(
        "extrapolate",
        "&Extrapolate the rest",
        icon="ph.question",
        needs=Need.RESULTS | Need.IDLE,
        why_off=_why_no_extrapolation,
    )
    def _extrapolate(self) -> None:
        """Extrapolate depth where no block could be completed, for programs that need depth everywhere; these pixels
        are marked as extrapolated."""
        self.context.runs.current.extrapolate()

    @command("clear_results", "Clear results", icon="ph.backspace", needs=Need.RESULTS)
    def _clear_results(self) -> None:
        """Delete the completed depth of this frame."""
        self.context.runs.current.clear_results()

    @property
    def _is_awaited(self) -> bool:
        """Whether the blocks of the current frame are being extracted."""
        return self.context.runs.state.free and self.workspace.current in self.context.loader.extracting

    def _why_no_run(self) -> str:
        missing = (Need.BLOCKS | Need.IDLE) & self.context.missing()
        return sentence(missing) if missing and not self._is_awaited else ""

    @command("run", "&Run", icon="ph.play", keys="F5", needs=Need.FRAME, why_off=_why_no_run)
    def _run(self) -> None:
        """Complete all blocks that have no up-to-date result."""
        if self._is_awaited:
            self._waiting.add(self.workspace.current)
            self.notes.show_message("The blocks are run as soon as they are extracted.")
        else:
            self.context.runs.current.start_changed()

    def _run_waiting(self) -> None:
        for document in [one for one in self._waiting if one not in self.context.loader.extracting]:
            self._waiting.discard(document)
            if document in self.workspace.open and document.counts():
                self.context.runs.of(document).start_changed()

    @property
    def _is_paused(self) -> bool:
        return self.context.runs.state is RunState.PAUSED

    @command("pause", "&Pause", icon="ph.pause", keys="F6", checkable=True, needs=Need.GOING)
    def _set_paused(self, on: bool) -> None:
        """Pause the run, or resume it."""
        if on != self._is_paused:
            self.context.runs.current.toggle_pause()

    def _show_state(self) -> None:
        """Show whether a run goes on or is paused; views without a result say what is done for it."""
        if (document := self.workspace.shown) is not None:
            under_way = ""
            if document.current_depth() is None:
                extracting = "Extracting blocks…" if document in self.context.loader.extracting else ""
                under_way = "Completing…" if self.context.runs.state.going else extracting
            self.views.show_found(under_way=under_way)
        self._pause.setChecked(self._is_paused)
        self._pause.setText("Resume" if self._is_paused else "&Pause")
