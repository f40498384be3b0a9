"""`python -m gui` in a clone, `python -m ilf_studio` once installed: the same as `ilf-gui`."""

import sys

from .app.start import main

sys.exit(main())
