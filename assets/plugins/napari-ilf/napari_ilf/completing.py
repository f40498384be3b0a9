"""The widget that completes a depth layer with its image layer, in a thread, and adds the results as layers."""

from __future__ import annotations

import threading
import time
from collections.abc import Generator
from typing import Any, Optional

import numpy as np
from magicgui.widgets import ComboBox, Container, FloatSpinBox, Label, ProgressBar, PushButton, create_widget
from napari.layers import Image, Labels
from napari.qt.threading import create_worker
from napari.utils.notifications import show_info
from napari.viewer import Viewer
from numpy.typing import NDArray

import ilf

from .reading import INTRINSICS, LayerData, depth_layer, error_layer

_BETWEEN_S = 0.1
"""Minimum time between two updates of the progress bar [s]."""

Result = tuple[ilf.Completion, NDArray[np.float32]]


class CompletionWidget(Container):  # type: ignore[type-arg]
    """Image, depth and blocks (optional) as layers, units, preset, and a button that completes and cancels."""

    def __init__(self, napari_viewer: Viewer) -> None:
        self._viewer = napari_viewer
        self._cancelled = threading.Event()
        self._worker: Any = None
        self._depth: Image | None = None
        self.image: Any = create_widget(label="Colour", annotation=Image)
        self.depth: Any = create_widget(label="Depth", annotation=Image)
        self.blocks: Any = create_widget(label="Blocks", annotation=Optional[Labels])  # noqa: UP045 - for magicgui
        self.units = FloatSpinBox(
            label="Units per metre", value=1, min=1e-6, max=1e9, tooltip="1: metres, 1000: millimetres"
        )
        self.preset = ComboBox(label="Preset", choices=list(ilf.PRESETS))
        self.button = PushButton(text="Complete")
        self.progress = ProgressBar(max=1000, visible=False)
        self.message = Label()
        fields = self.image, self.depth, self.blocks, self.units, self.preset
        super().__init__(widgets=[*fields, self.button, self.progress, self.message])
        self.depth.changed.connect(self._propose_units)
        self.button.changed.connect(self._start_or_cancel)

    def _propose_units(self, layer: Image | None) -> None:
        if layer is not None:
            self.units.value = 1000 if np.issubdtype(np.asarray(layer.data).dtype, np.integer) else 1

    def _start_or_cancel(self) -> None:
        if self._worker is not None:
            self._cancelled.set()
            self.button.enabled = False
            return
        try:
            frame = self._frame()
        except ilf.IlfError as error:
            self.message.value = str(error)
            return
        self._depth = self.depth.value
        labels = None if self.blocks.value is None else np.array(self.blocks.value.data)
        self._cancelled.clear()
        self._worker = create_worker(_complete, frame, labels, self.preset.value, self._cancelled)
        self._worker.yielded.connect(self._show_progress)
        self._worker.returned.connect(self._show_result)
        self._worker.errored.connect(self._show_error)
        self._worker.finished.connect(self._end)
        self.button.text, self.message.value = "Cancel", ""
        self.progress.value, self.progress.visible = 0, True
        self._worker.start()

    def _frame(self) -> ilf.RGBDFrame:
        image, depth = self.image.value, self.depth.value
        if image is None or depth is None or image is depth:
            raise ilf.IlfError("Select an image layer with colour, and another one with depth.")
        values = np.asarray(depth.data)
        if values.ndim != 2:
            raise ilf.IlfError(f"{depth.name} has {values.ndim} dimensions: depth must be one image (H, W).")
        metres = values.astype(np.float32) / np.float32(self.units.value)
        return ilf.RGBDFrame(
            rgb=np.asarray(image.data), depth=metres, intrinsics=depth.metadata.get(INTRINSICS), name=depth.name
        )

    def _show_progress(self, share: float) -> None:
        self.progress.value = round(1000 * share)

    def _show_result(self, result: Result | None) -> None:
        if result is None:
            self.message.value = "Cancelled."
            return
        completion, error = result
        name = completion.frame.name
        blocks = completion.run.blocks.labels, {"name": f"{name} blocks", "opacity": 0.4, "visible": False}, "labels"
        self._show(depth_layer(completion.depth, f"{name} completed", completion.frame.intrinsics))
        self._show(error_layer(error, f"{name} expected error", visible=False))
        if self.blocks.value is None:
            self._show(blocks)
        filled, missing = int(completion.filled.sum()), int(np.isnan(completion.depth).sum())
        self.message.value = f"{filled} pixels filled, {missing} still missing."
        for note in completion.notes:
            show_info(note)

    def _show(self, layer: LayerData) -> None:
        """Add a layer at the place of the depth layer, or replace the data of the one with its name."""
        data, how, kind = layer
        if how["name"] in self._viewer.layers:
            self._viewer.layers[how["name"]].data = data
        else:
            place = {} if self._depth is None else {"scale": self._depth.scale, "translate": self._depth.translate}
            getattr(self._viewer, f"add_{kind}")(data, **how, **place)

    def _show_error(self, error: Exception) -> None:
        self.message.value = str(error)

    def _end(self) -> None:
        self._worker = None
        self.button.text, self.button.enabled = "Complete", True
        self.progress.visible = False


def _complete(
    frame: ilf.RGBDFrame, labels: NDArray[np.int32] | None, preset: str, cancelled: threading.Event
) -> Generator[float, None, Result | None]:
    """Complete a frame; yields the share of blocks that have been begun, and returns None if it was cancelled."""
    run = ilf.Run.of(frame, labels, preset)
    begun, shown = set[int](), time.monotonic()
    with run.steps() as steps:
        for step in steps:
            if cancelled.is_set():
                return None
            begun.add(step.label)
            if time.monotonic() - shown > _BETWEEN_S:
                shown = time.monotonic()
                yield min(len(begun) / len(steps.blocks), 1.0)
    completion = steps.completion()
    return completion, ilf.expected_error(completion)
