"""`python -m gui`: the same as `ilf-gui`."""

import sys

from gui.app import main

sys.exit(main())
