"""Values as strict JSON has them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def strict_json(value: object) -> bytes:
    """JSON without whitespace and without NaN, which is null in it."""
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False).encode()
    except (TypeError, ValueError):
        return json.dumps(plain(value), separators=(",", ":"), allow_nan=False).encode()


def plain(value: object) -> Any:
    """A value of what JSON has, as near as can be: null for numbers that are not finite, text for what it lacks.

    Examples
    --------
    >>> plain({1: (2, float("nan")), "at": b"x"})
    {'1': [2, None], 'at': "b'x'"}
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, Sequence | set | frozenset) and not isinstance(value, bytes | bytearray):
        return [plain(part) for part in value]
    return plain(value.item()) if isinstance(value, np.generic) else str(value)
