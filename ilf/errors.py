"""Errors that a user can act on. Every message states what is wrong and what to do about it."""

from __future__ import annotations

import errno
import sys
import unicodedata
import warnings

_LONGEST = 1500
_CAUSES = {
    errno.EFBIG: "the file would be larger than its drive or a limit (ulimit -f) allows",
    errno.EINVAL: "the drive does not support it",
    errno.ELOOP: "symbolic links form a loop",
    errno.EMFILE: "this process has too many files open",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ENFILE: "the machine has too many files open",
    errno.ENOENT: "there is no such file or folder",
    errno.ENOMEM: "memory has run out",
    errno.ENOSPC: "the disk is full",
}


class IlfError(Exception):
    """Base of all errors that this library raises on purpose. Its text is one line, even if it quotes a file."""

    def __str__(self) -> str:
        return one_line(super().__str__())


def one_line(text: str) -> str:
    """Make any text one line of moderate length, with control characters escaped for terminals.

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
    """Describe an error in words, without the number and the path that the system adds.

    Examples
    --------
    >>> cause(OSError(errno.ELOOP, "Too many levels of symbolic links", "a/b"))
    'symbolic links form a loop'
    """
    if isinstance(error, OSError) and error.errno is not None:
        return _CAUSES.get(error.errno) or error.strerror or "the system gives no reason"
    return str(error)


def to_text(error: Exception) -> str:
    """Describe an error that is printed without a sentence around it: for a system error, its path and its cause."""
    if isinstance(error, OSError) and error.errno is not None and error.filename is not None:
        return f"{error.filename}: {cause(error)}"
    return cause(error)


def _shown(character: str) -> str:
    """Return a character, or its Python escape if it is a control character or half of a surrogate pair."""
    is_shown = unicodedata.category(character) not in {"Cc", "Cs"}
    return character if is_shown else character.encode("unicode_escape").decode("ascii")


class InputError(IlfError):
    """The data is readable but cannot be used: sizes that differ, no depth, an absurd scale."""


class FormatError(InputError):
    """A file does not match its suffix, is truncated, or has an unsupported format."""


class ParameterError(IlfError, ValueError):
    """An unknown parameter name, or a value out of range."""


class ExportError(IlfError):
    """A result could not be written; existing files are unchanged."""


class InstallationError(IlfError):
    """A package that the program needs has been replaced by another; the message states how to undo that."""


class Cancelled(IlfError):
    """The user cancelled the run."""


class DepthWarning(UserWarning):
    """A depth or colour file may have been read wrongly, some of its values were left out, or its camera may be that of
    another image; the message states how to read it."""


def warn_of_reading(text: str) -> None:
    """Issue a `DepthWarning` at the line that called this package."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(text, DepthWarning, stacklevel=level)
