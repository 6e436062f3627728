"""The command line run in this process: what it says and writes is what a process of its own would say and write."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from subskin.cli import main


@dataclass
class Run:
    """What a command did."""

    code: int
    out: str
    err: str


class _Stream(io.TextIOWrapper):
    """Text that is kept; with `terminal`, it says that somebody is watching."""

    def __init__(self, terminal: bool) -> None:
        super().__init__(io.BytesIO(), "utf-8", write_through=True)
        self._terminal = terminal

    def isatty(self) -> bool:
        return self._terminal

    def text(self) -> str:
        return self.buffer.getvalue().decode()


def subskin(*arguments: object, terminal: bool = False) -> Run:
    """Run `subskin` with `arguments`; with `terminal`, as if its error stream were a terminal."""
    out, err = _Stream(terminal=False), _Stream(terminal)
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main([str(a) for a in arguments])
        except SystemExit as leave:  # argparse
            code = int(leave.code or 0)
    return Run(code, out.text(), err.text())
