"""The state of the views that is stored with the work: layout and contents."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from ...views.layouts import LAYOUTS
from ...views.linked_views import LinkedViews

LAYOUT, CONTENTS, SIDES = "layout", "contents", "sides"


def views_state(views: LinkedViews) -> dict[str, Any]:
    """Return layout and contents of the views as values for JSON."""
    return {LAYOUT: views.sheet.layout_name, CONTENTS: views.contents(), SIDES: list(views.data.chosen_sides)}


def restore_views(views: LinkedViews, state: Mapping[str, Any]) -> None:
    """Restore what `views_state` has returned; unknown values are ignored."""
    contents, sides = state.get(CONTENTS), state.get(SIDES)
    if state.get(LAYOUT) in LAYOUTS:
        views.sheet.set_layout(str(state[LAYOUT]))
    for cell, content in contents.items() if isinstance(contents, Mapping) else ():
        with contextlib.suppress(ValueError):  # there is no such content
            views.set_content(str(cell), str(content))
    if isinstance(sides, list) and len(sides) == 2:
        with contextlib.suppress(ValueError):
            views.sides.choose(*map(str, sides))
