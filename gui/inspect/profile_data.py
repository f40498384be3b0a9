"""What is plotted along the profile line: depth as it came in and as it came out, and all that it is compared with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gui.state.inspection import Line
from gui.state.past import Past
from gui.state.session import Session
from ilf.inspection import DepthProfile, depth_profile
from ilf.project.kept_run import KeptRun

Colour = tuple[int, int, int]

_RAW, _ERROR, _TRUTH = "raw_m", "expected_error_m", "truth_m"


@dataclass(frozen=True, eq=False)
class ProfileData:
    """Depth along a line, [m], NaN = missing; None for what there is not.

    Attributes
    ----------
    profile : DepthProfile
        Of the result, or of the raw depth if there is none, with all else as its other maps.
    raw : ndarray of float32, shape (N,)
    result, error, truth : ndarray of float32, shape (N,), or None
        Completed depth, its expected error, and the true depth.
    name : str
        Which completed depth it is.
    runs : list of (str, (r, g, b), ndarray of float32)
        Name, colour and depth of the runs that it is compared with.
    labels : ndarray of int32, shape (N,)
        The block of each sample.
    """

    profile: DepthProfile
    raw: NDArray[np.float32]
    result: NDArray[np.float32] | None
    error: NDArray[np.float32] | None
    truth: NDArray[np.float32] | None
    runs: list[tuple[str, Colour, NDArray[np.float32]]]
    labels: NDArray[np.int32]
    name: str = "result"

    @property
    def borders(self) -> NDArray[np.intp]:
        """Samples that are of another block than the one before."""
        return np.flatnonzero(np.diff(self.labels)) + 1


def profile_data(session: Session, line: Line, past: Past | None = None) -> ProfileData:
    """What a frame shows along a line, as things are now, or with the result of the past, which has no expected
    error."""
    frame, result = session.frame, session.present_depth() if past is None else past.depth
    error = session.expected_error() if past is None else None
    maps = {_RAW: frame.depth, _ERROR: error, _TRUTH: frame.truth}
    others = {name: values for name, values in maps.items() if values is not None}
    names = _names(session.compared)
    others |= {name: kept.completion.depth for name, kept in zip(names, session.compared, strict=True)}
    profile = depth_profile(frame.depth if result is None else result, *line, frame.intrinsics, others)
    found = profile.others
    return ProfileData(
        profile,
        found[_RAW],
        None if result is None else profile.depth,
        found.get(_ERROR),
        found.get(_TRUTH),
        [(kept.name, kept.colour, found[name]) for name, kept in zip(names, session.compared, strict=True)],
        session.labels[profile.rows, profile.columns],
        "result" if past is None else f"result {past.text}",
    )


def _names(runs: Sequence[KeptRun]) -> list[str]:
    """A name for each run, no two the same."""
    names = [kept.name for kept in runs]
    return [kept.name if names.count(kept.name) == 1 else f"{kept.name} #{kept.number}" for kept in runs]
