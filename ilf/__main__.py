"""`python -m ilf`: the command line, for when the `ilf` command is not on the path."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
