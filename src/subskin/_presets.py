"""Rubbers, barometers and gauges by name, each number with its source. What no source confirms is not here."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from .errors import InvalidValueError

__all__ = ["RUBBERS", "SENSORS", "Rubber", "SensorPreset", "named", "shore_a_modulus"]

_Preset = TypeVar("_Preset")

_PSI = 6894.757293168  # Pa, NIST SP 811
_SECANT, _TANGENT = 1.0, 12 / 7
"""Young's modulus over the stress at 100 % strain: of a straight line, and of a neo-Hookean rubber at no strain. The
stress of the latter at a stretch l is G (l - 1/l^2) and E = 3 G (Treloar, The Physics of Rubber Elasticity, 1975).
"""


@dataclass(frozen=True)
class Rubber:
    """A rubber: Young's modulus as it is taken and the ends between which tests find it [Pa], hardness, source."""

    young: float
    low: float
    high: float
    hardness: str
    source: str


def shore_a_modulus(hardness: float) -> float:
    """Young's modulus [Pa] of a rubber of some Shore A hardness.

    Source: A. N. Gent, On the relation between indentation hardness and Young's modulus, Rubber Chemistry and
    Technology 31 (1958) 896: E = 0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S)) MPa. Good from about 20 to 80.
    """
    return 1e6 * 0.0981 * (56 + 7.62336 * hardness) / (0.137505 * (254 - 2.54 * hardness))


def _stretched(psi: float, hardness: str, sheet: str) -> Rubber:
    """From the stress at 100 % strain of a data sheet: the mean of both readings of it, and both as the ends."""
    low, high = (share * psi * _PSI for share in (_SECANT, _TANGENT))
    source = f"Smooth-On, {sheet} series technical bulletin: 100 % modulus {psi:g} psi; E is 1 to 12/7 of it"
    return Rubber((low * high) ** 0.5, low, high, hardness, source)


RUBBERS: Mapping[str, Rubber] = {
    "Ecoflex 00-10": _stretched(8, "00-10", "Ecoflex"),
    "Ecoflex 00-30": _stretched(10, "00-30", "Ecoflex"),
    "Ecoflex 00-50": _stretched(12, "00-50", "Ecoflex"),
    "Dragon Skin 10": _stretched(22, "10A", "Dragon Skin"),
    "Dragon Skin 20": _stretched(49, "20A", "Dragon Skin"),
    "Dragon Skin 30": _stretched(86, "30A", "Dragon Skin"),
    "Sylgard 184": Rubber(
        2.0e6,
        1.32e6,
        2.97e6,
        "44A to 54A",
        "Johnston et al., J. Micromech. Microeng. 24 (2014) 035017: 10:1, cured at 25 to 200 degrees C, in tension",
    ),
    "Natural rubber 40A": Rubber(
        shore_a_modulus(40),
        shore_a_modulus(35),
        shore_a_modulus(45),
        "40A",
        "Gent, Rubber Chem. Technol. 31 (1958) 896, of its hardness; the ends are those of 35A and 45A",
    ),
}


@dataclass(frozen=True)
class SensorPreset:
    """A barometer or a gauge: noise of a reading and range [unit], and their source. Infinite ends are not known."""

    noise: float
    low: float
    high: float
    source: str
    unit: str = "Pa"


def _quarter_bridge(volts: float, rate: int) -> SensorPreset:
    """One foil gauge of factor 2 in a bridge at 5 V, read by an HX711: 5 V times 2 / 4 a unit of strain."""
    slope = 5.0 * 2.0 / 4.0
    source = f"Avia HX711: {1e9 * volts:.0f} nV rms at {rate} Hz, 20 mV either way; factor 2, a quarter bridge at 5 V"
    return SensorPreset(volts / slope, -20e-3 / slope, 20e-3 / slope, source, "strain")


_UNKNOWN = float("inf")
SENSORS: Mapping[str, SensorPreset] = {
    "BMP280": SensorPreset(
        3.2,
        30e3,
        110e3,
        "Bosch BST-BMP280-DS001-23, table 7: 26.4 cm rms at x1 without filter, at 12 Pa/m (its key parameters)",
    ),
    "BMP581": SensorPreset(
        0.78, -_UNKNOWN, _UNKNOWN, "Bosch BST-BMP581-DS004-02, table 9: 0.78 Pa rms at x1, continuous mode"
    ),
    "LPS25HB": SensorPreset(1.0, 26e3, 126e3, "ST DocID027112: 0.01 hPa rms in high-resolution mode, 260 to 1260 hPa"),
    "MPL115A2": SensorPreset(
        150.0, 50e3, 115e3, "NXP MPL115A2 rev. 10: 50 to 115 kPa; its resolution, 0.15 kPa, taken for its noise"
    ),
    "MS5611": SensorPreset(
        1.2, 1e3, 120e3, "TE MS5611-01BA03: resolution (rms) 0.012 mbar at oversampling 4096, 10 to 1200 mbar"
    ),
    "HX711 10 Hz": _quarter_bridge(50e-9, 10),
    "HX711 80 Hz": _quarter_bridge(90e-9, 80),
}


def named(name: object, presets: Mapping[str, _Preset], what: str) -> _Preset:
    """The preset of that name, written in upper or lower case.

    Raises
    ------
    InvalidValueError
        No such preset.
    """
    known = {key.lower(): key for key in presets}
    wanted = name.strip().lower() if isinstance(name, str) else ""
    if wanted in known:
        return presets[known[wanted]]
    close = difflib.get_close_matches(wanted, list(known), n=1, cutoff=0.7)
    fix = f'did you mean "{known[close[0]]}"' if close else f"known: {', '.join(presets)}"
    raise InvalidValueError(f"{what} {name!r}"[:80], f"no {what} of this name is known", fix)
