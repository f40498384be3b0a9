"""What every bundled or imported network is: an ONNX file, run by OpenCV's own reader, from any thread."""

from __future__ import annotations

import hashlib
import json
import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import distributions
from pathlib import Path
from threading import Lock
from typing import ClassVar, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError, InstallationError
from ..cancellation import check_stopped, out_of_signals_way, taking
from ..files import read_file
from ..installation import asset_path
from ..sandbox import in_child
from ..temporary_files import MADE_BY, is_dead, made_by, unfinished
from .cancellable import ASKED, first_input, with_questions
from .models import models_folder
from .protobuf import has_external_data

# Which networks have been tried, by content: the bundled ones, and those of which that is remembered; and which were
# looking at an image when the program came to a sudden end.

_TRIED = ".tried"
"""Folder beside the user's own networks: an empty file for each that has been tried."""

_LOOK = ".look"
"""What files are called there as long as a network looks."""

_LONGEST_LOOK_S = 3600.0

Shapes = dict[str, tuple[int, ...]]
"""Of a network's inputs, by their names."""

_proven: set[str] = set()


def is_bundled(sha256: str) -> bool:
    """Whether a network of this content comes with the program."""
    return sha256 in _bundled()


def is_proven(sha256: str, kind: str) -> bool:
    """Whether a network is bundled, or has been tried by this version of the reader.

    Parameters
    ----------
    sha256 : str
        Of its content.
    kind : str
        Which class of network tried it.
    """
    mark = _mark(sha256, kind)
    return is_bundled(sha256) or mark in _proven or (models_folder() / _TRIED / mark).exists()


def remember(sha256: str, kind: str) -> None:
    """Do not try this network again, in this process; nor in later ones, if that can be written down."""
    mark = _mark(sha256, kind)
    _proven.add(mark)
    folder = models_folder() / _TRIED
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / mark).touch()
    except OSError:  # then the next process tries it anew
        return


@contextmanager
def looking(sha256: str, kind: str, shapes: Shapes) -> Iterator[None]:
    """As long as the block lasts, a file says what shapes a network's inputs have. A program that is crashed by it
    leaves that file behind."""
    mark = models_folder() / _TRIED / f"{_mark(sha256, kind)}-{made_by()}{_LOOK}"
    with unfinished(mark):
        with suppress(OSError):  # then a crash is not remembered
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.write_text(json.dumps(shapes), encoding="ascii")
        try:
            yield
        finally:
            with suppress(OSError):
                mark.unlink(missing_ok=True)


def last_looks(sha256: str, kind: str) -> list[tuple[Path, Shapes]]:
    """What a network was looking at when programs came to a sudden end: the files that say so, and shapes of inputs."""
    named = re.compile(rf"{re.escape(_mark(sha256, kind))}-{MADE_BY}{re.escape(_LOOK)}")
    found = []
    for path in sorted((models_folder() / _TRIED).glob(f"*{_LOOK}")):
        match = named.fullmatch(path.name)
        with suppress(OSError, ValueError):  # gone meanwhile, or cut short: nobody had begun to look
            if match is not None and (is_dead(match) or time.time() - path.stat().st_mtime > _LONGEST_LOOK_S):
                found.append((path, json.loads(path.read_text(encoding="ascii"))))
    return found


def _mark(sha256: str, kind: str) -> str:
    return f"{sha256}-{kind}-{cv2.__version__}"


@cache
def _bundled() -> frozenset[str]:
    sums = asset_path("models/SHA256SUMS").read_text(encoding="ascii")
    return frozenset(line.split()[0] for line in sums.splitlines())


_LARGE = 1_000_000
"""Pixels of an input from which on a net is read anew after use: it keeps what it works in, some 400 bytes for each."""

LEAST_SIDE = 64
"""Of the input of a network that halves it five times [px]: where a row or column of one pixel is left, OpenCV 5.0
reads memory that nobody has written, and what comes out differs from one process to the next."""

