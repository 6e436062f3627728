"""`python -m subskin` is `subskin`."""

import sys

from .cli import main

sys.exit(main())
