"""Judgements as rows of the panel's tables."""

from __future__ import annotations

from collections.abc import Sequence

from gui.accuracy import texts
from gui.accuracy.hidden_tests import HiddenOutcome, Tested
from gui.accuracy.judged_results import Answer, Entry
from gui.accuracy.number_table import Row
from ilf.judgement import Judgement


def truth_rows(answer: Answer, entries: Sequence[Entry]) -> list[Row]:
    """Parts of the frame, each with a row for every result; of one result alone, a row for each part."""
    rows = []
    for name, judged in answer.areas.items():
        if len(entries) == 1:
            rows.append(_row(name, judged[0], False, None, name))
            continue
        rows.append(Row(name))
        best = texts.best_of(judged)
        for number, (entry, one) in enumerate(zip(entries, judged, strict=True)):
            rows.append(_row(entry.name, one, number in best, entry.colour, f"{name}, {entry.name}"))
    return rows


def hidden_rows(outcome: HiddenOutcome, label: int) -> list[Row]:
    """What was tested, over all blocks or over one."""
    judged = [one.blocks.get(label, Judgement()) if label else one.whole for one in outcome.tested]
    best = texts.best_of(judged)
    return [
        _hidden_row(tested, one, number in best)
        for number, (tested, one) in enumerate(zip(outcome.tested, judged, strict=True))
    ]


def _row(name: str, judged: Judgement, is_best: bool, colour: tuple[int, int, int] | None, what: str) -> Row:
    if not judged.pixels:
        hint = f"{what}: no pixel is known in both result and truth."
    else:
        hint = f"{what}: {judged.pixels:,} pixels, on average {1000 * judged.bias:+.2f} mm off."
        hint += " Smallest RMSE of all." if is_best else ""
    return Row(name, (*texts.errors(judged), texts.within(judged)), hint, colour, is_best)


def _hidden_row(tested: Tested, judged: Judgement, is_best: bool) -> Row:
    came_back = f"{tested.coverage:.1%} of the hidden depth came back at all."
    hint = f"{tested.candidate.name}: {judged.pixels:,} pixels. {came_back}"
    hint += " Smallest RMSE of all." if is_best else ""
    if judged.within is not None:
        hint += f" {judged.within:.0%} of the errors are within the expected error."
    colour = None if tested.candidate.kept is None else tested.candidate.kept.colour
    count = texts.thousands(judged.pixels)
    return Row(tested.candidate.name, (*texts.errors(judged), count), hint, colour, is_best)