_networks: dict[tuple[type, Path], tuple[tuple[int, int], OnnxNetwork]] = {}
_networks_lock = Lock()


class OnnxNetwork:
    """A network, ready to run. `load` makes one; it may be used from any thread."""

    KIND: ClassVar[str] = "edge network"
    """What it is called in messages."""

    def __init__(self, content: NDArray[np.uint8], path: Path) -> None:
        try:
            self._first_input, self._with_questions = first_input(content), with_questions(content)
            self._net = self._fresh_net()
        except (ValueError, cv2.error) as error:
            raise _unreadable(path) from error
        self._outputs = tuple(self._net.getUnconnectedOutLayersNames())
        # A net keeps the input and all in between to itself, so that only one thread may run it at a time.
        self._lock = Lock()
        self.path = path
        self.sha256 = hashlib.sha256(content.data).hexdigest()
        """Of the very bytes that the network was read from, in hexadecimal digits."""
        self._harmless: set[tuple[tuple[int, ...], ...]] | None = None
        """Shapes of inputs that this network has looked at; None if there is no need to know."""
        self._try()
        if not is_bundled(self.sha256):
            self._harmless = set()

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """The network of a file, read once and kept until the file changes.

        Parameters
        ----------
        path : str or Path
            An ONNX file, as the class describes.

        Raises
        ------
        InputError
            If there is no such file.
        FormatError
            If it is no ONNX network, or not one of this kind.
        InstallationError
            As `read` does.
        """
        path = Path(path).resolve()
        if not os.path.isfile(path):
            raise InputError(f"There is no {cls.KIND} at {path}. Choose an ONNX file, or the Canny detector.")
        status = path.stat()
        version = (status.st_mtime_ns, status.st_size)
        with _networks_lock:
            known = _networks.get((cls, path))
            if known is None or known[0] != version:
                known = _networks[cls, path] = (version, cls.read(read_file(path).data, path))
            assert isinstance(known[1], cls)
            return known[1]

    @classmethod
    def read(cls, content: NDArray[np.uint8], path: Path) -> Self:
        """The network in a file's content, tried with small images but not kept.

        What is not known to be harmless is tried in a process of its own first: the reader of networks can be
        crashed. If the program came to a sudden end while this network looked at an image, so is that size.

        Parameters
        ----------
        content : ndarray of uint8
        path : Path
            Where it comes from, for messages.

        Raises
        ------
        FormatError
            If it is no ONNX network, or not one of this kind, takes weights from other files, crashes the reader, or
            has crashed the program and would again.
        InstallationError
            If the reader is not that of OpenCV 5: then no file is to blame, and nothing stands in.
        """
        _check_opencv()
        cls._check_content(content, path)
        sha256, kind = hashlib.sha256(content.data).hexdigest(), cls.__name__
        if not is_proven(sha256, kind):
            in_child(cls._prove, content, path, file=path.name)
            remember(sha256, kind)
        for mark, shapes in last_looks(sha256, kind):
            try:
                in_child(cls._look_again, content, path, shapes, file=path.name)
            except FormatError as error:
                height, width = next(iter(shapes.values()))[-2:]
                raise FormatError(
                    f"{path.name} had the program end suddenly when it looked at an image of about {width} x {height} "
                    f"pixels, and fails again. {error} Or choose another network."
                ) from error
            mark.unlink(missing_ok=True)
        return cls(content, path)

    @staticmethod
    def _check_content(content: NDArray[np.uint8], path: Path) -> None:
        """Refuse what would have the reader open other files."""
        try:
            is_outside = has_external_data(content)
        except ValueError as error:
            raise _unreadable(path) from error
        if is_outside:
            raise FormatError(
                f"{path.name} takes weights from other files, which may be any of this computer. Export it again as "
                "one file that holds its weights."
            )

    @classmethod
    def _prove(cls, content: NDArray[np.uint8], path: Path) -> None:
        """Open it once, where it may crash the process."""
        cls(content, path)

    @classmethod
    def _look_again(cls, content: NDArray[np.uint8], path: Path, shapes: Shapes) -> None:
        """Look at empty images of these shapes, where that may crash the process."""
        cls(content, path)._results({name: np.zeros(shape, np.float32) for name, shape in shapes.items()})

    def _forward(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """All outputs; raises cv2.error where the network does not take these inputs. "" is the first input."""
        with taking(self._lock):
            check_stopped()
            whole = False
            try:
                found = out_of_signals_way(lambda: self._watched(inputs))
                whole = True
                return found
            finally:
                if not whole or any(values[0, 0].size >= _LARGE for values in inputs.values()):
                    # only with the net goes what it has worked in
                    self._net = self._fresh_net()

    def _watched(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """Look, with a note of that if it may crash the program, as images of a new size may."""
        shapes = {name: values.shape for name, values in inputs.items()}
        key = tuple(shapes.values())
        if self._harmless is None or key in self._harmless:
            return self._finite_results(inputs)
        with looking(self.sha256, type(self).__name__, shapes):
            found = self._finite_results(inputs)
        self._harmless.add(key)
        return found

    def _finite_results(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        found = self._results(inputs)
        if all(np.isfinite(one).all() for one in found):
            return found
        # seen once in hundreds of looks, of sizes that had not been looked at; never twice
        self._net = self._fresh_net()
        return self._results(inputs)

    def _results(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        self._net.setInput(np.zeros(1, np.float32), ASKED)
        for name, values in inputs.items():
            self._net.setInput(values, name or self._first_input)
        try:
            found = self._net.forward(self._outputs)
        except cv2.error:
            check_stopped()
            raise
        # the net writes its next results to the same memory
        return [np.array(one, np.float32) for one in found]

    def _fresh_net(self) -> cv2.dnn.Net:
        return cv2.dnn.readNetFromONNX(self._with_questions)

    def _try(self) -> None:
        """Raise FormatError for a network that is none of this kind, before it is used."""
        raise NotImplementedError


def _check_opencv() -> None:
    """Refuse another OpenCV than the one that the program is installed with: packages of OpenCV share one module."""
    if cv2.__version__.startswith("5."):
        return
    names = {str(found.name) for found in distributions()}
    others = sorted(name for name in names if name.startswith("opencv-") and name != "opencv-python-headless")
    uninstall = f"pip uninstall {' '.join(others)} && " if others else ""
    raise InstallationError(
        f"OpenCV {cv2.__version__} has replaced OpenCV 5, which the networks for edges and correction need. Restore: "
        f'{uninstall}pip install --force-reinstall "opencv-python-headless>=5,<6". Or complete without networks: '
        "--blocks-detector canny --edges canny --no-correction."
    )


def _unreadable(path: Path) -> FormatError:
    return FormatError(
        f"{path.name} cannot be read as an ONNX network. Choose an intact ONNX file that holds its weights, or the "
        "Canny detector."
    )


def reflected(
    image: NDArray[np.generic], multiple: int, margin: int = 0, least: int = 0
) -> tuple[NDArray, tuple[slice, slice]]:
    """Reflect an image at its borders to sides that are multiples of a number.

    Parameters
    ----------
    image : ndarray, shape (H, W) or (H, W, C)
    multiple : int
    margin : int
        So many pixels at least are added on every side [px].
    least : int
        The sides are at least so long [px].

    Returns
    -------
    padded : ndarray
    window : (slice, slice)
        Rows and columns of the image within the padded one.
    """
    height, width = image.shape[:2]
    sides = (max(length + 2 * margin, least) for length in (height, width))
    after = (side + -side % multiple - margin - length for side, length in zip(sides, (height, width), strict=True))
    rest = ((0, 0),) * (image.ndim - 2)
    padded = np.pad(image, (*((margin, size) for size in after), *rest), mode="reflect")
    return padded, (slice(margin, margin + height), slice(margin, margin + width))
