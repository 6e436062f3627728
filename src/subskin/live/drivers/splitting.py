"""Bytes cut at the ends of lines; what is kept of a line that never ends is bounded."""

from __future__ import annotations

__all__ = ["Splitter"]


class Splitter:
    r"""Cuts bytes at the ends of lines.

    Parameters
    ----------
    longest : int
        Bytes of a line at most; of a longer one nothing is kept.

    Examples
    --------
    >>> splitter = Splitter(longest=4)
    >>> splitter.feed(b"ab\ncdefg\nh"), splitter.feed(b"i\n")
    ([b'ab', None], [b'hi'])
    """

    def __init__(self, longest: int) -> None:
        self._longest = longest
        self.reset()

    def reset(self) -> None:
        """Forget the line that is unfinished."""
        self._kept, self._long = b"", False

    def feed(self, data: bytes) -> list[bytes | None]:
        """The lines that end in `data`; None for one that is too long."""
        *whole, rest = (self._kept + data).split(b"\n")
        lines = [None if len(line) > self._longest else line for line in whole]
        if lines and self._long:
            lines[0] = None
        self._long = (self._long and not lines) or len(rest) > self._longest
        self._kept = b"" if self._long else rest
        return lines
