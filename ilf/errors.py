"""Errors that a user can act on. Every message says what is wrong and what to do about it."""


class IlfError(Exception):
    """Base of all errors that this library raises on purpose."""


class InputError(IlfError):
    """The data is readable but cannot be used: sizes that differ, no depth, an absurd scale."""


class FormatError(InputError):
    """A file is not what its name says, is truncated, or has a format that is not supported."""


class ParameterError(IlfError, ValueError):
    """An unknown parameter name, or a value out of range."""


class ExportError(IlfError):
    """A result could not be written; files that were there before are as they were."""


class Cancelled(IlfError):
    """The user stopped the run."""


class DepthWarning(UserWarning):
    """A depth file may have been read wrongly, or has values that were left out; the message says how to read it."""
