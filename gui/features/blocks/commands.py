"""Commands on the selected blocks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ilf._runtime.formatting import counted
from ilf.errors import InputError
from ilf.segmentation.editing.cleaning import clean_up, count_slivers, delete, grow, merge, shrink, smooth
from ilf.segmentation.editing.cutting import piece_at
from ilf.segmentation.editing.patches import LabelPatch

from ...base.commands import command
from ...base.needs import Need
from ...tools.base import check_unlocked
from ...tools.editor import sliver_size
from ...tools.give import give_piece
from ...tools.select import merge_blocks
from ...tools.split import cut_suggested
from ..context import Context, Feature


class BlockCommands(Feature):
    """Commands on the selected blocks."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._editor = context.editor

    @command("delete_blocks", "&Delete blocks", icon="ph.trash", keys="Ctrl+Del", needs=Need.UNLOCKED)
    def delete(self) -> None:
        """Delete the selected blocks."""
        document = self.workspace.current

        def act() -> None:
            check_unlocked(document, document.selected)
            if document.edit(delete(document.labels, document.selected, document.locked), self._text("Delete")):
                self.workspace.select([])

        self._attempt(act)

    @command("merge_blocks", "&Merge blocks", icon="ph.intersect", keys="Ctrl+M", needs=Need.SEVERAL)
    def merge(self) -> None:
        """Merge the selected blocks into one."""
        self._attempt(lambda: merge_blocks(self._editor, list(self.workspace.current.selected)))

    def _why_none_selected(self) -> str:
        """Unlike for other commands, a selected block may have no pixels yet."""
        return "" if self.workspace.current.selected else "Select a block first."

    @command(
        "lock_blocks", "&Lock or unlock", icon="ph.lock", keys="Ctrl+L", needs=Need.FRAME, why_off=_why_none_selected
    )
    def toggle_locks(self) -> None:
        """Protect the selected blocks from edits, or unlock them.

        They are unlocked only if all are locked.
        """
        document = self.workspace.current
        lock = not all(document.info(label).locked for label in document.selected)
        changed = [label for label in document.selected if document.info(label).locked != lock]
        if changed:
            text = self._text("Lock" if lock else "Unlock")
            self.workspace.current.edit_infos({label: {"locked": lock} for label in changed}, text)

    def _why_none_to_check(self) -> str:
        document = self.workspace.current
        to_check = document.state.to_check & set(document.selected) & document.counts().keys()
        return "" if to_check else "The selected blocks need no check."

    @command(
        "mark_checked",
        "Ma&rk as checked",
        icon="ph.check",
        keys="Ctrl+Shift+F8",
        needs=Need.SELECTION,
        why_off=_why_none_to_check,
    )
    def mark_checked(self) -> None:
        """Mark the selected blocks, which were propagated from another frame, as checked."""
        self.workspace.current.mark_checked(self.workspace.current.selected)

    @command("hide_blocks", "Show or h&ide", icon="ph.eye", keys="Ctrl+H", needs=Need.FRAME, why_off=_why_none_selected)
    def toggle_visibility(self) -> None:
        """Show or hide the selected blocks over the image.

        They are hidden only if all are shown.
        """
        document = self.workspace.current
        show = not all(document.info(label).visible for label in document.selected)
        for label in list(document.selected):
            if document.info(label).visible != show:
                self.workspace.current.set_visible(label, show)

    @command("select_all", "Select &all blocks", icon="ph.selection-all", keys="Ctrl+A", needs=Need.FRAME)
    def select_all(self) -> None:
        """Select all blocks."""
        self.workspace.select(list(self.workspace.current.counts()))

    @command("new_block", "&New block", icon="ph.selection-plus", keys="Ctrl+N", needs=Need.FRAME)
    def new(self) -> None:
        """Start a new block with the brush."""
        label = self.workspace.current.start_block()
        self._editor.set_tool("paint")
        self._editor.show_message(f"Paint the pixels of {self.workspace.current.info(label).name}.")

    @command("grow_blocks", "&Grow", icon="ph.arrows-out-simple", keys="Ctrl++", needs=Need.UNLOCKED)
    def grow(self) -> None:
        """Grow the selected blocks."""
        self._change("Grow", grow)

    @command("shrink_blocks", "Shrin&k", icon="ph.arrows-in-simple", keys="Ctrl+-", needs=Need.UNLOCKED)
    def shrink(self) -> None:
        """Shrink the selected blocks."""
        self._change("Shrink", shrink)

    @command("smooth_blocks", "&Smooth", icon="ph.waves", keys="Ctrl+Alt+S", needs=Need.UNLOCKED)
    def smooth(self) -> None:
        """Smooth the outlines of the selected blocks."""
        self._change("Smooth", smooth)

    @command("clean_up", "&Clean up", icon="ph.sparkle", keys="Ctrl+K", needs=Need.BLOCKS)
    def clean_up(self) -> None:
        """Assign islands, slivers and holes of a few pixels to the blocks around them."""
        document = self.workspace.current
        smallest = sliver_size(document.labels.size)
        self._editor.cancel()
        found = count_slivers(document.labels, smallest, locked=document.locked)
        if document.edit(clean_up(document.labels, smallest, document.locked), "Clean up"):
            self._editor.show_message(f"{counted(found, 'sliver')} of less than {smallest} px cleaned up.")
        else:
            self._editor.show_message(f"There are no islands, slivers or holes of less than {smallest} px.")

    def _change(self, verb: str, change: Callable[..., LabelPatch | None]) -> None:
        """Grow, shrink or smooth all selected blocks, as one undo step."""
        document, amount = self.workspace.current, self._editor.options.amount

        def act() -> None:
            check_unlocked(document, document.selected)
            for label in document.selected:
                document.stroke(change(document.labels, label, amount, document.locked))
            if not self._editor.commit(document.drop_stroke(), f"{self._text(verb)} by {amount} px", document.chosen):
                raise InputError(f"{verb}: nothing to change by {amount} px here.")

        self._attempt(act)

    def _attempt(self, act: Callable[[], object]) -> None:
        """Edit the label map after cancelling a stroke in progress."""
        self._editor.cancel()
        self._editor.attempt(act)

    def _text(self, verb: str) -> str:
        document = self.workspace.current
        chosen = document.selected
        return f"{verb} {document.info(chosen[0]).name}" if len(chosen) == 1 else f"{verb} {len(chosen)} blocks"

    # at a position in the image

    def offers(self, x: float, y: float) -> list[tuple[str, Callable[[], object]]]:
        """Select the block at a position in the image, and return the texts and actions of what can be done there."""
        self._editor.cancel()
        document = self.workspace.current
        before, label = list(document.selected), document.label_at(x, y)
        if label not in before:
            self.workspace.select([label] if label else [])
        if label == 0:
            return []
        name = document.info(label).name
        offers: dict[str, Callable[[], object]] = {}
        if before and label != before[0]:
            taker = document.info(before[0]).name
            offers[f"Give this piece to {taker}"] = lambda: self._give(x, y, before)
            offers[f"Merge {name} into {taker}"] = lambda: self._merge_into(before[0], label)
        offers[f"Split {name} along the suggested line"] = lambda: cut_suggested(self._editor, label)
        return [(text, partial(self._attempt, act)) for text, act in offers.items()]

    def _give(self, x: float, y: float, chosen: list[int]) -> None:
        document = self.workspace.current
        self.workspace.select(chosen)
        give_piece(self._editor, piece_at(document.labels, x, y), document.label_at(x, y))

    def _merge_into(self, taker: int, other: int) -> None:
        document = self.workspace.current
        check_unlocked(document, [taker, other])
        text = f"Merge into {document.info(taker).name}"
        self._editor.commit(merge(document.labels, [taker, other], document.locked), text, taker)
        self.workspace.select([taker])
