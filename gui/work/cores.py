"""How many cores long work may have."""

from __future__ import annotations

from ilf.threads import available_cores


def spare_cores() -> int:
    """Threads for work in the background, at least one: one core stays the window's."""
    return max(available_cores() - 1, 1)
