"""Shows the depth of the current frame in the 3D view while that view is visible."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from ilf.data.camera import Camera

from ..base import theme
from ..base.commands import command
from ..state.document import Document
from ..state.parts import Part
from ..views.cloud.canvas import HINT, MOVES
from ..views.cloud.cloud_view import CloudView
from ..views.cloud.scene import ColourBy, Mark, Scene, compose, signed_table
from ..views.colours import FIXED, KINDS, Range
from ..views.interaction import PointerEvent, PointerKind
from ..views.layers import Layer, content_of
from ..views.view_data import MarkedDepth, colour_table
from ..widgets.basics import Late
from .context import Context
from .expected_error import ErrorFeature
from .panel import Panel

_NO_INTRINSICS = (
    "This frame has no camera intrinsics, which a point cloud needs.\n"
    "Open it again and choose a camera, or give fx, fy, cx, cy."
)
_NONE_SELECTED = "No block is selected.\nClick a block in the images or in the table, or show the whole cloud."
_NOTHING_KNOWN = "There is no depth to show."


class CloudPanel(Panel):
    """Point cloud of the current frame in the centre, rebuilt in a worker thread when the frame or a setting changes.

    The position of the pointer is marked in cloud and images. A click on a point selects its block, or goes to the tool
    if the tool needs points only.
    """

    title, group = "Point cloud", None
    parts = Part.DEPTH | Part.EXPECTED_ERROR | Part.GROUND_TRUTH | Part.COMPARED | Part.INFOS | Part.SELECTION
    parts |= Part.PROPOSAL
    deferred = Part.SOME_RESULTS
    what = "point cloud"

    @classmethod
    def declare(cls, context: Context) -> None:
        super().declare(context)
        context.centre.add_cloud(Late(lambda: context.feature(cls).widget))

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._request: Scene | None = None
        self._made: Scene | None = None
        self._proposed: tuple[NDArray[np.float32], NDArray[np.float32] | None, NDArray[np.float32]] | None = None
        """The last depth, the proposal, and the depth with it."""
        self._seen = ""
        """Key of the document whose cloud was shown last; its viewpoint is kept."""
        self._blocks: tuple[NDArray[np.int32], NDArray[np.uint8], NDArray[np.bool_]] | None = None
        """Label map, colours, and pixels without block of the last request."""
        self.view = cloud = CloudView()
        actions, mark = context.actions, context.refresh.mark
        cloud.add_switches(*(actions[name] for name in ("cloud_raw", "cloud_selected_only", "cloud_beside")))
        cloud.canvas.drawing.failed.connect(self.fail)
        self.views.cursorMoved.connect(self._show_value)
        self.views.cursorMoved.connect(cloud.canvas.mark)
        cloud.canvas.hovered.connect(self._hover)
        cloud.canvas.hover_changed.connect(lambda _: mark("hint"))
        cloud.canvas.picked.connect(self._pick)
        for changed in (self.views.shownChanged, self.views.ranges.changed):
            changed.connect(self.redraw)
        cloud.colours_changed.connect(lambda: mark(self.title, "error"))
        errors = context.feature(ErrorFeature)
        errors.watch(lambda: self.visible and cloud.colour_by is ColourBy.EXPECTED)
        self.workspace.on(Part.FRAME, self._turn)

    def make(self) -> QWidget:
        return self.view

    @command("turn_cloud", "&Images or point cloud", icon="ph.cube", keys="Ctrl+3")
    def _turn_cloud(self) -> None:
        """Show the point cloud in place of the images, also if it is beside them, or the images again."""
        self.context.actions["cloud_beside"].setChecked(False)
        tabs = self.context.centre.tabs
        tabs.setCurrentIndex(1 - tabs.currentIndex())

    @command("cloud_beside", "&3D beside the images", icon="ph.columns", keys="Ctrl+Shift+B", checkable=True)
    def _show_beside(self, on: bool) -> None:
        """Show the point cloud beside the images instead of in its own tab."""
        self.context.centre.set_side_by_side(on)

    def _why_no_raw(self) -> str:
        there = not self.visible or self.workspace.shown is None
        return "" if there or self.workspace.current.completion() is not None else "Not available now."

    @command("cloud_raw", "3D: raw depth", icon="ph.eye", checkable=True, held="X", why_off=_why_no_raw)
    def _show_raw(self, on: bool) -> None:
        """Show the point cloud before completion; holding X in the 3D view does the same."""
        self.redraw()

    @command("cloud_selected_only", "3D: selected blocks onl&y", icon="ph.selection", checkable=True)
    def _show_selected_only(self, on: bool) -> None:
        """Show only the selected blocks in 3D."""
        self.redraw()

    def refresh(self, parts: Part) -> None:
        """Show the cloud, or the reason why there is none."""
        if parts & (Part.FRAME | Part.LABELS | Part.STROKE | Part.INFOS):
            self._blocks = None
        if (document := self.workspace.shown) is None:
            self.view.set_message()
            self.view.set_unavailable({})
            return
        self.view.set_unavailable(self._unavailable(document))
        if document.frame.intrinsics is None:
            self._drop(_NO_INTRINSICS)
        elif self.context.actions.is_on("cloud_selected_only") and not document.selected:
            self._drop(_NONE_SELECTED)
        else:
            request = self._present_request(document, document.frame.intrinsics)
            asked, made = self._request, self._made
            if asked is None or (request.geometry, request.look) != (asked.geometry, asked.look):
                self._request = request
                before = made if made is not None and request.geometry == made.geometry else None
                self.requests.ask(partial(compose, request, before), partial(self._take, request))

    @property
    def hint(self) -> str:
        """What the mouse does in the cloud, if it is over it or only the cloud is visible; "" otherwise."""
        if self.views.isVisible() and not self.view.canvas.underMouse():
            return ""
        editor = self.context.editor
        return f"{editor.hint} | {MOVES}" if editor.tool.points_only else HINT

    def _turn(self) -> None:
        """Release the data of a frame that is not shown any more."""
        document = self.workspace.shown
        if self._request is not None and (document is None or document.key != self._request.key):
            self._drop()

    def _present_request(self, document: Document, intrinsics: Camera) -> Scene:
        completion, by = document.completion(), self.view.colour_by
        if by in self._unavailable(document):
            by = ColourBy.COLOUR
        raw = completion is not None and self.context.actions.is_on("cloud_raw")
        viewed_iteration = None if raw else self.workspace.viewed_iteration
        title = f"{by.text} of the raw depth" if raw else by.text
        if viewed_iteration is not None:
            depth, title = viewed_iteration.depth, f"{by.text} {viewed_iteration.text}"
        else:
            depth = document.frame.depth if completion is None or raw else completion.depth
            if document.proposal is not None and not raw:
                known, title = self._proposed, f"{title}, with the proposed surface"
                # the same object for the same two, so that the cloud is not built again
                if known is None or known[0] is not depth or known[1] is not document.proposal:
                    self._proposed = known = depth, document.proposal, document.with_proposal(depth)
                depth = known[2]
        chosen = frozenset(document.selected) if self.context.actions.is_on("cloud_selected_only") else None
        if chosen is None and by is not ColourBy.BLOCK:
            self._blocks = None
        shades = theme.colours(self.view.palette())
        # visible on the background, and unlike any value
        plain = shades.grid if shades.is_dark else shades.muted
        layer, unit = Layer(), ""
        if by is ColourBy.BLOCK:
            labels, colours, _ = self._present_blocks(document)
            layer = Layer((labels, colours), picture=lambda: colours[:, :3][labels])
        elif by.content:
            layer, unit = self._layer(document, depth, by.content, shades), content_of(by.content).unit
        lacking = {ColourBy.EXPECTED: "measured", ColourBy.ERROR: "no ground truth"}
        if document.compared:
            lacking[ColourBy.DIFFERENCE] = f"not in {document.compared[0].name}"
        note = ""
        if not layer.arrays:
            notes = {ColourBy.COLOUR: "", ColourBy.FILLED: "image colours where measured"}
            note, rgb = notes.get(by, "image colours until it is computed"), document.frame.rgb
            layer = Layer((rgb,), picture=lambda: rgb)
        return Scene(
            document.key,
            intrinsics,
            depth,
            layer,
            unit,
            title,
            note,
            plain,
            lacking.get(by, ""),
            self._marks(document, by, shades, plain),
            chosen,
            None if chosen is None else self._present_blocks(document)[0],
        )

    def _layer(self, document: Document, depth: NDArray[np.float32], content: str, shades: theme.Colours) -> Layer:
        """The layer of a content of the images for this depth, in their colour ranges."""
        data = copy(self.views.data)
        data.result, data.expected, data.error_is_outdated = MarkedDepth(depth), document.expected_error(), False
        data.swipe_column, data.shows_a_as_result = None, False
        data.ranges = {kind: self._range(kind) for kind in KINDS}
        data.colours = shades
        found = content_of(content).find(data, content)
        # in the images, zero is close to the background, where a surface without error would be invisible
        return replace(found, table=signed_table()) if content_of(content).range_kind == "signed" else found

    def _range(self, kind: str) -> Range:
        """Range mode of a kind, with its fixed levels if any; depth uses the levels of the images."""
        if kind == "depth":
            return Range(FIXED, self.views.ranges.depth)
        one = self.views.ranges.of(kind)
        return replace(one) if one.locked or one.mode == FIXED else replace(one, levels=None)

    def _marks(self, document: Document, by: ColourBy, shades: theme.Colours, plain: QColor) -> tuple[Mark, ...]:
        completion, unsupported = document.completion(), document.unsupported()
        if by is ColourBy.BLOCK:
            return ((self._present_blocks(document)[2], plain, "no block"),)
        if by is ColourBy.FILLED and completion is not None:
            filled = (completion.filled, shades.accent, "{} filled")
            return filled, (completion.extrapolated, shades.warning, "{} extrapolated")
        if by is ColourBy.EXPECTED and unsupported is not None:
            return ((unsupported, shades.warning, "{} unsupported"),)
        return ()

    def _present_blocks(self, document: Document) -> tuple[NDArray[np.int32], NDArray[np.uint8], NDArray[np.bool_]]:
        if self._blocks is None:
            labels = document.labels.copy()
            self._blocks = labels, colour_table(document, int(labels.max())), labels == 0
        return self._blocks

    def _take(self, request: Scene, scene: Scene) -> None:
        if self._request is None or request.key != self._request.key:
            return
        self._made = scene
        if len(scene):
            self.view.show_scene(scene, reset=request.key != self._seen)
            self._seen = request.key
        else:
            self.view.set_message(_NOTHING_KNOWN)

    def _drop(self, message: str = "") -> None:
        """Show no cloud, and release the data of the last one."""
        self.requests.forget()
        self._request = self._made = self._blocks = self._proposed = None
        self.view.set_message(*([message] if message else []))

    def _show_value(self, pixel: tuple[int, int] | None) -> None:
        """Mark the value of a pixel on the colour bar."""
        layer = self._made.layer if self._made is not None and self._shows_present() else Layer()
        value = layer.value_at(*pixel, layer.arrays) if pixel is not None and layer.has_values else None
        self.view.bar.set_value(value)

    def _shows_present(self) -> bool:
        """Whether the visible cloud is of the current frame."""
        made = self._made
        return made is not None and self.workspace.shown is not None and self.workspace.shown.key == made.key

    def _hover(self, pixel: tuple[int, int] | None) -> None:
        if self._shows_present():
            self.views.navigation.point_at(pixel)

    def _pick(self, x: int, y: int, adds: bool) -> None:
        if not self._shows_present():
            return
        editor = self.context.editor
        if editor.tool.points_only:
            for kind in (PointerKind.PRESS, PointerKind.RELEASE):
                editor.pointer(PointerEvent(kind, x + 0.5, y + 0.5))
        else:
            self._choose(x, y, adds)

    def _choose(self, x: int, y: int, adds: bool) -> None:
        document = self.workspace.current
        label = int(document.labels[y, x])
        if label and adds:
            chosen = [one for one in document.selected if one != label]
            self.workspace.select(chosen if label in document.selected else [*chosen, label])
        elif not adds:
            self.workspace.select([label] if label else [])

    @staticmethod
    def _unavailable(document: Document) -> dict[ColourBy, str]:
        """Colourings that are not available -> reason."""
        completion, lacking = document.completion(), {}
        if completion is None:
            for by in (ColourBy.EXPECTED, ColourBy.DIFFERENCE, ColourBy.FILLED):
                lacking[by] = "No completed depth yet: run the frame first"
        elif not document.compared:
            lacking[ColourBy.DIFFERENCE] = "No run is ticked for comparison: tick one in the panel Runs"
        if document.frame.ground_truth is None:
            lacking[ColourBy.ERROR] = "This frame has no ground truth: load one"
        if not document.counts():
            lacking[ColourBy.BLOCK] = "There are no blocks yet: extract them first"
        return lacking
