"""Input checked by declaration: what a type asks for, of a field and of an argument."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt
import pint
import pytest

from subskin._declared import Fix, Friction, Length, Noun, Real, Ruled, Share, Whole, checked
from subskin.errors import GeometryError, InvalidValueError, ValidityWarning

U = pint.UnitRegistry()


def _upper(name: str, value: Any) -> Any:
    return value.upper()


@dataclass(frozen=True)
class Bead(Noun):
    radius: Length
    EXAMPLE: ClassVar = "Bead(1e-3)"


@dataclass(frozen=True, eq=False)
class Chain(Noun):
    beads: Sequence[Bead]
    pitch: Annotated[float, Real("m", above=0.0, fix="leave it out")] = 1.0
    count: Annotated[int, Whole(1, 9)] = 3
    closed: bool = False
    kind: Literal["loose", "tight"] = "loose"
    ends: Annotated[tuple[float, float], Real("m", at_least=-1.0)] = (0.0, 1.0)
    held: Bead | None = None
    at: Annotated[npt.ArrayLike, Real("m", at_most=1.0)] = 0.0
    weight: npt.ArrayLike = 1.0
    share: Share = 1.0
    friction: Friction = 1.0
    called: Annotated[str, Ruled(_upper)] = "a"
    told: Callable[[float], None] | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
    sizes: tuple[Length, ...] = ()


def test_fields_become_what_they_are_declared_to_be():
    at = np.zeros((3, 1))
    made = Chain(
        [Bead(1)], pitch=U.Quantity(2, "mm"), count=4.0, ends=[0, 1], at=at, weight=[1, 2], called="b", sizes=[1]
    )
    assert type(made.beads) is tuple
    assert type(made.beads[0].radius) is float
    assert (made.pitch, made.count, made.ends, made.called, made.sizes) == (0.002, 4, (0.0, 1.0), "B", (1.0,))
    assert type(made.count) is int
    assert type(made.ends[0]) is float
    at[:] = 7.0
    assert not made.at.any()
    assert not made.at.flags.writeable
    assert made.weight.dtype == np.float64
    assert made._common_shape() == (3, 2)
    again = pickle.loads(pickle.dumps(made))
    assert (again.weight == made.weight).all()
    assert not again.weight.flags.writeable


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"beads": Bead(1.0)}, "beads = .*a list is needed, each of it a Bead. Fix: .Bead.1e-3.."),
        ({"beads": [1.0]}, "each of it a Bead"),
        ({"pitch": 0.0}, "pitch = 0: has to be > 0 .m.. Fix: leave it out"),
        ({"pitch": True}, "pitch = True: a real number"),
        ({"pitch": np.array([True])}, "a real number"),
        ({"pitch": [1.0, 2.0]}, "pitch of shape .2,.: a single number is needed"),
        ({"pitch": np.nan}, "pitch = nan: has to be finite"),
        ({"pitch": 1e80}, "at most 1e.75 in magnitude"),
        ({"pitch": 1e-80}, "at least 1e-75"),
        ({"pitch": U.Quantity(1, "s")}, "a quantity in m is needed"),
        ({"count": 2.5}, "count = 2.5: a whole number from 1 to 9 is needed"),
        ({"count": True}, "a whole number"),
        ({"closed": "no"}, "closed = 'no': True or False is needed"),
        ({"kind": "lose"}, 'kind = .lose.: has to be "loose" or "tight". Fix: kind="loose"'),
        ({"ends": (-2.0, 0.0)}, r"ends\[0\] = -2: has to be >= -1"),
        ({"ends": (1.0,)}, "two ascending numbers"),
        ({"held": 1.0}, r"held = 1.0: a Bead is needed. Fix: Bead\(1e-3\)"),
        ({"at": [0.0, 2.0]}, r"at\[1\] = 2: has to be <= 1"),
        ({"weight": [np.inf]}, "weight.0. = inf: has to be finite"),
        ({"share": 1.5}, "share = 1.5: has to be <= 1"),
        ({"friction": -1.0}, "friction = -1: has to be >= 0"),
        ({"told": 3}, "told = 3: a function is needed"),
        ({"notes": []}, "notes = .*a Mapping is needed"),
        ({"sizes": (1.0, -1.0)}, r"sizes\[1\] = -1: has to be > 0"),
    ],
)
def test_what_is_not_as_declared_is_refused(given, said):
    with pytest.raises(InvalidValueError, match=said):
        Chain(**({"beads": ()} | given))


def test_bounds_are_where_they_are_said():
    assert Chain((), ends=(-1.0, 0.0), share=0.0).share == 0.0
    assert Chain((), at=1.0, pitch=1e-75, share=1.0).pitch == 1e-75
    assert Chain((), friction=np.inf, held=None).friction == np.inf
    with pytest.warns(ValidityWarning, match="friction = 30 is a coefficient"):
        Chain((), friction=30.0)
    with pytest.raises(GeometryError, match=r"at \(2,\), weight \(3,\)"):
        Chain((), at=[0.0, 0.0], weight=[1.0, 1.0, 1.0])._common_shape()


def test_a_derived_class_checks_its_own_fields_too():
    @dataclass(frozen=True)
    class Pearl(Bead):
        lustre: Share = 0.5
        unseen: OnlyForTypeCheckers = None  # noqa: F821

    assert Pearl(1, 1).lustre == 1.0
    with pytest.raises(InvalidValueError, match="radius"):
        Pearl(-1.0)
    with pytest.raises(InvalidValueError, match="lustre"):
        Pearl(1.0, 2.0)


def test_arguments_are_checked_by_place_and_by_name():
    @checked
    def strung(
        bead: Annotated[Bead, Fix("chain.beads[0]")], /, count: Annotated[int, Whole(1, 9)] = 2, *rest: float,
        pitch: Length = 1.0, table: npt.ArrayLike = (), **options: float,
    ) -> Any:  # fmt: skip
        """Kept."""
        return bead, count, rest, pitch, table, options

    one = Bead(1.0)
    assert strung(one, 3.0, True, pitch=2, table=[np.nan], more=True) == (
        one,
        3,
        (True,),
        2.0,
        [np.nan],
        {"more": True},
    )
    assert strung(one) == (one, 2, (), 1.0, (), {})
    assert strung.__doc__ == "Kept."
    with pytest.raises(InvalidValueError, match=r"bead = 1: a Bead is needed. Fix: chain.beads\[0\]"):
        strung(1)
    with pytest.raises(InvalidValueError, match="count = 10"):
        strung(one, 10)
    with pytest.raises(InvalidValueError, match="pitch = -1"):
        strung(one, pitch=-1)
    with pytest.raises(TypeError, match="missing"):
        strung()


def test_an_argument_of_a_method():
    class Box:
        @classmethod
        @checked
        def of(cls, side: Length) -> Any:
            return cls, side

        @checked
        def larger(self, factor: Length) -> float:
            return factor

    assert Box.of(2) == (Box, 2.0)
    assert Box().larger(factor=3) == 3.0
    with pytest.raises(InvalidValueError, match="factor"):
        Box().larger(0)
