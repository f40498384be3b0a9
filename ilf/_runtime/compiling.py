"""Inner loops as machine code where numba is installed, in numpy elsewhere: the same numbers but for rounding."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from importlib.util import find_spec
from threading import Lock
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

P = ParamSpec("P")
T = TypeVar("T")

_FLAGS = {"reassoc", "contract"}
"""What rounding may be done otherwise than written: sums in several parts, products and sums in one."""

_loops_of: dict[Callable[..., Any], Callable[..., Any]] = {}
"""The loops of functions of this kind that numba has not been told of."""

_making = Lock()


def compiled(loops: Callable[..., Any] | None = None) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Let numba run a function in place of a plain one: decorates the plain one.

    The machine code is made when it is first called for, takes seconds, and is kept on disk. It runs without the
    interpreter's lock, one thread a call, so that what comes out does not depend on the number of threads.

    Parameters
    ----------
    loops : callable, optional
        The same function, with the same parameters, in terms that numba compiles. It may call other functions of this
        kind. The plain function itself if left out: one that does nothing but that.

    Examples
    --------
    >>> import numpy as np
    >>> def _total(values):
    ...     total = 0.0
    ...     for value in values:
    ...         total += value
    ...     return total
    >>> @compiled(_total)
    ... def total(values):
    ...     return float(values.sum())
    >>> total(np.array([1.0, 2.0]))
    3.0
    """

    def decorate(plain: Callable[P, T]) -> Callable[P, T]:
        written = loops or plain

        @cache
        def made() -> Callable[P, T]:
            return _machine_code(written)

        @wraps(plain)
        def run(*args: P.args, **kwargs: P.kwargs) -> T:
            return (made() if is_compiled() else plain)(*args, **kwargs)

        _loops_of[run] = written
        return run

    return decorate


@cache
def is_compiled() -> bool:
    """Whether inner loops are machine code here; not where NUMBA_DISABLE_JIT asks for none."""
    if find_spec("numba") is None:
        return False
    import numba

    return not vars(numba.config)["DISABLE_JIT"]


def _machine_code(loops: Callable[..., Any]) -> Callable[..., Any]:
    import numba

    _tell_numba()
    make = numba.njit(nogil=True, error_model="numpy", fastmath=_FLAGS)
    made = make(loops)
    try:
        made.enable_caching()
    except RuntimeError:  # nowhere to keep it: it is made anew in every process
        return make(loops)
    return made


def _tell_numba() -> None:
    """What stands for functions of this kind where machine code calls them: their loops."""
    from numba.extending import overload

    options: Any = {"error_model": "numpy", "fastmath": _FLAGS}
    with _making:
        while _loops_of:
            run, loops = _loops_of.popitem()
            overload(run, jit_options=options, strict=False)(lambda *_, loops=loops: loops)


# Sums of products that come out the same for any number of threads.


def inner(a: NDArray[np.inexact], b: NDArray[np.inexact]) -> float:
    """Sum of products of two real arrays, or of real with real and imaginary with imaginary parts of complex ones.

    Row by row, and the rows' sums in float64, so that float32 keeps its digits. Rows are too short for BLAS to use
    threads on, whose number would show in the sums.
    """
    if np.iscomplexobj(a):
        a, b = a.view(a.real.dtype), b.view(b.real.dtype)
    return float(np.vecdot(a, b).sum(dtype=np.float64))
