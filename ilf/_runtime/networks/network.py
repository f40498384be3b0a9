"""Base of all bundled and imported networks: ONNX files run by ONNX Runtime, from any thread."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from threading import Lock, Timer
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError
from ..files import read_file, read_json
from ..installation import asset_path
from ..sandbox import run_in_sandbox
from ..temporary_files import CREATOR_PATTERN, creator_has_ended, removed_on_exit, unique_tag
from .models import models_folder
from .protobuf import has_external_data
from .session import Session, device, runtime_version

# Record of tested networks, by content: the bundled ones, and those recorded as tested; and of networks that were
# running when the program closed unexpectedly.

_TESTED = ".tried"
"""Folder beside the user's own networks, with an empty file for each tested one."""

_RUNNING = ".look"
"""Suffix of the files there that exist while a network runs."""

_MAX_RUN_S = 3600.0

TRIAL_S = 30.0
"""Time limit of a trial, and time from which the user is told that a network still runs [s]."""

Shapes = dict[str, tuple[int, ...]]
"""Shapes of a network's inputs, by name."""

_tested: set[str] = set()


def is_bundled(sha256: str) -> bool:
    """Whether a network with this content is bundled."""
    return sha256 in _bundled()


def is_tested(sha256: str, kind: str) -> bool:
    """Whether a network is bundled, or has been tested with this version of ONNX Runtime.

    Parameters
    ----------
    sha256 : str
        Hash of its content.
    kind : str
        Name of the network class that tested it.
    """
    mark = _mark(sha256, kind)
    return is_bundled(sha256) or mark in _tested or (models_folder() / _TESTED / mark).exists()


def mark_tested(sha256: str, kind: str) -> None:
    """Record a network as tested, in this process and, if the record can be written, in later ones."""
    mark = _mark(sha256, kind)
    _tested.add(mark)
    folder = models_folder() / _TESTED
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / mark).touch()
    except OSError:  # then the next process tests it again
        return


@contextmanager
def recorded_run(sha256: str, kind: str, shapes: Shapes) -> Iterator[None]:
    """Keep a file with the shapes of a network's inputs during the block. If the network crashes the program, the file
    is left behind."""
    mark = models_folder() / _TESTED / f"{_mark(sha256, kind)}-{unique_tag()}{_RUNNING}"
    with removed_on_exit(mark):
        with suppress(OSError):  # then a crash is not recorded
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.write_text(json.dumps(shapes), encoding="ascii")
        try:
            yield
        finally:
            with suppress(OSError):
                mark.unlink(missing_ok=True)


def crashed_runs(sha256: str, kind: str) -> list[tuple[Path, Shapes]]:
    """Return the runs of a network during which programs closed unexpectedly: their files, and shapes of inputs."""
    named = re.compile(rf"{re.escape(_mark(sha256, kind))}-{CREATOR_PATTERN}{re.escape(_RUNNING)}")
    found = []
    for path in sorted((models_folder() / _TESTED).glob(f"*{_RUNNING}")):
        match = named.fullmatch(path.name)
        with suppress(OSError, ValueError, InputError):  # removed meanwhile, or truncated: the network had not started
            if match is not None and (creator_has_ended(match) or time.time() - path.stat().st_mtime > _MAX_RUN_S):
                found.append((path, read_json(path)))
    return found


def _mark(sha256: str, kind: str) -> str:
    return f"{sha256}-{kind}-{runtime_version()}-{device()}"


@cache
def _bundled() -> frozenset[str]:
    sums = asset_path("models/SHA256SUMS").read_text(encoding="ascii")
    return frozenset(line.split()[0] for line in sums.splitlines())


_networks: dict[tuple[type, Path, str], tuple[tuple[int, int], OnnxNetwork]] = {}
"""Kind, file and device -> version of the file, and the network."""

_networks_lock = Lock()


