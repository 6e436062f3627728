"""What is wrong, incomplete or worth a warning in the memo, with numbers computed from its formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from .._frozen import Frozen
from . import _findings

__all__ = ["ERRATA", "Erratum", "markdown"]

Judgement: TypeAlias = Literal["correct", "caveat", "first order", "incomplete", "rounded", "wrong"]

_JUDGEMENTS: Mapping[Judgement, str] = {
    "correct": "correct",
    "caveat": "correct, with a caveat",
    "first order": "correct to first order",
    "incomplete": "incomplete",
    "rounded": "rounded the unsafe way",
    "wrong": "**wrong**",
}


@dataclass(frozen=True)
class Erratum(Frozen):
    """What was found about one equation, or a few that belong together; `ERRATA` holds all of them.

    Parameters
    ----------
    equation : str
        Number as printed, e.g. "17", or "1 to 4".
    subject : str
        What the equation is about.
    judgement : str
        "correct", "caveat", "first order", "incomplete", "rounded" or "wrong".
    text : str
        What was found, with a field {name} for each number.
    numbers : callable
        Computes those numbers.
    published, corrected : str, optional
        The equation as printed and as it should read, in LaTeX, where they differ.
    functions : str, optional
        The functions of `subskin.memo`, published form first.

    Examples
    --------
    >>> [erratum.equation for erratum in ERRATA if erratum.judgement == "wrong"]
    ['17', '18', '20', '21', '22', '25']
    """

    equation: str
    subject: str
    judgement: Judgement
    text: str
    numbers: Callable[[], Mapping[str, float | str]] = dict
    published: str = ""
    corrected: str = ""
    functions: str = ""

    @property
    def finding(self) -> str:
        """The text with its numbers, computed now.

        Examples
        --------
        >>> next(e for e in ERRATA if e.equation == "17").finding[:34]
        'The printed $a$ is 2.0000 times th'
        """
        return self.text.format(**self.numbers())


ERRATA: tuple[Erratum, ...] = (
    Erratum(
        "1 to 4",
        "stress under a line load",
        "caveat",
        "Equilibrium and compatibility hold. The force on a buried half circle is $({Fx:.4f}, {Fy:.4f})\\,P$ "
        "for $\\alpha$ = "
        "30 degrees, that is $(P \\cos\\alpha, -P \\sin\\alpha)$: a positive $\\alpha$ drags the skin towards "
        "$-y$. Compression is "
        "negative here and positive in (14) to (16), which are pressures, $-\\sigma_x$.",
        _findings.resultant,
        functions="eq1, eq2, eq3, eq4",
    ),
    Erratum(
        "5",
        "Hooke's law along one axis",
        "incomplete",
        "It leaves the other two stresses out: straight beneath a normal line load (8) gives {ratio:.2f} of it. The "
        "memo goes on with (6).",
        _findings.uniaxial,
        functions="eq5",
    ),
    Erratum(
        "6 to 8",
        "strains in plane strain",
        "correct",
        "Exact at $\\nu = 1/2$: (4) put into (7) is (8), and (6) with $\\sigma_z$ from (7) leaves no strain along $z$.",
        functions="eq6, eq7, eq8",
    ),
    Erratum(
        "9, 10",
        "resistance in plane strain",
        "first order",
        "$\\epsilon_y = -\\epsilon_x$ keeps the volume to first order only. At $\\epsilon_x = 0.1$ the ratio "
        "printed is {ratio:.4f}, its "
        "first order {first:.4f}; a body that keeps its volume has {exact:.4f}. Read a strain off a resistance by "
        "$\\epsilon_x = \\sqrt{{R/\\rho}} - 1$.",
        _findings.resistance_plane_strain,
        r"R = \rho\,\frac{1+\epsilon_x}{1-\epsilon_x} \approx \rho\,(1+2\epsilon_x)",
        r"R = \rho\,(1+\epsilon_x)^2",
        "eq9, eq10, eq10_corrected",
    ),
    Erratum(
        "11",
        "resistance in plane stress",
        "first order",
        "The same holds: at $\\epsilon_x = 0.1$ and equal lateral strains the ratio printed is {ratio:.4f}, a "
        "body that keeps "
        "its volume has {exact:.4f}, however the sides share the strain. It needs $\\nu = 1/2$.",
        _findings.resistance_plane_stress,
        r"R = \rho\,\frac{1+\epsilon_x}{(1+\epsilon_y)(1+\epsilon_z)} \approx \rho\,(1+2\epsilon_x)",
        r"R = \rho\,(1+\epsilon_x)^2",
        "eq11, eq11_corrected",
    ),
    Erratum(
        "12",
        "three sensors",
        "correct",
        "With the sensors 1, 2, 3 at $-b$, $0$, $+b$, $y$ is the position of the load and a positive $\\alpha$ "
        "drags the skin towards $+y$.",
        functions="eq12",
    ),
    Erratum(
        "13",
        "polynomial for the position of the load",
        "caveat",
        "It vanishes on every reading of (12), but:\n\n"
        "- Its degree is 8 only if $2\\epsilon_2$ differs from $\\epsilon_1 + \\epsilon_3$. Else it is "
        "{degree_line}, and {degree_equal} "
        "where all three readings are equal.\n"
        "- The false root at $y = 0$ for $x = b$, which the memo names, is there: $f(0) = {at_zero:.0f}$ for "
        "any readings.\n"
        "- It misses those for $b = 2x$, at $y$ = {false_roots} depths, where two sensors are blind at once.\n"
        "- A normal load straight above the middle sensor is a double root for every pitch. An error of 1e-6 in the "
        "middle reading, relative, then moves the position by {moved:.1e} depths: it goes with the square root of the "
        "error. At $b = x$ and $b = \\sqrt 3\\,x$ the Jacobian of (12) vanishes at $y = 0$ for every $\\alpha$.\n"
        "- Readings of one load mostly have four real roots. With $b = x$, no second load that presses within 45 "
        "degrees of the normal explains them from within the array; with another pitch one often does.",
        _findings.polynomial,
        functions="eq13, eq13_coefficients; solved by three_sensor",
    ),
    Erratum(
        "Fig. 6",
        "example of (13)",
        "caveat",
        "The readings are printed positive in compression, against (12). With their sign turned, and rounded as they "
        "are, there are four real roots:\n\n"
        "{table}\n\n"
        "Two pull and one is too close to horizontal, as the memo says. The readings before rounding are those of "
        "$y = 1.5$, $\\alpha$ = -22.5 degrees, $P/E = 2\\pi/3$: {exact}.",
        _findings.figure_6,
        functions="FIGURE_6",
    ),
    Erratum(
        "14",
        "pressure under a rectangular indenter",
        "caveat",
        "Its integral is ${load:.6f}\\,P$. The sign is that of a pressure, against (1) to (8).",
        _findings.punch,
        functions="eq14",
    ),
    Erratum(
        "15",
        "pressure under a wedge",
        "caveat",
        "$K$ is left open: it is $E/(\\pi(1 - \\nu^2))$. The integral is ${load:.6f}\\,\\pi a K\\cot(\\theta/2)$, so "
        "$a = P(1 - \\nu^2)\\tan(\\theta/2)/E$. The flanks slope by $\\cot(\\theta/2)$, {slope:.2f} at the 90 "
        "degrees that the memo names: linear "
        "theory is for blunt wedges.",
        _findings.wedge,
        functions="eq15, eq15_constant",
    ),
    Erratum(
        "16",
        "pressure under a cylinder",
        "caveat",
        "Its integral is ${load:.6f}\\,P$, with $a$ the half width. The sign is that of a pressure.",
        _findings.cylinder,
        functions="eq16",
    ),
    Erratum(
        "17",
        "half width of the contact of a cylinder",
        "wrong",
        "The printed $a$ is {ratio:.4f} times the half width: it is the whole width. Put into (16) it makes the "
        "greatest pressure {peak:.4f} of the true one, and the surface under that pressure fits a cylinder of "
        "${radius:.4f}\\,R$.",
        _findings.half_width,
        r"a = 2\left[\frac{4RP(1-\nu^2)}{\pi E}\right]^{1/2}",
        r"a = \left[\frac{4RP(1-\nu^2)}{\pi E}\right]^{1/2}",
        "eq17, eq17_corrected",
    ),
    Erratum(
        "18",
        "pressure between two edges",
        "wrong",
        "With $a = a_2 - a_1$ the integral is ${load:.8f}\\,P$ and the pressure at the edges is "
        "${edge:.4f}\\,P/(a_2 - a_1)$, where "
        "it has to vanish.",
        _findings.semi_ellipse,
        r"a = a_2 - a_1",
        r"a = \frac{a_2 - a_1}{2}",
        "eq18, eq18_corrected",
    ),
    Erratum(
        "19", "strain beneath any pressure", "correct", "A convolution of (8) with the pressure.", functions="eq19"
    ),
    Erratum(
        "20",
        "strain beneath a sliding cylinder",
        "wrong",
        "It inherits $a = a_2 - a_1$ from (18): {deep:.4f} of the true strain deep beneath the contact, "
        "{near:.4f} at a "
        "depth of a twentieth of its width, beneath its centre. Right with $a = (a_2 - a_1)/2$; the limits of the "
        "integral are right.",
        _findings.sliding_cylinder,
        r"a = a_2 - a_1",
        r"a = \frac{a_2 - a_1}{2}",
        "eq20, eq20_corrected",
    ),
    Erratum(
        "21",
        "slope of that strain beneath the centre",
        "wrong",
        "Wrong in four ways. It keeps the boundary terms of Leibniz' rule and drops the integral. The boundary terms, "
        "and $\\sqrt 3$ with them, are there only because (18) does not vanish at the edges. Its sign is opposite to "
        "theirs. And a factor $1/a$ is too many: with all lengths doubled at the same $P/E$ it falls by {falls:.0f}, a "
        "slope of strain under a line force by {should:.0f}. At a depth of a tenth of the half width it is "
        "{printed:+.4f} where the slope is {true:+.4f} ($P = E$ = half width = 1, $\\alpha$ = 30 degrees). The "
        "true slope "
        "vanishes for every $\\alpha$ at $x$ = {blind:.10f} half widths.",
        _findings.slope,
        r"\frac{d\epsilon_x}{dy} = -\frac{3\sqrt{3}P}{2\pi^2 aE}\left[x^2-\left(\frac{a}{2}\right)^2\right]"
        r"\left[x^2+\left(\frac{a}{2}\right)^2\right]^{-2}\sin\alpha, \quad a = a_2 - a_1",
        r"\frac{d\epsilon_x}{dy} = -\frac{3P\sin\alpha}{\pi E a^2}"
        r"\left[1-\frac{x(x^2+2a^2)}{(x^2+a^2)^{3/2}}\right], \quad a = \frac{a_2 - a_1}{2}",
        "eq21, eq21_corrected",
    ),
    Erratum(
        "22",
        "that slope under a wide contact",
        "wrong",
        "It is {limit:+.4f} times what (21) tends to as $x$ goes to 0. With the dimension mended, by a factor "
        "$a$, it is "
        "{part:.4f} of the true slope.",
        _findings.wide_contact,
        r"\frac{d\epsilon_x}{dy} \approx \frac{-6\sqrt{3}P\sin\alpha}{\pi^2a^3E}, \quad a = a_2 - a_1",
        r"\frac{d\epsilon_x}{dy} \approx -\frac{3P\sin\alpha}{\pi E a^2}, \quad a = \frac{a_2 - a_1}{2}",
        "eq22, eq22_corrected",
    ),
    Erratum(
        "23, 24",
        "strain as a convolution",
        "correct",
        "(24) is (8) for a unit normal load, and (23) is (19) without a tangential load.",
        functions="eq23, eq24",
    ),
    Erratum(
        "25",
        "spectrum of the response",
        "wrong",
        "Right for $s > 0$. For $s < 0$ it lacks $|s|$: at $s d = -0.1$ it is {printed:+.4f}, the Fourier integral "
        "{integral:+.4f}.",
        _findings.spectrum,
        r"H(s) = -3\pi d\,s\,e^{-d|2\pi s|}",
        r"H(s) = -3\pi d\,|s|\,e^{-d|2\pi s|}",
        "eq25, eq25_corrected",
    ),
    Erratum(
        "26",
        "frequency at which the response has fallen a thousandfold",
        "rounded",
        "$W_{{-1}}$ being the lower branch of Lambert's function, $f = {f:.10f}$ and the density of sensors is "
        "$s d \\ge {density:.11f}$. The printed 3.2 attenuates {attenuation:.0f}-fold, not a thousandfold.",
        _findings.density,
        r"f = 10.2, \quad sd > 3.2",
        r"f = -W_{-1}\left(-\frac{1}{1000\,e}\right), \quad sd > \frac{f}{\pi}",
        "eq26, eq26_corrected",
    ),
)
"""The memo's equations in order, each with what was found."""

