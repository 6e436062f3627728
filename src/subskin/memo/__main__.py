"""`python -m subskin.memo` prints the page of errata."""

import sys

from .errata import markdown

if __name__ == "__main__":
    sys.stdout.write(markdown())
