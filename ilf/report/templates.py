"""The templates of a report, with the formats of their values."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from .._runtime.formatting import UNKNOWN, counted, grouped, length_text, millimetres
from .._runtime.installation import __version__
from ..completion.completion import guide_text
from ..completion.confidence.expected_error import MEDIAN_NAME, RMS_MEANING, RMS_NAME
from ..data.camera import camera_text
from ..data.parameters import BlockParameters, Parameters, nearest_preset, to_text
from ..evaluation.evaluation import Evaluated
from ..evaluation.hold_out import untrusted_note
from ..io.encodings import encoding_of_inputs

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, **values: object) -> str:
    """Fill a template of the folder `templates`; texts among the values are escaped."""
    return _environment().get_template(template).render(values)


@cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined  # late: the window needs it for reports only

    environment = Environment(
        loader=PackageLoader("ilf.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "mm": lambda metres: UNKNOWN if metres is None else millimetres(metres),
        "share": lambda share: UNKNOWN if share is None else f"{share:.1%}",
        "colour": lambda colour: "#{:02x}{:02x}{:02x}".format(*colour),
        "counted": counted,
        "grouped": grouped,
        "metres": length_text,
        "parameters": to_text,
        "p95": _p95,
        "camera": camera_text,
        "finite": np.isfinite,
        "nan": np.isnan,
        "median": np.median,
    }
    environment.globals |= {
        "unknown": UNKNOWN,
        "version": __version__,
        "both": lambda one, other: np.count_nonzero(one & other),
        "expected_name": RMS_NAME,
        "median_name": MEDIAN_NAME,
        "expected_meaning": RMS_MEANING,
        "filter_declarations": Parameters.declarations(),
        "extraction_declarations": BlockParameters.declarations(),
        "nearest_preset": nearest_preset,
        "encoding_of": encoding_of_inputs,
        "guide_text": guide_text,
        "untrusted_note": untrusted_note,
    }
    return environment


def _p95(evaluated: Evaluated) -> float:
    """Return the 95th percentile of the absolute errors [m]; NaN if there are none."""
    errors = np.abs(np.concatenate([part.error[part.filled] for part in evaluated.parts]))
    known = errors[np.isfinite(errors)]
    return float(np.percentile(known, 95)) if known.size else math.nan
