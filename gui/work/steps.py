"""Steps that ask: what is asked of the user or a worker, one after the other, is one generator that is sent the
answers."""

from __future__ import annotations

from collections.abc import Callable, Generator
from functools import partial, wraps
from typing import Any, ParamSpec, TypeVar

Ask = Callable[[Callable[..., None]], object]
"""Asks for something, and calls a function with the answer, if there ever is one."""

Result = TypeVar("Result")
Steps = Generator[Ask, Any, Result]
"""Yields what asks, and is sent the answer; one that is an exception is raised there."""

Given = ParamSpec("Given")


def in_steps(steps: Callable[Given, Steps[None]]) -> Callable[Given, None]:
    """Make a function of steps one that goes through them."""

    @wraps(steps)
    def start(*given: Given.args, **options: Given.kwargs) -> None:
        go_on(steps(*given, **options))

    return start


def go_on(steps: Steps[Any], answer: object = None) -> None:
    """Go on with an answer until something else is asked, and then with the next one."""
    try:
        ask = steps.throw(answer) if isinstance(answer, Exception) else steps.send(answer)
    except StopIteration:
        return
    ask(partial(go_on, steps))
