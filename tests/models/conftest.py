"""The scripts of assets/models and assets/samples are imported as they run: from their folders."""

import sys
from pathlib import Path

_ASSETS = Path(__file__).parents[2] / "assets"
sys.path[:0] = [str(_ASSETS / "models"), str(_ASSETS / "samples")]
