"""The present results of a stored frame as a run and what came of it, to be exported, or made again."""

from __future__ import annotations

from ..outcomes import Completion, compose
from ..run import Run
from ..run.record import array_sha256
from ..run.replaying import how_far
from .frame_state import FrameState


def stored_run(state: FrameState) -> Run:
    """What the present results were made of: the blocks that have one, each with the parameters that it was run with.

    Parameters
    ----------
    state : FrameState
    """
    run, results = state.run(), state.results
    return Run(
        run.frame,
        run.blocks,
        run.parameters,
        {label: result.parameters for label, result in results.items()},
        frozenset(results),
        dense=state.guess is not None,
        extraction=run.extraction,
        edited=run.edited,
        network=run.network,
        drawn=run.drawn,
    )


def stored_completion(state: FrameState) -> Completion:
    """What the present results compose to, the guess of the rest included."""
    completion = compose(state.frame, {label: state.results[label] for label in sorted(state.results)})
    return completion if state.guess is None else state.guess.added_to(completion)


def differences(state: FrameState, completion: Completion) -> tuple[str, ...]:
    """How what `stored_run` gives now differs from what is stored; empty if it is the same, bit for bit.

    Parameters
    ----------
    state : FrameState
    completion : Completion
        Of `stored_run(state)`.

    Returns
    -------
    tuple of str
        A sentence each.

    Examples
    --------
    >>> import ilf
    >>> from ilf.assets import asset_path
    >>> run = ilf.Run.extracted(ilf.load_frame(asset_path("samples/room")))
    >>> completion = run.complete()
    >>> state = FrameState("a1", run.frame, run.blocks, results=completion.results)
    >>> differences(state, completion)
    ()
    """
    stored = stored_completion(state)
    sentences = []
    if array_sha256(stored.depth) != array_sha256(completion.depth):
        sentences.append(f"{how_far(completion.depth, stored.depth)}.")
    others = [label for label, outcome in stored.outcomes.items() if completion.outcomes.get(label) != outcome]
    if others:
        blocks = ", ".join(map(str, others[:10])) + (", ..." if len(others) > 10 else "")
        sentences.append(f"Other iterations, or another end, than stored: block{'s' * (len(others) > 1)} {blocks}.")
    return tuple(sentences)
