"""`python -m twistcore`."""

import sys

from twistcore.cli import main

sys.exit(main())
