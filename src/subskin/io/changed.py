"""The same finger file with something else in it: another kind of skin or sensor, or what a held touch loses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from ..errors import InvalidValueError
from ..stream.relaxation import Relaxation
from ..stream.relaxation_fit import RelaxationFit, fit_relaxation
from ..transducer import transducer_of
from ._recorded import check_held, table_of
from ._toml_edit import per_sensor, with_table
from .finger_file import FingerFile, parse_finger
from .units import format_quantity, rounded

if TYPE_CHECKING:
    from .._check import FloatArray
    from ..calibration import Calibration
    from .tables import Table

__all__ = ["fit_held", "remodelled", "with_calibration", "with_orientation", "with_relaxation"]

_THICK = 3.0
"""Thickness of a layer that is only to be fitted, in depths of the deepest sensor: where the fit starts from."""


def remodelled(file: FingerFile, *, skin: str = "", kind: str = "") -> FingerFile:
    r"""`file` with another `kind` of sensor, and a "half_plane", a "half_space" or one layer ("layers") as `skin`.

    The material stays; a layer is three depths thick until its thickness is fitted. Comments stay, but for those inside
    a [skin] of another kind. The gain of another kind is per another unit: the stress of a strain, or the other way, is
    taken to be Young's modulus times the strain. What had a unit of the old kind becomes a plain number, in SI.

    Raises
    ------
    InvalidValueError
        Another skin in place of one of several materials, or one that is neither.
    FileError
        A kind of sensor that is not known.

    Examples
    --------
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 6e-3\ndepth = 5e-3"
    >>> str(remodelled(parse_finger(text), skin="layers", kind="mean_pressure").finger.skin.thickness)
    '0.015'
    """
    import tomlkit

    document = tomlkit.parse(file.text)
    if kind:
        _change_kind(document, file, kind)
    if skin:
        material = file.finger.skin.single_material
        if material is None or skin not in ("half_plane", "half_space", "layers"):
            seen = f"a {skin} in place of {file.finger.skin}"
            raise InvalidValueError(
                seen,
                "only what is endless and one layer of one material stand in for each other",
                "save_finger with a new file",
            )
        rubber = {"young": format_quantity(material.young, "Pa"), "poisson": rounded(material.poisson)}
        table = tomlkit.table()
        table.add("kind", skin)
        if skin != "layers":
            table.update(rubber)
        else:
            layer, layers = tomlkit.table(), tomlkit.aot()
            deepest = float(np.asarray(file.finger.array.depth).max())
            layer.update({**rubber, "thickness": format_quantity(_THICK * deepest, "m")})
            layers.append(layer)
            table.add("layers", layers)
        document["skin"] = table
    changed = parse_finger(tomlkit.dumps(document), "the file as changed")
    return changed.of_differences() if file.differences else changed


def _change_kind(document: Any, file: FingerFile, kind: str) -> None:
    """Another `kind` in [sensors], and numbers in its units."""
    sensors = document["sensors"]
    sensors["kind"] = kind
    written, new = parse_finger(file.text).finger, transducer_of(kind)
    felt = {transducer.unit for transducer in written.array.transducers}
    if felt == {new.unit}:
        return
    young = written.skin.materials[0].young
    scale = 1 / young if (felt, new.unit) == ({""}, "Pa") else young if (felt, new.unit) == ({"Pa"}, "") else 1.0
    numbers = {
        key: np.asarray(getattr(written.array, key)) for key in ("gain", "offset", "lift", "noise", "resolution")
    }
    numbers |= {key: np.broadcast_to(end, len(written.array)) for key, end in zip(("low", "high"), file.limits)}
    numbers["gain"] = scale * numbers["gain"]
    # readings without a unit of their own were in that of the old kind
    lost = document.get("recording", {}).get("unit") is None
    for key in numbers if lost else ("gain",):
        if key in sensors:
            sensors[key] = per_sensor(numbers[key])


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


def with_orientation(file: FingerFile, day: str, presses: int) -> FingerFile:
    r"""The file with [oriented]: that so many presses confirmed on a day how the sensors are connected.

    Parameters
    ----------
    file : FingerFile
        The file as it is.
    day : str
        "2026-11-27".
    presses : int
        How many there were.

    Examples
    --------
    >>> from subskin.io import parse_finger
    >>> file = parse_finger("[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 2e-3\ndepth = 2e-3\n")
    >>> with_orientation(file, "2026-11-27", 2).oriented
    '2026-11-27'
    """
    _check.noun("file", file, FingerFile, 'io.load("finger.toml")')
    return replace(file, oriented=day, text=with_table(file.text, "oriented", {"date": day, "presses": presses}))


def with_calibration(file: FingerFile, found: Calibration, facts: Mapping[str, Any]) -> FingerFile:
    r"""The file of the finger that was calibrated, with `facts` in its [calibration].

    Touches that show which way round the sensors are say so in [oriented], with the day.

    Parameters
    ----------
    file : FingerFile
        The file as it is.
    found : Calibration
        What `calibrate` found.
    facts : mapping
        What [calibration] is to say.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.io import parse_finger
    >>> file = parse_finger("[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 2e-3\ndepth = 2e-3\nnoise = 1e-5\n")
    >>> at = np.linspace(-4e-3, 4e-3, 20)
    >>> found = ss.calibrate(file.finger, file.finger.read(ss.LineLoad(40.0, position=at)), at, force=40.0)
    >>> made = with_calibration(file, found, {"touches": 20})
    >>> made.oriented is not None, "touches = 20" in made.text
    (True, True)
    """
    made = file.with_finger(found.finger, found.origin, facts, turn=found.turn)
    if not found.tells_order:
        return made
    return with_orientation(made, date.today().isoformat(), found.score.touches)


def _rounded(values: Any) -> Any:
    return [_rounded(v) for v in values] if np.ndim(values) else rounded(float(values))
