"""Run the `twistcore` command with `python -m twistcore`."""

import sys

if __name__ == "__main__":
    from twistcore.cli import main

    sys.exit(main())
