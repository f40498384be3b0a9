"""`python -m gui`: the same as `ilf-gui`."""

import sys

from .app.start import main

sys.exit(main())
