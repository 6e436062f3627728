"""What can go wrong, said so that it can be put right.

Every error names what was seen, the rule that it breaks and, where there is one, the way to fix it. All of them are
`ValueError` too, so that code which knows nothing of `subskin` can catch them.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

__all__ = [
    "ConvergenceError",
    "FileError",
    "GeometryError",
    "InvalidValueError",
    "NotLinearError",
    "SingularPointWarning",
    "SubskinError",
    "UnknownOptionError",
    "ValidityWarning",
    "WorkersError",
    "each_printable",
    "printable",
]

_SEEN, _SAID = 300, 3000  # letters of what was seen, and of a rule or a fix, at most


def printable(text: object, longest: int = _SAID) -> str:
    r"""Text as it may be shown: control characters written out, and its end left off where it is long.

    What comes from a file could otherwise move a terminal's cursor, or fill it.

    Parameters
    ----------
    text : object
        What is shown.
    longest : int, optional
        Letters that are shown at most.

    Examples
    --------
    >>> printable("\x1b[31ms0\x07"), printable("a" * 100, 8)
    ('\\x1b[31ms0\\x07', 'aaaaa...')
    """
    shown = str(text)
    if len(shown) > longest:
        shown = shown[: longest - 3] + "..."
    if shown.isprintable():
        return shown
    return "".join(c if c in "\n\t" or unicodedata.category(c) not in _HIDDEN else _written(c) for c in shown)


def each_printable(texts: Sequence[object]) -> list[str]:
    r"""Several texts, each as by `printable`.

    Parameters
    ----------
    texts : sequence of object
        What is shown.

    Examples
    --------
    >>> each_printable(["s0\x07", 3])
    ['s0\\x07', '3']
    """
    shown = list(map(str, texts))
    plain = all(map(str.isprintable, shown)) and len(max(shown, key=len, default="")) <= _SAID
    return shown if plain else list(map(printable, shown))


_HIDDEN = {"Cc", "Cf", "Cs"}


def _written(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


class SubskinError(ValueError):
    """Base of every error that `subskin` raises on purpose.

    Parameters
    ----------
    seen : str
        What was given; it, the rule and the fix are kept as `printable` shows them.
    rule : str
        What has to hold.
    fix : str, optional
        How to mend it.

    Examples
    --------
    >>> print(SubskinError("young = -1.0", "a modulus is positive", "give young in Pa, e.g. 0.4e6"))
    young = -1.0: a modulus is positive. Fix: give young in Pa, e.g. 0.4e6.
    """

    def __init__(self, seen: str, rule: str, fix: str = "") -> None:
        self.seen, self.rule, self.fix = printable(seen, _SEEN), printable(rule), printable(fix)
        super().__init__(f"{self.seen}: {self.rule}." + (f" Fix: {self.fix}." if fix else ""))

    def __reduce__(self) -> tuple[type[SubskinError], tuple[str, str, str]]:
        """Pickled and copied by its three parts: an exception alone would hand on its message only."""
        return type(self), (self.seen, self.rule, self.fix)


class InvalidValueError(SubskinError):
    """A value that the physics or the interface does not allow."""


class UnknownOptionError(SubskinError, TypeError):
    """An option that does not exist; the message names those that do."""


class GeometryError(SubskinError):
    """Shapes that do not fit each other, or positions outside the body."""


class NotLinearError(SubskinError):
    """A transducer whose reading is not linear in the load, where linearity is needed."""


class ConvergenceError(SubskinError):
    """A fit that found no answer it could stand by."""


class WorkersError(SubskinError):
    """Workers of an executor that died, or cannot be reached; what was finished before is kept."""


class FileError(SubskinError):
    """A file that cannot be used; the message names the file and, where known, the line."""


class ValidityWarning(UserWarning):
    """A number outside the range in which the theory behind it is good."""


class SingularPointWarning(UserWarning):
    """A field asked for exactly where it is infinite; the value returned there is NaN."""
