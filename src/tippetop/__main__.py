"""`python -m tippetop` is the command `tippetop`."""

import sys

from .cli import main


if __name__ == "__main__":
    sys.exit(main())
