"""``python -m markermend_app``: the command line."""

import sys

from markermend_app.cli import main

if __name__ == "__main__":
    sys.exit(main())
