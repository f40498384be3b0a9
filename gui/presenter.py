"""Brings the state of the workspace and of the run to the window's widgets."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QPoint
from PySide6.QtWidgets import QMenu

from gui.blocks.block_rows import block_rows, colour_table
from gui.state.session import Session
from gui.tools.base import label_at
from gui.work.runs import Previews, RunState
from ilf.blocks import Block, Box
from ilf.cloud import point_cloud
from ilf.completion import Completion
from ilf.drawing.stages import STAGES
from ilf.filter.convergence import IterationRecord
from ilf.parameters import Parameters

if TYPE_CHECKING:
    from gui.main_window import MainWindow

_THUMBNAIL_WIDTH = 160
_FRAME_ACTIONS = (
    "export",
    "close_frame",
    "new_block",
    "select_all",
    "tool_select",
    "tool_paint",
    "tool_erase",
    "tool_split",
    "brush_smaller",
    "brush_larger",
    "fit",
    "one_to_one",
    *(f"stage_{name}" for name in STAGES),
)
_MENU = "run_selected zoom_block | merge_blocks delete_blocks lock_blocks | new_block fit"


class Presenter(QObject):
    """One method per thing that can change: it reads the workspace and sets widgets.

    The `take_` methods go the other way, and bring what a panel says to where it belongs.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._workspace = window.workspace
        self._completion: Completion | None = None
        self._cloud_of = ""
        self._error: NDArray[np.float32] | None = None
        self._error_of: Completion | None = None
        self._previews: dict[int, tuple[Block, NDArray[np.float32]]] = {}
        self._shown_depth: NDArray[np.float32] | None = None
        self._table: NDArray[np.uint8] | None = None
        self._cloud_stale = True
        self._cursor: tuple[int, int] | None = None

    # frames

    def show_frames(self) -> None:
        """The list of open frames."""
        frames = self._window.frames
        listed = set(frames.keys())
        for key in listed - {session.key for session in self._workspace.sessions}:
            frames.remove_frame(key)
        for session in self._workspace.sessions:
            if session.key not in listed:
                rgb = session.frame.rgb
                height = max(round(_THUMBNAIL_WIDTH * rgb.shape[0] / rgb.shape[1]), 1)
                small = cv2.resize(rgb, (_THUMBNAIL_WIDTH, height), interpolation=cv2.INTER_AREA)
                frames.add_frame(session.key, session.name, small, "")
        self._show_frame_details()

    def show_session(self) -> None:
        """Everything about the present frame."""
        window = self._window
        shown = self._workspace.has_session
        if shown:
            session = self._workspace.session
            window.views.set_frame(session.frame.rgb, session.frame.depth)
            window.frames.set_current(session.key)
            window.setWindowTitle(f"{session.name} - ILF Studio")
        else:
            window.views.clear()
            window.setWindowTitle("ILF Studio")
        self._cursor = None
        self._table = None
        self.show_labels(None)
        self.show_results()
        self.show_selection()
        self.show_run_state()
        self.show_tool()
        self.show_readout(None)
        self.show_brush(window.editor.brush_radius)

    def _show_frame_details(self) -> None:
        for session in self._workspace.sessions:
            height, width = session.frame.shape
            results = session.valid_results()
            state = f"{len(results)} of {len(session.counts())} blocks run" if results else "not run"
            detail = f"{width} x {height}, {session.frame.missing_share:.1%} missing\n{state}"
            self._window.frames.update_detail(session.key, detail)

    # blocks

    def show_labels(self, box: Box | None) -> None:
        """The label map, of which a box has changed."""
        if not self._workspace.has_session:
            self._window.blocks.set_rows([])
            return
        self._draw_blocks(box)
        self._show_rows()
        self._window.blocks.select(self._workspace.session.selected)
        self._show_frame_details()

    def _draw_blocks(self, box: Box | None = None) -> None:
        """All of the overlay if colours have changed, else just the box that has."""
        session, views = self._workspace.session, self._window.views
        table = colour_table(session)
        if self._table is None or not np.array_equal(table, self._table):
            views.set_blocks(session.labels, table)
        elif box is not None:
            views.update_blocks_region(*box, session.labels[box])
        self._table = table

    def show_infos(self) -> None:
        """Names, colours, locks, visibility."""
        self.show_labels(None)
        self.show_run_state()
        self.show_parameters()

    def _show_rows(self) -> None:
        if self._workspace.has_session:
            rows = block_rows(self._workspace.session, self._window.runs, self._workspace.parameters)
            self._window.blocks.set_rows(rows)

    def show_selection(self) -> None:
        """The chosen blocks."""
        window = self._window
        chosen = self._workspace.session.selected if self._workspace.has_session else []
        if self._workspace.has_session:
            self._draw_blocks()  # a block that is to be painted needs its colour, and its row
            self._show_rows()
            window.views.set_selected(chosen)
        window.blocks.select(chosen)
        self.show_run_state()
        self.show_parameters()
        self.show_curves()

    def zoom_to_block(self) -> None:
        """Show the chosen block large."""
        session = self._workspace.session
        rows, columns = np.nonzero(np.isin(session.labels, session.selected))
        if rows.size:
            self._window.views.zoom_to(
                slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1)
            )

    def show_context_menu(self, place: QPoint, x: float, y: float) -> None:
        """Choose what is under the pointer, and offer what can be done with it."""
        if not self._workspace.has_session:
            return
        session = self._workspace.session
        label = label_at(session, x, y)
        if label not in session.selected:
            self._workspace.select([label] if label else [])
        self.show_block_menu(place)

    def show_block_menu(self, place: QPoint) -> None:
        """Commands on blocks."""
        menu = QMenu(self._window)
        for name in _MENU.split():
            if name == "|":
                menu.addSeparator()
            else:
                menu.addAction(self._window.actions_[name])
        menu.exec(place)
        menu.deleteLater()

    # parameters

    def show_parameters(self) -> None:
        """Parameters of all blocks, or of the chosen one."""
        window = self._window
        label = self._chosen()
        name = self._workspace.session.info(label).name if label else None
        panel = window.filter_panel
        own = label and panel.for_chosen_block
        common = self._workspace.parameters
        shown = self._workspace.session.parameters_of(label, common) if own else common
        panel.show_parameters(shown, name)
        window.extraction_panel.form.set_parameters(self._workspace.extraction_parameters)
        self._show_rows()

    def take_parameters(self, parameters: Parameters) -> None:
        """Values set in the form go to all blocks or to the chosen one."""
        label = self._chosen() if self._window.filter_panel.for_chosen_block else 0
        self._workspace.set_parameters(parameters, label or None)
        self.resolve()

    def resolve(self) -> None:
        """Solve the chosen block anew with its present values, where that is wanted."""
        label = self._chosen()
        if label and self._window.actions_["live"].isChecked() and label in self._workspace.session.counts():
            self._window.runs.resolve(label)

    def _chosen(self) -> int:
        chosen = self._workspace.session.selected if self._workspace.has_session else []
        return chosen[0] if chosen else 0

    # results

    def show_results(self) -> None:
        """The completed depth, as far as it goes."""
        window = self._window
        self._completion = self._workspace.session.completion() if self._workspace.has_session else None
        if self._workspace.has_session:
            self._show_present_depth()
            self._show_frame_details()
        window.actions_.enable(self._completion is not None, "clear_results")
        self.show_expected_error()
        self._cloud_stale = True
        self.show_cloud()
        self.show_curves()
        self._show_rows()

    def show_preview(self, previews: Previews) -> None:
        """The running blocks' depth as it stands; none at the end of a run."""
        self._previews |= {block.label: (block, depth) for block, depth in previews}
        if self._workspace.has_session:
            self._show_present_depth()

    def _show_present_depth(self) -> None:
        """What is done already, and over it the last that is known of the blocks that run."""
        runs = self._window.runs
        running = set(runs.running) if runs.session is self._workspace.session else set()
        self._previews = {label: preview for label, preview in self._previews.items() if label in running}
        shown = self._completion.depth if self._completion else None
        if self._previews:
            shown = (self._workspace.session.frame.depth if shown is None else shown).copy()
            for block, depth in self._previews.values():
                shown[block.box][block.mask] = depth
        self._show_depth(shown)

    def _show_depth(self, depth: NDArray[np.float32] | None) -> None:
        self._shown_depth = depth
        self._window.views.set_result(depth)
        self.show_readout(self._cursor)

    def show_expected_error(self) -> None:
        """The expected error of the results, when it is looked at and no run is changing them."""
        window = self._window
        if self._completion is None:
            self.take_expected_error(None, None)
        elif (
            self._completion is not self._error_of
            and window.views.shows_expected_error
            and window.runs.state in (RunState.IDLE, RunState.PAUSED)
        ):
            window.errors.ask(self._workspace.session.frame, self._completion)

    def take_expected_error(self, completion: Completion | None, error: NDArray[np.float32] | None) -> None:
        """An expected error has been found; what has been overtaken by other results is not shown."""
        if completion is not self._completion:
            return
        self._error_of, self._error = completion, error
        if self._workspace.has_session:
            self._window.views.set_expected_error(error)
        self.show_readout(self._cursor)

    def show_cloud(self) -> None:
        """The point cloud, when it is looked at and has changed."""
        window = self._window
        if window.centre.currentWidget() is not window.cloud or not self._cloud_stale:
            return
        self._cloud_stale = False
        if not self._workspace.has_session:
            window.cloud.set_message()
            return
        session = self._workspace.session
        frame = session.frame
        if frame.intrinsics is None:
            window.cloud.set_message(
                "This frame has no camera intrinsics, which a point cloud needs.\n"
                "Open it again and choose a camera, or give fx, fy, cx, cy."
            )
            return
        depth = self._completion.depth if self._completion else frame.depth
        cloud = point_cloud(depth, frame.rgb, frame.intrinsics)
        window.cloud.set_cloud(cloud.points, cloud.colours, reset=session.key != self._cloud_of)
        if self._completion is not None:
            window.cloud.set_filled(self._completion.filled[np.isfinite(depth)])
        self._cloud_of = session.key

    # curves

    def show_curves(self) -> None:
        """Records of the chosen block, or of the running one if none is chosen."""
        curves = self._window.curves
        label = self._curve_label() if self._workspace.has_session else 0
        if label == 0:
            curves.clear()
            return
        info = self._workspace.session.info(label)
        parameters = self._parameters_of_curve(label)
        curves.set_block(label, info.name, info.colour)
        curves.set_s_criteria(parameters.s_criteria if _uses_s_criteria(parameters) else None)
        curves.set_records(self._records_of(label))

    def _parameters_of_curve(self, label: int) -> Parameters:
        """What the curve was, or would be, run with."""
        session, runs = self._workspace.session, self._window.runs
        result = session.valid_results().get(label)
        running = runs.session is session and label in runs.running
        if result is not None and result.history and not running:
            return result.parameters
        return session.parameters_of(label, self._workspace.parameters)

    def start_curves(self, label: int) -> None:
        """A block of the run is about to have its first records."""
        if label == self._curve_label():
            self.show_curves()

    def add_records(self, label: int, records: list[IterationRecord]) -> None:
        """New records of a running block."""
        runs = self._window.runs
        if runs.session is self._session() and label == self._curve_label():
            curves = self._window.curves
            if len(curves.records) + len(records) == len(runs.live[label]):
                curves.append_records(records)
            else:
                curves.set_records(runs.live[label])

    def _curve_label(self) -> int:
        """The chosen block; while that has no curve yet, the one that runs, or else the first that has been run."""
        chosen = self._chosen()
        if chosen and self._records_of(chosen):
            return chosen
        runs = self._window.runs
        running = runs.running if runs.session is self._session() else []
        return running[-1] if running else chosen or self._first_run()

    def _first_run(self) -> int:
        session = self._session()
        results = session.valid_results() if session else {}
        run = [label for label, result in results.items() if result.history]
        return run[0] if run else 0

    def _records_of(self, label: int) -> list[IterationRecord]:
        runs = self._window.runs
        if runs.session is self._session() and label in runs.running:
            return runs.live[label]
        result = self._workspace.session.valid_results().get(label)
        return list(result.history) if result is not None else []

    def _session(self) -> Session | None:
        return self._workspace.session if self._workspace.has_session else None

    # state

    def show_run_state(self) -> None:
        """What can be done now, and how far the run is."""
        window = self._window
        runs = window.runs
        actions = window.actions_
        shown = self._workspace.has_session
        free = runs.free and not window.loader.busy
        counts = self._workspace.session.counts() if shown else {}
        chosen = set(self._workspace.session.selected) & set(counts) if shown else set()
        unlocked = chosen - self._workspace.session.locked if shown else set()
        own_run = shown and runs.session is self._workspace.session
        actions.enable(shown, *_FRAME_ACTIONS)
        actions.enable(shown and free, "extract", "load_blocks")
        actions.enable(bool(chosen), "zoom_block")
        actions.enable(bool(unlocked), "delete_blocks")
        actions.enable(len(unlocked) > 1, "merge_blocks")
        actions.enable(shown and bool(self._workspace.session.selected), "lock_blocks")
        actions.enable(free and bool(counts), "run")
        actions.enable(free and bool(chosen), "run_selected")
        actions.enable((free and bool(counts)) or (own_run and runs.state is RunState.PAUSED), "step")
        actions.enable(runs.state in (RunState.RUNNING, RunState.PAUSED), "pause", "cancel")
        actions["pause"].setChecked(runs.state is RunState.PAUSED)
        actions["pause"].setText("Resume" if runs.state is RunState.PAUSED else "&Pause")
        window.progress.setVisible(not runs.free or window.loader.busy)
        if not runs.free:
            window.progress.setRange(0, 100)
            window.progress.setValue(round(100 * runs.share_done))
            other = "" if own_run or runs.session is None else f"{runs.session.name}: "
            window.progress.setFormat(f"{other}{runs.state.value} %p%")
        self._show_rows()

    def show_loading(self, what: str) -> None:
        """What is being opened or extracted."""
        window = self._window
        if what:
            window.progress.setRange(0, 0)
            window.progress.setFormat(what)
            window.hint.setText(what)
        else:
            self.show_tool()
        self.show_run_state()

    def show_tool(self, _name: str = "") -> None:
        """What a click would do now."""
        window = self._window
        name = next(name for name, tool in window.editor.tools.items() if tool is window.editor.tool)
        window.actions_[f"tool_{name}"].setChecked(True)
        window.hint.setText(window.editor.tool.hint if self._workspace.has_session else "Open a frame: Ctrl+O")

    def show_brush(self, radius: float) -> None:
        """Size of the brush."""
        self._window.brush.blockSignals(True)
        self._window.brush.setValue(round(radius))
        self._window.brush.blockSignals(False)
        self._window.brush_label.setText(f" {2 * radius:g} px ")
        self._window.brush.setToolTip(f"Brush: {2 * radius:g} px across ([ and ])")

    def take_brush(self, radius: int) -> None:
        """The slider was moved."""
        self._window.editor.brush_radius = float(radius)
        self.show_brush(float(radius))

    def show_readout(self, pixel: tuple[int, int] | None) -> None:
        """Position, block and depths under the cursor."""
        self._cursor = pixel
        readout = self._window.readout
        if pixel is None or not self._workspace.has_session:
            readout.setText("")
            return
        session = self._workspace.session
        x, y = pixel
        label = int(session.labels[y, x])
        block = session.info(label).name if label else "no block"
        depth_in = float(session.frame.depth[y, x])
        parts = [f"x {x}, y {y}", html.escape(block), f"in {_metres(depth_in)}"]
        if self._shown_depth is not None:
            depth_out = float(self._shown_depth[y, x])
            parts.append(f"out {_metres(depth_out)}")
            if np.isfinite(depth_in) and np.isfinite(depth_out):
                parts.append(f"{1000 * (depth_out - depth_in):+.1f} mm")
            if self._error is not None and self._error_of is self._completion and np.isfinite(self._error[y, x]):
                parts.append(f"\u00b1 {_error_text(float(self._error[y, x]))}")
        readout.setText("  |  ".join(parts))


def _uses_s_criteria(parameters: Parameters) -> bool:
    """Whether the stop criterion has a part in a run: in the linear schedule alone it has none."""
    return parameters.filter == "edge-aware" or parameters.schedule == "staged"


def _error_text(error: float) -> str:
    millimetres = 1000 * error
    return f"{millimetres:.{1 if millimetres < 10 else 0}f} mm" if error < 1 else f"{error:.2f} m"


def _metres(depth: float) -> str:
    return f"{depth:.3f} m" if np.isfinite(depth) else "missing"
