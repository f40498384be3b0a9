"""Errors that a user can act on. Every message states what is wrong and what to do about it."""

from __future__ import annotations

import errno
import os
import re
import sys
import unicodedata
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import UnionType

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
    errno.ENOTDIR: "there is no such file or folder",
    errno.EROFS: "the drive is read-only",
}


_START = r"(?<![A-Za-z0-9])[A-Za-z][A-Za-z0-9+.-]{1,30}:/+"
"""How an address begins; a path has one slash of it left."""

CREDENTIALS = re.compile(rf"({_START}|(?<!\S)//)(?:[^\s@'\"]*:[^\s'\"]*|[^\s/'\"]*)@")
"""A user and a password, which may contain slashes, after what precedes them."""

_QUERY = re.compile(rf"({_START}[^\s?#'\"]*)[?#][^\s'\")]*")
_ENCODED = re.compile(r"(?i)((?<![a-z0-9])[a-z][a-z0-9+.-]{1,30}%3a(?:%2f){2})[^\s'\"]*%40")
_SIGNATURE = re.compile(
    r"(?i)(?<![\w-])((?:x-\w+-)?(?:\w*signature|(?:\w+-)?\w*token|sig|\w*secret|password|credential|(?:api|access|account)_?key\w*))=[^\s&'\")]+"
)
_SECRET_NAME = re.compile(r"KEY|SECRET|TOKEN|PASSW|CREDENTIAL|SIGNATURE|CONNECTION_STRING|_PROXY$", re.IGNORECASE)
_SECRET_LENGTH = 6
"""Minimum length of a secret in the environment; shorter values would be found in ordinary words."""


def without_credentials(text: str) -> str:
    """A text without users, passwords, queries and fragments of the addresses in it, and without signatures and secrets
    of the environment.

    Examples
    --------
    >>> without_credentials("403: HTTPS://me:se@cret@host/a.png?until=12:00&signature=abc")
    '403: HTTPS://host/a.png'
    >>> without_credentials("/home/https:/me:secret@host/a.png, /a?sig=abc")
    '/home/https:/host/a.png, /a?sig=***'
    """
    text = _QUERY.sub(r"\1", _ENCODED.sub(r"\1", CREDENTIALS.sub(r"\1", text)))
    text = _SIGNATURE.sub(r"\1=***", text)
    secrets = (value for name, value in os.environ.items() if _SECRET_NAME.search(name))
    for secret in sorted(filter(lambda value: len(value) >= _SECRET_LENGTH, secrets), key=len, reverse=True):
        text = text.replace(secret, "***")
    return text


class IlfError(Exception):
    """Base of all errors that this library raises on purpose. Its text is one line, even if it quotes a file, without
    credentials of addresses."""

    def __str__(self) -> str:
        return one_line(without_credentials(super().__str__()))


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
    return str(error).partition("; use sys.set_int_max")[0]  # Python's advice on numbers of thousands of digits


_LONGEST_CAUSE = 200


@contextmanager
def told_as(
    kind: type[IlfError], sentence: str, caught: type[Exception] | tuple[type[Exception], ...]
) -> Iterator[None]:
    """Within the block, errors of some types become one of this library's kinds.

    Parameters
    ----------
    kind : type
        What is raised.
    sentence : str
        Its message, in which {error} stands for what the caught error says.
    caught : type or tuple of type

    Examples
    --------
    >>> with told_as(InputError, "rate.txt is no number ({error}). Correct it.", ValueError):
    ...     rate = float("fast")
    Traceback (most recent call last):
    ilf.errors.InputError: rate.txt is no number (could not convert string to float: 'fast'). Correct it.
    """
    try:
        yield
    except caught as error:
        text = str(error) if isinstance(error, IlfError) else f"{cause(error):.{_LONGEST_CAUSE}}"
        raise kind(sentence.replace("{error}", text)) from error


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Suggest the most similar known word, as a question after a space; "" if there is none.

    Examples
    --------
    >>> did_you_mean("granularty", ["granularity", "dilation"]), did_you_mean("fly", ["complete", "blocks"])
    (' Did you mean granularity?', '')
    """
    import difflib  # not before: most programs need no suggestion

    near = difflib.get_close_matches(word, list(known), 1)
    return f" Did you mean {near[0]}?" if near else ""


def to_text(error: Exception) -> str:
    """Describe an error that is printed without a sentence around it: for a system error, its path and its cause."""
    if isinstance(error, OSError) and error.errno is not None and error.filename is not None:
        return without_credentials(f"{error.filename}: {cause(error)}")
    return without_credentials(cause(error))


def _shown(character: str) -> str:
    """Return a character, or its Python escape if it is a control character or half of a surrogate pair."""
    is_shown = unicodedata.category(character) not in {"Cc", "Cs"}
    return character if is_shown else character.encode("unicode_escape").decode("ascii")


class InputError(IlfError):
    """The data is readable but cannot be used: sizes that differ, no depth, an absurd scale."""


def check_kind(value: object, kind: type | UnionType, what: str, remedy: str) -> None:
    """Raise InputError for an argument of another type than `kind`, with what is expected and what to do instead."""
    if not isinstance(value, kind):
        raise InputError(f"{what}, not {type(value).__name__}: {remedy}")


PathKind = str | os.PathLike
"""The types of a path."""


def check_path(path: object) -> None:
    """Raise InputError for the path of a writer that is none, such as what it is to write."""
    check_kind(path, PathKind, "A file is written to a path", "give the path first, then what to write.")


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
