"""`python -m inspector`."""

import sys

# The import stands inside: worker processes import this module again and need no Qt.
if __name__ == "__main__":
    from inspector.app import main

    sys.exit(main())
