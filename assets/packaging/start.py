"""Entry script of the one-folder app: runs `ilf` or `ilf-gui`, by the name that it is called by."""

import sys
from pathlib import Path

if __name__ == "__main__":
    if Path(sys.argv[0]).stem == "ilf-gui":
        from ilf_studio.app.start import main
    else:
        from ilf.cli import main
    sys.exit(main())
