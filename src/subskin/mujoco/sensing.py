"""Skins that a MuJoCo model names itself: each with its finger file, its rate, and what its sensors do wrong."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import InvalidValueError
from ..faults import SensorFaults
from ..io import load
from .geom_skin import GeomSkin
from .installed import engine

if TYPE_CHECKING:
    import mujoco

__all__ = ["SampledSkin", "skins_of"]

_PREFIX = "skin:"
_FAULTS = tuple(field.name for field in fields(SensorFaults))


class SampledSkin:
    """A skin that is read at a rate of its own, with the noise, the drift and the memory of its sensors.

    Between samples it keeps the last one, as a board does.

    Parameters
    ----------
    skin : GeomSkin
        The skin.
    rate : float, optional
        Samples a second [Hz]; each time it is asked, if left out.
    faults : SensorFaults, optional
        What its sensors do wrong; their own noise comes from the finger.
    envs : int, optional
        For how many copies of the model it is: each has sensors of its own.
    seed : int, optional
        Of what is random.

    Examples
    --------
    >>> import mujoco, subskin as ss
    >>> from subskin.mujoco import GeomSkin, SampledSkin
    >>> model = mujoco.MjModel.from_xml_string(
    ...     '<mujoco><worldbody><geom name="pad" type="box" size=".01 .01 .005"/></worldbody></mujoco>')
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3, noise=2e-4)
    >>> skin = GeomSkin(model, "pad", ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), "+z")
    >>> sampled = SampledSkin(skin, rate=500.0, faults=ss.faults.SensorFaults(gain=0.02), seed=1)
    >>> sampled.read(mujoco.MjData(model)).shape
    (16,)
    """

    def __init__(
        self,
        skin: GeomSkin,
        rate: float | None = None,
        faults: SensorFaults | None = None,
        *,
        envs: int = 1,
        seed: int = 0,
    ) -> None:
        self.skin = skin
        self.period = 0.0 if rate is None else 1.0 / _check.scalar("rate", rate, unit="Hz", above=0.0)
        count = _check.whole("envs", envs, at_least=1, at_most=10**6, fix="envs=1")
        worn, array = SensorFaults() if faults is None else faults, skin.finger.array
        rngs = [np.random.default_rng(each) for each in np.random.SeedSequence([771, seed]).spawn(2 * count)]
        self._offset = np.broadcast_to(array.offset, len(array))
        self._spoiled = [worn.begin(array.points, rng) for rng in rngs[:count]]
        self._rngs = rngs[count:]
        self._last, self._due = np.zeros((count, len(array))), np.full(count, -np.inf)

    def reset(self, env: int = 0, seed: int | None = None) -> None:
        """An episode begins: what drifted and what the rubber remembers is gone; the sensors are the same.

        Parameters
        ----------
        env : int, optional
            Which copy of the model.
        seed : int, optional
            Of the noise from now on.
        """
        self._spoiled[env].restart()
        self._due[env] = -np.inf
        if seed is not None:
            self._rngs[env] = np.random.default_rng([771, seed])

    def read(self, data: mujoco.MjData, env: int = 0) -> FloatArray:
        """The last sample, shape (n,); a new one where it is due.

        Parameters
        ----------
        data : mujoco.MjData
            The state.
        env : int, optional
            Of which copy of the model.
        """
        now = float(data.time)
        if now >= self._due[env] - 1e-9 or now < self._due[env] - 2 * self.period:  # or the clock was put back
            first = not np.isfinite(self._due[env])
            self._due[env] = (now if first else max(self._due[env], now - self.period)) + self.period
            frame = self.skin.feel(data).read(self._rngs[env])
            self._last[env] = self._spoiled[env].step(frame, self._offset, now)
        return np.array(self._last[env])

    def read_all(self, datas: Sequence[mujoco.MjData]) -> FloatArray:
        """The last sample of each copy of the model, shape (envs, n).

        Parameters
        ----------
        datas : sequence of mujoco.MjData
            One for each.
        """
        return np.stack([self.read(data, env) for env, data in enumerate(datas)])


def skins_of(
    model: mujoco.MjModel, folder: str | PathLike[str] = ".", *, envs: int = 1, seed: int = 0
) -> dict[str, SampledSkin]:
    """The skins that a model names, by their geoms.

    An MJCF names a skin by a text: `<custom><text name="skin:pad" data="finger=pad.toml face=+x rate=500"/></custom>`.
    Behind it may stand what `SensorFaults` takes: gain, offset, drift, dead, crosstalk, noise, resolution, and, comma
    between them, share and time.

    Parameters
    ----------
    model : mujoco.MjModel
        The compiled model.
    folder : path, optional
        Where the finger files are.
    envs, seed
        As of `SampledSkin`.

    Raises
    ------
    InvalidValueError
        A text that says something else, or no finger; a geom that is not there.
    FileError
        A finger file that cannot be read.

    Examples
    --------
    >>> import mujoco
    >>> skins_of(mujoco.MjModel.from_xml_string("<mujoco/>"))
    {}
    """
    mujoco, found = engine(), {}
    for i in range(model.ntext):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, i)
        if name.startswith(_PREFIX):
            start = model.text_adr[i]
            said = bytes(model.text_data[start : start + model.text_size[i]]).rstrip(b"\0").decode()
            geom = name.removeprefix(_PREFIX)
            found[geom] = _skin_of(model, geom, said, Path(folder), envs, seed + i)
    return found


def _skin_of(model: Any, geom: str, said: str, folder: Path, envs: int, seed: int) -> SampledSkin:
    parts = dict(each.partition("=")[::2] for each in shlex.split(said))
    known = {"finger", "face", "rate", *_FAULTS}
    if "finger" not in parts or not parts.keys() <= known:
        rule = f"finger=FILE is needed, and any of {', '.join(sorted(known - {'finger'}))}"
        raise InvalidValueError(f'text "{_PREFIX}{geom}" with data "{said}"', rule, "finger=pad.toml face=+x rate=500")
    skin = GeomSkin(model, geom, load(folder / parts.pop("finger")).finger, parts.pop("face", "+x"))
    try:
        numbers = {name: [float(value) for value in text.split(",")] for name, text in parts.items()}
    except ValueError:
        seen = f'text "{_PREFIX}{geom}" with data "{said}"'
        raise InvalidValueError(seen, "numbers in SI units are needed", "rate=500 gain=0.02") from None
    rate = numbers.pop("rate", [None])[0]
    faults: dict[str, Any] = {
        name: values if name in ("share", "time") else values[0] for name, values in numbers.items()
    }
    return SampledSkin(skin, rate, SensorFaults(**faults), envs=envs, seed=seed)
