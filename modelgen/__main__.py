"""``python -m modelgen``: the command line where the script ``modelgen`` is not on the path. Stands below ``cli``."""

from __future__ import annotations

import sys

from modelgen.cli import main

if __name__ == "__main__":
    sys.exit(main())
