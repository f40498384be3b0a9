"""A digest that identifies the state of a frame: over all that a project stores of it but how it is looked at."""

from ilf.project.frame_state import FrameState
from tests.pins.window.hand import frame_content
from tests.pins.window.table import digest

_LOOKED_AT = {"line", "rectangle", "measured", "compared", "selected"}


def digest_of(state: FrameState) -> str:
    """Return the digest of a frame's state."""
    return digest({part: value for part, value in frame_content(state).items() if part not in _LOOKED_AT})
