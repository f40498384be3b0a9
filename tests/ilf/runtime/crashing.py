"""Work that ends its process; it imports nothing else, as every new process imports it."""

import os
from pathlib import Path


def only_once(folder: Path, name: str) -> str:
    """Crash the first time that this name is given, and always if it is "bad"."""
    if name == "bad" or not (folder / name).exists():
        (folder / name).touch()
        os.abort()
    return name
