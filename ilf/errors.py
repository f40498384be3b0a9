"""Errors that a user can act on. Every message says what is wrong and what to do about it."""

from __future__ import annotations

import errno
import sys
import unicodedata
import warnings

_LONGEST = 1500
_CAUSES = {
    errno.EFBIG: "the file would be larger than its drive or a limit (ulimit -f) allows",
    errno.EINVAL: "the drive does not take it",
    errno.ELOOP: "symbolic links lead in a circle",
    errno.EMFILE: "this process has too many files open",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ENFILE: "the machine has too many files open",
    errno.ENOENT: "there is no such file or folder",
    errno.ENOMEM: "memory has run out",
    errno.ENOSPC: "the disk is full",
}


class IlfError(Exception):
    """Base of all errors that this library raises on purpose. Its text is one line, whatever a file has put into it."""

    def __str__(self) -> str:
        return one_line(super().__str__())


def one_line(text: str) -> str:
    """Text of anyone's as one line of moderate length that a terminal shows and does not obey.

    Examples
    --------
    >>> one_line("two\\nlines, \\x1b[31mred")
    'two lines, \\\\x1b[31mred'
    """
    line = " ".join(text.splitlines())
    if not line.isprintable():
        line = "".join(map(_shown, line))
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


def cause(error: Exception) -> str:
    """What went wrong, in words and without the number and the path that the system adds.

    Examples
    --------
    >>> cause(OSError(errno.ELOOP, "Too many levels of symbolic links", "a/b"))
    'symbolic links lead in a circle'
    """
    if isinstance(error, OSError) and error.errno is not None:
        return _CAUSES.get(error.errno) or error.strerror or "the system gives no reason"
    return str(error)


def in_words(error: Exception) -> str:
    """What to tell of an error that has no sentence of its own around it: for one of the system, the path and why."""
    if isinstance(error, OSError) and error.errno is not None and error.filename is not None:
        return f"{error.filename}: {cause(error)}"
    return cause(error)


def _shown(character: str) -> str:
    """A character, or how Python writes it if it is for controlling a terminal or the half of one."""
    is_shown = unicodedata.category(character) not in {"Cc", "Cs"}
    return character if is_shown else character.encode("unicode_escape").decode("ascii")


class InputError(IlfError):
    """The data is readable but cannot be used: sizes that differ, no depth, an absurd scale."""


class FormatError(InputError):
    """A file is not what its name says, is truncated, or has a format that is not supported."""


class ParameterError(IlfError, ValueError):
    """An unknown parameter name, or a value out of range."""


class ExportError(IlfError):
    """A result could not be written; files that were there before are as they were."""


class InstallationError(IlfError):
    """A package that the program needs has been replaced by another; the message says how to undo that."""


class Cancelled(IlfError):
    """The user stopped the run."""


class DepthWarning(UserWarning):
    """A file of depth or colour may have been read wrongly, or has values that were left out; the message says how to
    read it."""


def warn_of_reading(text: str) -> None:
    """Give a `DepthWarning` where this package was called."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(text, DepthWarning, stacklevel=level)
