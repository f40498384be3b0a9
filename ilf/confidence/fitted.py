"""The laws of the expected error, written by `python -m ilf.bench.calibration --fit ... --write`."""

from .model import Curve, ErrorModel

MODELS = {name: ErrorModel(-4.0, (Curve((0.0,), (0.0,)),) * 13) for name in ("edge-aware", "ideal")}
