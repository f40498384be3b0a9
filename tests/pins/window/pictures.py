"""Pictures of six states of the window, at two sizes, light and dark: `python -m tests.pins.window.pictures FOLDER`."""

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QImage

from .frames import room
from .hand import Hand, isolated

SIZES = (1440, 900), (1100, 700)
THEMES = "Light", "Dark"

_NOTICEABLE = 10
"""Difference of a pixel's grey [0-255] that is more than another smoothing of an edge."""
_CELL = 16
"""Side of the squares in which noticeable pixels are counted [px]."""
_SHARE = 0.08
"""Largest share of noticeable pixels in a square."""
_MEAN = 0.5
"""Largest mean absolute difference of a whole picture [0-255]."""


def make(folder: Path) -> None:
    """Write the pictures as PNG into a folder: state-WIDTHxHEIGHT-theme.png."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="ilf-pins-") as place, isolated(Path(place)):
        user = Hand(Path(place))
        try:
            for state, arrange in _STATES.items():
                arrange(user)
                _write_all(folder, state, user)
        finally:
            user.close()


def _write_all(folder: Path, state: str, user: Hand) -> None:
    for width, height in SIZES:
        user.window.resize(width, height)
        for theme in THEMES:
            user.choose("View", "Theme", theme)
            grab(user).save(str(folder / f"{state}-{width}x{height}-{theme.lower()}.png"))


def grab(user: Hand) -> QImage:
    """A picture of the window once nothing moves: without messages that disappear and a text cursor."""
    user.dismiss_messages()
    focus = user.window.focusWidget()
    if focus is not None:
        focus.clearFocus()
    user.settle()
    return user.window.grab().toImage()


def _opened(user: Hand) -> None:
    user.drop(room(user.folder))


def _editing(user: Hand) -> None:
    user.select((40, 30))
    user.tool("paint")
    user.drag([(60, 40), (80, 60)])


def _run(user: Hand) -> None:
    user.set_filter("paper", 20)
    user.do("run_all")


def _compared(user: Hand) -> None:
    user.fill("Max. iterations", 40)
    user.do("run_all")
    user.click_row("Run history", 1, "Run", user.panel("Runs"))
    user.do("compare_runs")
    user.panel("Parameters")  # in front of the runs, whose seconds differ


def _checked(user: Hand) -> None:
    user.do("layout_standard")
    user.panel("Accuracy")


_STATES: dict[str, Callable[[Hand], None]] = {
    "empty": lambda user: user.settle(),
    "opened": _opened,
    "editing": _editing,
    "run": _run,
    "compared": _compared,
    "accuracy": _checked,
}


def differences(one: Path, other: Path) -> list[str]:
    """A sentence for each picture of two folders that differs, or that only one of them has."""
    sentences = []
    names = [{path.name for path in folder.glob("*.png")} for folder in (one, other)]
    for name in sorted(names[0] | names[1]):
        if name not in names[0] & names[1]:
            sentences.append(f"{name}: only in the {'first' if name in names[0] else 'second'} folder.")
        elif difference := _difference(_grey(one / name), _grey(other / name)):
            sentences.append(f"{name}: {difference}")
    return sentences


def _grey(path: Path) -> NDArray[np.float32]:
    picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert picture is not None, f"{path} is no picture"
    return picture.astype(np.float32)


def _difference(before: NDArray[np.float32], after: NDArray[np.float32]) -> str:
    """What differs, "" for nothing that could be seen."""
    if before.shape != after.shape:
        return f"{before.shape[1]} x {before.shape[0]} pixels, now {after.shape[1]} x {after.shape[0]}."
    apart = np.abs(before - after)
    shares = cv2.blur((apart > _NOTICEABLE).astype(np.float32), (_CELL, _CELL))
    if shares.max() <= _SHARE and apart.mean() <= _MEAN:
        return ""
    row, column = np.unravel_index(int(shares.argmax()), shares.shape)
    share = np.mean(apart > _NOTICEABLE)
    return f"{share:.2%} of the pixels differ, most at ({column}, {row}); mean difference {apart.mean():.2f} of 255."


if __name__ == "__main__":
    make(Path(sys.argv[1]))
