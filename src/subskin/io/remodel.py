"""The same finger file with another kind of skin or of sensor in it: candidates for a calibration to choose among."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidValueError
from ..transducer import transducer_of
from ._toml_edit import per_sensor
from .finger_file import parse_finger
from .units import format_quantity, rounded

if TYPE_CHECKING:
    from .finger_file import FingerFile

__all__ = ["remodelled"]

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
