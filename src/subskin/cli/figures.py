"""`subskin figures`: the memo's figures, redrawn."""

from __future__ import annotations

import argparse

from ..errors import InvalidValueError
from .common import describe, give, listed

_EXAMPLES = """\
  subskin figures -o figures
  subskin figures -o figures --only 6,13 --formats svg
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES)
    parser.add_argument("-o", "--out", metavar="FOLDER", required=True, help="folder for the figures; made if missing")
    parser.add_argument("--only", metavar="LIST", help="numbers of the figures, e.g. 6,13")
    parser.add_argument("--formats", metavar="LIST", default="svg,png", help="svg, png, pdf (default svg,png)")
    parser.add_argument("--json", action="store_true", help="print the names of the files as JSON")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..plot import save_memo_figures

    try:
        numbers = None if options.only is None else [int(part) for part in options.only.split(",")]
    except ValueError:
        raise InvalidValueError(f'--only "{options.only}"', "numbers of figures are needed", "--only 6,13") from None
    files = [str(path) for path in save_memo_figures(numbers, options.out, listed(options.formats))]
    return give(options, lambda: {"files": files}, lambda out: print("\n".join(files), file=out))
