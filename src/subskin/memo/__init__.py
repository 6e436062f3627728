"""MIT AI Memo 771 as published: its equations by number, and its errata.

`eq1` to `eq26` are the equations **as printed**, in the memo's own symbols, SI units and axes (each section's module
says them). Where one is wrong there is a second function, e.g. `eq17_corrected`; the printed one is for comparison
only. One without a verdict is correct. `ERRATA` says what was found and computes the numbers; `python -m subskin.memo`
prints it as the page that the documentation shows.

Every function takes numbers or arrays that broadcast as in NumPy, and raises `InvalidValueError` for a
value that is not finite or, for a length, modulus, resistivity or radius, not positive (`SYMBOLS` lists
them), `GeometryError` for shapes that do not broadcast.
"""

from ._symbols import SYMBOLS, Symbol
from .errata import ERRATA, Erratum, markdown
from .section2 import (
    PlaneStrain,
    PlaneStress,
    PolarStress,
    Resistance,
    Strains,
    eq1,
    eq2,
    eq3,
    eq4,
    eq5,
    eq6,
    eq7,
    eq8,
    eq9,
    eq10,
    eq10_corrected,
    eq11,
    eq11_corrected,
)
from .section3 import FIGURE_6, Figure6, eq12, eq13, eq13_coefficients
from .section6 import eq23, eq24, eq25, eq25_corrected, eq26, eq26_corrected
from .sections4_5 import (
    eq14,
    eq15,
    eq15_constant,
    eq16,
    eq17,
    eq17_corrected,
    eq18,
    eq18_corrected,
    eq19,
    eq20,
    eq20_corrected,
    eq21,
    eq21_corrected,
    eq22,
    eq22_corrected,
)
from .three_sensors import Degeneracy, Note, Root, Sensitivity, ThreeSensorSolution, Verdict, three_sensor

__all__ = [
    "ERRATA", "FIGURE_6", "SYMBOLS", "Degeneracy", "Erratum", "Figure6", "Note", "PlaneStrain", "PlaneStress",
    "PolarStress", "Resistance", "Root", "Sensitivity", "Strains", "Symbol", "ThreeSensorSolution", "Verdict",
    "eq1", "eq2", "eq3", "eq4", "eq5", "eq6", "eq7", "eq8", "eq9", "eq10", "eq10_corrected", "eq11", "eq11_corrected",
    "eq12", "eq13", "eq13_coefficients", "eq14", "eq15", "eq15_constant", "eq16", "eq17", "eq17_corrected", "eq18",
    "eq18_corrected", "eq19", "eq20", "eq20_corrected", "eq21", "eq21_corrected", "eq22", "eq22_corrected", "eq23",
    "eq24", "eq25", "eq25_corrected", "eq26", "eq26_corrected",
    "markdown", "three_sensor",
]  # fmt: skip
