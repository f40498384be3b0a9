"""The templates of a report, with the formats of their values."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from .._runtime.formatting import UNKNOWN, counted, grouped, length_text, millimetres
from .._runtime.installation import __version__
from ..completion.confidence.expected_error import RMS_MEANING, RMS_NAME
from ..data.parameters import to_text

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
    }
    environment.globals |= {
        "unknown": UNKNOWN,
        "version": __version__,
        "expected_name": f"{RMS_NAME} [mm]",
        "expected_meaning": RMS_MEANING,
    }
    return environment
