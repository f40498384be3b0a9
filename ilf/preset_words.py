"""What parameters are in few words: the preset that they are nearest to, and what differs from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .declarations import Value
from .parameters import PRESETS, Parameters


@dataclass(frozen=True)
class Likeness:
    """How parameters stand to the preset that they are nearest to.

    Attributes
    ----------
    preset : str
        Its name.
    differs : mapping of str to value
        The values that differ from it and have an effect, by name, in the order of the form.
    """

    preset: str
    differs: Mapping[str, Value]

    def text(self, most: int | None = None) -> str:
        """In words: the preset's name and the values that differ, `most` of them at most.

        Examples
        --------
        >>> from ilf import preset
        >>> likeness(preset(smoothness=0.6, trend=False)).text()
        "best, smoothness 0.6 x, follow the block's shape off"
        >>> likeness(preset(smoothness=0.6, trend=False)).text(most=1)
        'best, smoothness 0.6 x, and 1 more'
        """
        return ", ".join([self.preset, *in_words(self.differs, most)])


def in_words(values: Mapping[str, Value], most: int | None = None) -> list[str]:
    """Values of the filter as people write them, `most` of them at most and how many more there are.

    Examples
    --------
    >>> in_words({"noise": 0.004, "trend": False})
    ['noise 0.004 m', "follow the block's shape off"]
    """
    declarations = Parameters.declarations()
    words = [
        f"{_in_a_list(declarations[name].label)} {declarations[name].in_words(value)}" for name, value in values.items()
    ]
    if most is None or len(words) <= most:
        return words
    return [*words[:most], f"and {len(words) - most} more"]


def likeness(parameters: Parameters, presets: Mapping[str, Parameters] = PRESETS) -> Likeness:
    """The preset that parameters are nearest to, which is the one that fewest values differ from.

    Parameters
    ----------
    parameters : Parameters
    presets : mapping of str to Parameters
        Name -> values; of several that are as near, the first counts.

    Examples
    --------
    >>> from ilf import preset
    >>> likeness(preset("paper", mode="fill+denoise"))
    Likeness(preset='paper', differs={'mode': 'fill+denoise'})
    """
    found = [Likeness(name, _differing(parameters, values)) for name, values in presets.items()]
    return min(found, key=lambda one: len(one.differs))


def _differing(parameters: Parameters, others: Parameters) -> dict[str, Value]:
    return {name: value for name, value in parameters.unlike(others).items() if parameters.matters(name)}


def _in_a_list(label: str) -> str:
    """A label as it stands within a list; symbols, such as S_criteria, stay as they are."""
    label = label.replace(",", "")
    return label[:1].lower() + label[1:] if label[1:2].islower() else label