_HEAD = """# Errata of the memo

The theory behind this package is MIT AI Memo 771 (Fearing and Hollerbach, 1984). Each of its equations 1 to
26 is a function of `subskin.memo`, as printed; where it is wrong, a second function, its name ending in
`_corrected`, has it right. Symbols and axes on this page are the memo's; how they differ from the project's
is on the page of [conventions](conventions.md).

This page is what `python -m subskin.memo` prints. Its numbers are computed from the formulas while it is
printed.
"""


def markdown() -> str:
    """The page of errata, as Markdown.

    Examples
    --------
    >>> markdown().splitlines()[0]
    '# Errata of the memo'
    """
    lines = [_HEAD, "| equation | subject | judgement |", "|---|---|---|"]
    lines += [f"| {_numbered(e.equation)} | {e.subject} | {_JUDGEMENTS[e.judgement]} |" for e in ERRATA]
    for e in ERRATA:
        judged = "**Wrong" if e.judgement == "wrong" else _JUDGEMENTS[e.judgement].capitalize()
        judged += ".**" if e.judgement == "wrong" else "."
        lines += ["", f"## {_numbered(e.equation)} {e.subject}", "", judged]
        if e.published:
            lines += [*_displayed("As printed:", e.published), *_displayed("Instead:", e.corrected)]
        lines += ["", e.finding]
        if e.functions:
            lines += ["", f"In `subskin.memo`: {_code(e.functions)}."]
    return "\n".join(lines) + "\n"


def _displayed(words: str, formula: str) -> list[str]:
    return ["", words, "", "$$", formula, "$$"]


def _numbered(equation: str) -> str:
    return f"({equation})" if equation[0].isdigit() else equation


def _code(names: str) -> str:
    first, _, rest = names.partition("; ")
    listed = ", ".join(f"`{name}`" for name in first.split(", "))
    if not rest:
        return listed
    *words, last = rest.split(" ")
    return f"{listed}; {' '.join(words)} `{last}`"
