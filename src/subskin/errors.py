"""What can go wrong, said so that it can be put right.

Every error names what was seen, the rule that it breaks and, where there is one, the way to fix it. All of them are
`ValueError` too, so that code which knows nothing of `subskin` can catch them.
"""

from __future__ import annotations

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
]


class SubskinError(ValueError):
    """Base of every error that `subskin` raises on purpose.

    Parameters
    ----------
    seen : str
        What was given.
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
        self.seen, self.rule, self.fix = seen, rule, fix
        super().__init__(f"{seen}: {rule}." + (f" Fix: {fix}." if fix else ""))

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


class FileError(SubskinError):
    """A file that cannot be used; the message names the file and, where known, the line."""


class ValidityWarning(UserWarning):
    """A number outside the range in which the theory behind it is good."""


class SingularPointWarning(UserWarning):
    """A field asked for exactly where it is infinite; the value returned there is NaN."""
