"""Inner loops compiled by numba if it is installed, else in numpy: the same results except for rounding."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from importlib.util import find_spec
from threading import Lock
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .installation import user_path

P = ParamSpec("P")
T = TypeVar("T")

_FLAGS = {"reassoc", "contract"}
"""Permitted changes of rounding: reassociated sums, and fused products and sums."""

_loops_of: dict[Callable[..., Any], Callable[..., Any]] = {}
"""Compiled functions whose loops are not yet registered with numba."""

_making = Lock()


def compiled(loops: Callable[..., Any] | None = None) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a plain function so that numba runs a compiled one in its place.

    The machine code is compiled on the first call, which takes seconds, and cached in the user's cache folder, or in
    that of NUMBA_CACHE_DIR. It runs without the
    interpreter's lock, one thread per call, so that results do not depend on the number of threads.

    Parameters
    ----------
    loops : callable, optional
        The same function, with the same parameters, in code that numba compiles. It may call other functions decorated
        like this. If omitted, the plain function itself is compiled.

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
        def compiled_loops() -> Callable[P, T]:
            return _machine_code(written)

        @wraps(plain)
        def run(*args: P.args, **kwargs: P.kwargs) -> T:
            return (compiled_loops() if is_compiled() else plain)(*args, **kwargs)

        _loops_of[run] = written
        return run

    return decorate


@cache
def is_compiled() -> bool:
    """Whether inner loops are compiled: numba is installed and NUMBA_DISABLE_JIT is not set."""
    if find_spec("numba") is None:
        return False
    import numba

    return not vars(numba.config)["DISABLE_JIT"]


def _machine_code(loops: Callable[..., Any]) -> Callable[..., Any]:
    import numba

    _register_with_numba()
    make = numba.njit(nogil=True, error_model="numpy", fastmath=_FLAGS)
    compiled_loops = make(loops)
    config = vars(numba.config)
    with _making:
        chosen = config["CACHE_DIR"]
        # beside the sources, numba's choice, files would stay when the package is uninstalled
        config["CACHE_DIR"] = chosen or str(user_path("cache", "numba"))
        try:
            compiled_loops.enable_caching()
        except RuntimeError:  # no cache folder: every process compiles it again
            return make(loops)
        finally:
            config["CACHE_DIR"] = chosen
    return compiled_loops


def _register_with_numba() -> None:
    """Register the loops of compiled functions, so that machine code calls these in their place."""
    from numba.extending import overload

    options: Any = {"error_model": "numpy", "fastmath": _FLAGS}
    with _making:
        while _loops_of:
            run, loops = _loops_of.popitem()
            overload(run, jit_options=options, strict=False)(lambda *_, loops=loops: loops)


# Sums of products that are the same for any number of threads.


def inner(a: NDArray[np.inexact], b: NDArray[np.inexact]) -> float:
    """Return the sum of products of two real arrays; of complex ones, real with real and imaginary with imaginary.

    Rows are summed one by one, and their sums added in float64, to keep the precision of float32. Rows are too short
    for BLAS to use several threads, whose number would change the sums.
    """
    if np.iscomplexobj(a):
        a, b = a.view(a.real.dtype), b.view(b.real.dtype)
    return float(np.vecdot(a, b).sum(dtype=np.float64))
