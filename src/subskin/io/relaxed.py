"""What the skin of a finger file forgets of a held touch: fitted to a recording of presses, and written to the file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from ..errors import InvalidValueError
from ..stream.relaxation import Relaxation
from ._recorded import check_held, table_of
from ._toml_edit import with_table
from .units import format_quantity, rounded

if TYPE_CHECKING:
    from .._check import FloatArray
    from ..stream import RelaxationFit
    from .finger_file import FingerFile
    from .tables import Table

__all__ = ["fit_held", "with_relaxation"]

_ENDS = 0.05
"""Share of a plateau at either end in which the indenter may still move."""
_LEVEL = 0.01
"""Share of the stroke below which the indenter is up."""


def fit_held(file: FingerFile, recording: Table | Path, *, terms: int = 2, every: int = 1) -> RelaxationFit:
    r"""What the skin forgets of presses that are held, from a raw recording; `subskin.stream.fit_relaxation` fits it.

    Parameters
    ----------
    file : FingerFile
        With [recording]. A [relaxation] that it has is not undone first.
    recording : Table or pathlib.Path
        One row a frame, from before the first press on.
    terms : {1, 2, 3}, optional
        Terms of the series.
    every : int, optional
        The presses 0, every, 2 every, ... are used.

    Returns
    -------
    RelaxationFit
        Its `own` has the shares of each sensor, and how far they are in doubt.

    Raises
    ------
    FileError, InvalidValueError, ConvergenceError
        As `FingerFile.segment` and `fit_relaxation`.

    Examples
    --------
    >>> import numpy as np, subskin as ss, tempfile
    >>> columns = 'sensors = ["a", "b"]\ntime = { column = "t" }\npress = { column = "z" }'
    >>> text = f"[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 4e-3\ndepth = 2e-3\n[recording]\n{columns}"
    >>> file, t = ss.io.parse_finger(text), np.arange(0.0, 56.0, 0.05)
    >>> down = np.clip(np.minimum(t % 14 - 2.0, 9.0 - t % 14), 0, 1)
    >>> felt = ss.Relaxation([[0.3, 0.1]], [2.0]).apply(down[:, None] * [1.0, 0.6], t)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ss.io.write_table(f"{folder}/raw.csv", {"t": t, "z": 2e-3 * down, "a": felt[:, 0], "b": felt[:, 1]})
    ...     fit = ss.io.fit_held(file, ss.io.read_table(f"{folder}/raw.csv"), terms=1)
    >>> fit.own.share.round(2).tolist(), fit.own.time.round(2).tolist()
    ([[0.3, 0.1]], [2.0])
    """
    from ..stream import fit_relaxation
    from .finger_file import FingerFile

    table = table_of(recording)
    if table is None:
        raise InvalidValueError("recording", "a table with the columns of [recording] is needed", 'Path("raw.csv")')
    _check.noun("file", file, FingerFile, 'io.load("finger.toml")')
    every = _check.whole("every", every, at_least=1, at_most=10**9, fix="every=1")
    plain = replace(file, relaxation=None)
    presses = plain.segment(table)
    readings, time = file.in_range(table)
    first, last = presses.start[::every], presses.stop[::every]
    margin = _ENDS * (last - first)
    held = np.stack([first + margin, last - margin], axis=-1)
    return fit_relaxation(readings, time, held, terms=terms, free=_free(plain, table, time, first))


def _free(file: FingerFile, table: Table, time: FloatArray, first: FloatArray) -> FloatArray | None:
    """The free skin before and after presses held from `first` on; None where the depth is not known."""
    how = file.recording
    if how is None or how.press is None:
        return None
    depth = table.numbers(how.press.name) * how.press.scale
    up = depth <= depth.min() + _LEVEL * np.ptp(depth)
    edges = np.diff(np.concatenate([[0], up.astype(np.int8), [0]]))
    begin, end = time[edges[:-1] == 1], time[edges[1:] == -1]  # of each stretch in which it is up
    k = np.searchsorted(begin, first) - 1
    told = (k >= 0) & (k + 1 < begin.size)
    k = k[told]
    before, after = np.maximum(begin[k], end[k] - how.before), np.minimum(end[k + 1], begin[k + 1] + how.before)
    return np.stack([before, end[k], begin[k + 1], after], axis=-1)


def with_relaxation(file: FingerFile, relaxation: Relaxation) -> FingerFile:
    r"""The same file with `relaxation` as its [relaxation]; the rest of the text stays, comments too.

    Readings at rest are not written: a stream begins with the skin free.

    Parameters
    ----------
    file : FingerFile
        What is to have it; one that it has is replaced.
    relaxation : Relaxation
        As `RelaxationFit.own`.

    Raises
    ------
    GeometryError, InvalidValueError
        Shares of another number of sensors; a doubt of sensors on an area.

    Examples
    --------
    >>> from subskin.io import parse_finger
    >>> file = parse_finger("[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 2e-3\ndepth = 2e-3\n")
    >>> print(with_relaxation(file, Relaxation([[0.1, 0.05]], [1.5], doubt=0.3)).text.split("\n\n")[1].strip())
    [relaxation]
    share = [[0.1, 0.05]]
    time = ["1.5 s"]
    doubt = 0.3
    """
    from .finger_file import FingerFile

    _check.noun("file", file, FingerFile, 'io.load("finger.toml")')
    _check.noun("relaxation", relaxation, Relaxation, "Relaxation(share=[0.1], time=[1.5])")
    check_held(relaxation, file.finger.array)
    # as a reader of the file finds them
    share, doubt = _rounded(relaxation.share), _rounded(relaxation.doubt)
    time = [rounded(float(v)) for v in np.atleast_1d(relaxation.time)]
    told: dict[str, Any] = {"share": share, "time": [format_quantity(v, "s") for v in time]}
    told |= {"doubt": doubt} if np.any(relaxation.doubt) else {}
    return replace(
        file, relaxation=Relaxation(share, time, doubt=doubt), text=with_table(file.text, "relaxation", told)
    )


def _rounded(values: Any) -> Any:
    return [_rounded(v) for v in values] if np.ndim(values) else rounded(float(values))
