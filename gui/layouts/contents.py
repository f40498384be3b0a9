"""What the cells of the views show, taken and given back."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping

from gui.views.linked_views import LinkedViews


def contents(views: LinkedViews) -> dict[str, str]:
    """Name of each cell -> name of what it shows."""
    return dict(views.contents()) if hasattr(views, "contents") else {}


def set_contents(views: LinkedViews, wanted: Mapping[str, str]) -> None:
    """Let cells show this; cells and contents that there are no longer are passed over."""
    for cell, content in wanted.items():
        with contextlib.suppress(ValueError, AttributeError):
            views.set_content(cell, content)  # type: ignore[attr-defined]
