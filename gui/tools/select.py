"""Choosing blocks by clicking on them."""

from __future__ import annotations

from gui.tools.base import Host
from gui.views.pointer import PointerEvent, PointerKind


class SelectTool:
    """A click chooses the block under it, with Ctrl adds or removes it; dragging pans."""

    hint = "Click: choose a block | Ctrl+click: add or remove | drag: pan | wheel: zoom"

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Choose on press, and leave the drag to the view."""
        if event.kind is PointerKind.PRESS:
            label = host.session.label_at(event.x, event.y)
            chosen = list(host.session.selected)
            if not event.ctrl:
                host.select([label] if label else [])
            elif label in chosen:
                host.select([other for other in chosen if other != label])
            elif label:
                host.select([*chosen, label])
        return False

    def cancel(self, host: Host) -> bool:
        """Nothing is ever under way."""
        return False
