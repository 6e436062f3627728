"""`subskin figures`: the memo's figures, redrawn."""

from __future__ import annotations

import argparse

from ..errors import InvalidValueError
from .common import give
from .options import command, listed, option

_EXAMPLES = """\
  subskin figures -o figures
  subskin figures -o figures --only 6,13 --formats svg
"""


@command(
    _EXAMPLES,
    option("-o --out FOLDER", "folder for the figures; made if missing", required=True),
    option("--only LIST", "numbers of the figures, e.g. 6,13"),
    option("--formats LIST", "svg, png, pdf (default svg,png)", "svg,png"),
    option("--json", "print the names of the files as JSON"),
)
def run_figures(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..plot import save_memo_figures

    try:
        numbers = None if options.only is None else [int(part) for part in options.only.split(",")]
    except ValueError:
        raise InvalidValueError(f'--only "{options.only}"', "numbers of figures are needed", "--only 6,13") from None
    files = [str(path) for path in save_memo_figures(numbers, options.out, listed(options.formats))]
    return give(options, lambda: {"files": files}, lambda out: print("\n".join(files), file=out))