class OnnxNetwork:
    """A network, ready to run. Create one by `load`; it may be used from any thread."""

    KIND: ClassVar[str] = "edge network"
    """Name of this kind of network in messages."""

    INSTEAD: ClassVar[str] = ", or the Canny detector"
    """What can be chosen instead of a network of this kind, in messages."""

    def __init__(self, content: NDArray[np.uint8], path: Path) -> None:
        try:
            self._session = Session(content)
        except ValueError as error:
            raise self._unreadable(path) from error
        self.path = path
        self.sha256 = hashlib.sha256(content.data).hexdigest()
        """Hash of the bytes that the network was read from, in hexadecimal digits."""
        self._tested_shapes: set[tuple[tuple[int, ...], ...]] | None = None
        """Shapes of inputs that this network has processed; None if they need not be tracked."""
        self._try()
        if not is_bundled(self.sha256):
            self._tested_shapes = set()

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Load the network of a file, read once and cached until the file changes.

        Parameters
        ----------
        path : str or Path
            An ONNX file, as described by the class.

        Raises
        ------
        InputError
            If the file does not exist.
        FormatError
            If it is not an ONNX network, or not one of this kind.
        InstallationError
            As for `read`.
        """
        path = Path(path).resolve()
        if not os.path.isfile(path):
            raise InputError(f"There is no {cls.KIND} at {path}. Choose an ONNX file{cls.INSTEAD}.")
        status = path.stat()
        version = (status.st_mtime_ns, status.st_size)
        key = (cls, path, device())
        with _networks_lock:
            known = _networks.get(key)
            if known is None or known[0] != version:
                known = _networks[key] = (version, cls.read(read_file(path).data, path))
            assert isinstance(known[1], cls)
            return known[1]

    @classmethod
    def read(cls, content: NDArray[np.uint8], path: Path) -> Self:
        """Read the network in a file's content and test it with small images, without caching it.

        Networks not yet tested are first tested in a separate process, since they can crash the reader. If the program
        closed unexpectedly while this network ran on an image, that size is tested again, too.

        Parameters
        ----------
        content : ndarray of uint8
        path : Path
            The file it comes from, for messages.

        Raises
        ------
        FormatError
            If it is not an ONNX network, or not one of this kind, reads weights from other files, crashes the reader,
            or has crashed the program and would do so again.
        InstallationError
            If ONNX Runtime cannot be imported: then the file is not the cause, and no other detector is used instead.
        """
        cls._check_content(content, path)
        sha256, kind = hashlib.sha256(content.data).hexdigest(), cls.__name__
        if not is_tested(sha256, kind):
            cls._in_sandbox(cls._load_once, content, path)
            mark_tested(sha256, kind)
        for mark, shapes in crashed_runs(sha256, kind):
            try:
                cls._in_sandbox(cls._run_again, content, path, shapes)
            except FormatError as error:
                height, width = next(iter(shapes.values()))[-2:]
                raise FormatError(
                    f"{path.name} crashed the program on an image of about {width} x {height} pixels, and fails again. "
                    f"{error} Or choose another network."
                ) from error
            mark.unlink(missing_ok=True)
        return cls(content, path)

    @staticmethod
    def _in_sandbox(trial: Callable[..., None], content: NDArray[np.uint8], path: Path, *more: Any) -> None:
        """Run a trial in a process that it may crash, for `TRIAL_S` at most."""
        run_in_sandbox(trial, content, path, *more, file=path.name, seconds=TRIAL_S, doing="running it")

    @classmethod
    def _unreadable(cls, path: Path) -> FormatError:
        return FormatError(
            f"{path.name} cannot be read as an ONNX network. Choose an intact ONNX file with its weights{cls.INSTEAD}."
        )

    @classmethod
    def _check_content(cls, content: NDArray[np.uint8], path: Path) -> None:
        """Raise FormatError for a network that makes the reader open other files."""
        try:
            is_outside = has_external_data(content)
        except ValueError as error:
            raise cls._unreadable(path) from error
        if is_outside:
            raise FormatError(
                f"{path.name} reads weights from other files, which is not allowed: it could read any file of this "
                "computer. Export it again as one file with its weights."
            )

    @classmethod
    def _load_once(cls, content: NDArray[np.uint8], path: Path) -> None:
        """Load the network once, in a process that it may crash."""
        cls(content, path)

    @classmethod
    def _run_again(cls, content: NDArray[np.uint8], path: Path, shapes: Shapes) -> None:
        """Run the network on empty images of these shapes, in a process that it may crash."""
        cls(content, path)._results({name: np.zeros(shape, np.float32) for name, shape in shapes.items()})

    def _forward(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """Return all outputs; raise RefusedInputError if the network does not accept these inputs. "" is the first
        input."""
        shapes = {name: values.shape for name, values in inputs.items()}
        key = tuple(shapes.values())
        if self._tested_shapes is None or key in self._tested_shapes:
            return self._results(inputs)
        # a record of the run for inputs of a new size, which may crash the program
        with recorded_run(self.sha256, type(self).__name__, shapes):
            found = self._results(inputs)
        self._tested_shapes.add(key)
        return found

    def _results(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        told = Timer(TRIAL_S, self._tell_that_it_runs)
        told.daemon = True
        told.start()
        try:
            return self._session.run({name or self._session.first_input: values for name, values in inputs.items()})
        finally:
            told.cancel()

    def _tell_that_it_runs(self) -> None:
        logging.getLogger(__name__).warning(
            "%s has been running for %g s and may not end. Cancel the work (Ctrl+C) and choose another %s, or wait.",
            self.path.name,
            TRIAL_S,
            self.KIND,
        )

    def _try(self) -> None:
        """Raise FormatError for a network that is not of this kind, before it is used."""
        raise NotImplementedError


def reflected(image: NDArray[np.generic], multiple: int, margin: int = 0) -> tuple[NDArray, tuple[slice, slice]]:
    """Pad an image by reflection at its borders, to sides that are multiples of a number.

    Parameters
    ----------
    image : ndarray, shape (H, W) or (H, W, C)
    multiple : int
    margin : int
        Minimum padding on every side [px].

    Returns
    -------
    padded : ndarray
    window : (slice, slice)
        Rows and columns of the image within the padded one.
    """
    height, width = image.shape[:2]
    sides = (length + 2 * margin for length in (height, width))
    after = (side + -side % multiple - margin - length for side, length in zip(sides, (height, width), strict=True))
    rest = ((0, 0),) * (image.ndim - 2)
    padded = np.pad(image, (*((margin, size) for size in after), *rest), mode="reflect")
    return padded, (slice(margin, margin + height), slice(margin, margin + width))


def as_input(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Convert an RGB image (H, W, 3) to the input of a network, in [0, 1], shape (1, 3, H, W)."""
    return np.moveaxis(image.astype(np.float32) * np.float32(1 / 255), 2, 0)[None]
