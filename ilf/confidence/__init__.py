"""How far filled depth may be off: an expected error for every filled pixel, and where nothing vouches for it.

About 68 % of the true errors lie within the expected error and about 90 % within twice it, as nearly as errors that
are not normal let one number say both. It follows from what can be seen around a pixel (`features`, `walks`) and from
how well part of the frame's own depth comes back when it is hidden (`difficulty`), by a law that is fitted to hidden
depth (`model`, `fitted`) with `ilf.bench.calibration`.
"""

from .expected import DEFAULT_MODEL, depth_error, expected_error, unvouched
from .features import FEATURES, FLOOR, error_features, filled_pixels, usual_edges, usual_notes
from .fitted import MODELS
from .model import WITHIN, WITHIN_TWICE, Curve, ErrorModel
from .summary import MEDIAN_MEANING, MEDIAN_NAME, RMS_MEANING, RMS_NAME, ErrorSummary, error_summary, summarised

__all__ = [
    "DEFAULT_MODEL",
    "FEATURES",
    "FLOOR",
    "MEDIAN_MEANING",
    "MEDIAN_NAME",
    "MODELS",
    "RMS_MEANING",
    "RMS_NAME",
    "WITHIN",
    "WITHIN_TWICE",
    "Curve",
    "ErrorModel",
    "ErrorSummary",
    "depth_error",
    "error_features",
    "error_summary",
    "expected_error",
    "filled_pixels",
    "summarised",
    "unvouched",
    "usual_edges",
    "usual_notes",
]
