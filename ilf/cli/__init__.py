"""The command line: `ilf complete`, `blocks`, `info`, `evaluate` and the others (`commands`); no Qt."""

from .commands import main as main
