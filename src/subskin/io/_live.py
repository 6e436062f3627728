"""[live] of a finger.toml: which board the sensors are read by, and what its numbers are worth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from ..errors import InvalidValueError
from .units import si_unit, unit_scale

if TYPE_CHECKING:
    from ..stream.presses import RecordingFormat
    from . import _schema

__all__ = ["LiveFormat", "live_of"]


@dataclass(frozen=True, eq=False)
class LiveFormat(Frozen):
    r"""How the sensors of a finger are read as they feel: what [live] of its file says.

    Parameters
    ----------
    port : str
        As `subskin.live.ports.opened` takes it; "" where the file does not say.
    driver : mapping
        The driver's name, under "name", and its options; empty where the file does not say. A name that ends with
        .toml is a file that describes a board.
    channels : tuple of str
        The driver's channel for each sensor, in the order of the sensors; empty for the driver's own, in their order.
    scale : ndarray, shape (n,)
        What one count of each sensor's channel is worth, relative to the SI unit of its reading.

    Examples
    --------
    >>> import subskin as ss
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 2e-3\ndepth = 2e-3\n[live]\nunit = 'hPa'\n"
    >>> live = ss.io.parse_finger(text + "driver = {name = 'lines', sensors = 2}").live
    >>> live.driver["name"], live.scale.tolist()
    ('lines', [100.0, 100.0])
    """

    port: str = ""
    driver: Mapping[str, Any] = field(default_factory=dict)
    channels: tuple[str, ...] = ()
    scale: FloatArray = None  # type: ignore[assignment]


def live_of(
    table: _schema.LiveTable, count: int, of: RecordingFormat | None, si: str | None, folder: Path
) -> LiveFormat:
    """The board that [live] describes, for `count` sensors; where no unit is given, that `of` [recording].

    Units have the dimension of the readings, whose SI unit is `si`, where that is known. A file that describes a board
    is looked for in the `folder` of the finger file.

    Raises
    ------
    InvalidValueError
        Another number of channels or units than of sensors; a unit that readings have not; a driver without a name.
    """
    driver = {"name": table.driver} if isinstance(table.driver, str) else dict(table.driver or {})
    if driver and not (isinstance(driver.get("name"), str) and driver["name"]):
        raise InvalidValueError("driver without a name", "a name is needed", 'driver = {name = "lines", sensors = 4}')
    if driver and driver["name"].endswith(".toml"):
        driver["name"] = str(folder / driver["name"])
    units = table.unit if isinstance(table.unit, list) else [] if table.unit is None else count * [table.unit]
    for key, given in (("channels", table.channels), ("unit", table.unit if isinstance(table.unit, list) else None)):
        if given is not None and len(given) != count:
            rule = f"one for each of the {count} sensors of [sensors] is needed"
            raise InvalidValueError(f"{key} lists {len(given)}", rule, "one for each sensor, in the order of the row")
    worth = [unit_scale(unit, si_unit(unit, "unit") if si is None else si, "unit") for unit in units]
    scales = np.array(worth or count * [1.0 if of is None else of.scale])
    scales.flags.writeable = False
    return LiveFormat(table.port or "", driver, tuple(table.channels or ()), scales)
