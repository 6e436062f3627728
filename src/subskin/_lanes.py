"""Eight numbers side by side in compiled loops: each stands in one of eight lanes, and all are reckoned with at once.

Numba makes vectors of loops that it can see through; sums that run over some other index go through memory then, or are
added up across a vector each time. Numbers named here stay in registers. A function that takes and gives them is
written as for one number, and takes one as well; what differs from lane to lane is asked with `where`. Without a
compiler the same names are NumPy's arrays.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.core.cgutils import get_or_insert_function
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model, type_callable

__all__ = [
    "EIGHT",
    "alike",
    "answers",
    "eight",
    "fetch",
    "first_of",
    "nought",
    "one_of",
    "put",
    "root",
    "total",
    "where",
]

EIGHT = 8
_RECKONED = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul", operator.truediv: "fdiv"}
_RECKONED |= {operator.iadd: "fadd", operator.isub: "fsub", operator.imul: "fmul"}
_COMPARED = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
_JOINED = {operator.and_: "and_", operator.or_: "or_"}
_INDEX = ir.IntType(32)


def eight(array: Any, at: int) -> Any:
    """Eight numbers of an array as it lies in memory, of which `at` is the first."""
    return array.reshape(-1)[at : at + EIGHT].copy()


def put(array: Any, at: int, lanes: Any) -> None:
    """Write eight numbers into an array as it lies in memory, from `at` on."""
    array.reshape(-1)[at : at + EIGHT] = lanes


def fetch(array: Any, at: int) -> None:
    """Ask for the part of an array in which number `at` stands, for it is wanted soon."""


def alike(number: Any) -> Any:
    """One number in all eight."""
    return np.full(EIGHT, number)


def nought(like: Any) -> Any:
    """Zero, or eight of them, of the kind of `like`."""
    return np.zeros_like(like)


def answers(asked: Any) -> int:
    """The lanes in which the answer is yes, as bits of a number."""
    return int(np.sum(np.atleast_1d(asked) << np.arange(np.size(asked))))


def one_of(lanes: Any, lane: int) -> Any:
    """The number in one lane."""
    return lanes[lane]


def first_of(answered: int) -> int:
    """The first lane of those that bits name; of none: 64."""
    return (answered & -answered).bit_length() - 1 if answered else 64


def total(lanes: Any) -> Any:
    """The sum of all eight."""
    four = lanes[:4] + lanes[4:]
    two = four[:2] + four[2:]
    return two[0] + two[1]


def root(lanes: Any) -> Any:
    """The square root of each."""
    return np.sqrt(lanes)


def where(asked: Any, this: Any, that: Any) -> Any:
    """Take `this` in the lanes in which the answer is yes, `that` in the others."""
    return np.where(asked, this, that)


class Lanes(types.Type):
    """Numba's type of eight floats, or of eight answers."""

    def __init__(self, number: types.Type) -> None:
        self.number = number
        super().__init__(name=f"Lanes({number})")


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Lanes) -> None:
        super().__init__(manager, kind, ir.VectorType(manager.lookup(kind.number).get_value_type(), EIGHT))


_ASKED = Lanes(types.boolean)


def _same(one: Any, other: Any) -> Lanes | None:
    """The kind of lanes in a pair of which one may be a number for all of them."""
    kinds = {kind for kind in (one, other) if isinstance(kind, Lanes)}
    numbers = all(isinstance(kind, Lanes | types.Number) for kind in (one, other))
    return kinds.pop() if len(kinds) == 1 and numbers else None


def _spread(builder: Any, value: Any) -> Any:
    """Lanes as they are; a number in each of eight."""
    if isinstance(value.type, ir.VectorType):
        return value
    first = builder.insert_element(ir.Constant(ir.VectorType(value.type, EIGHT), ir.Undefined), value, _INDEX(0))
    return _picked(builder, first, [0] * EIGHT)


def _picked(builder: Any, vector: Any, which: list[int]) -> Any:
    """Some lanes of a vector."""
    return builder.shuffle_vector(vector, vector, ir.Constant(ir.VectorType(_INDEX, len(which)), which))


def _operator(symbol: Any, name: str) -> None:
    """Let Numba type and compile an operator of two."""
    asks, joins = symbol in _COMPARED, symbol in _JOINED

    @infer_global(symbol)
    class Operator(AbstractTemplate):
        def generic(self, args: tuple[Any, ...], keywords: dict[str, Any]) -> Any:
            kind = _same(*args) if len(args) == 2 else None
            if kind is None or (kind == _ASKED) != joins:
                return None
            given = (one if isinstance(one, Lanes) else kind.number for one in args)
            return signature(_ASKED if asks else kind, *given)

    def lower(context: Any, builder: Any, made: Any, args: tuple[Any, Any]) -> Any:
        pair = (_spread(builder, value) for value in args)
        return builder.fcmp_ordered(name, *pair) if asks else getattr(builder, name)(*pair)

    for kinds in ((Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)):
        lower_builtin(symbol, *kinds)(lower)


for _symbol, _name in (_RECKONED | _COMPARED | _JOINED).items():
    _operator(_symbol, _name)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args: tuple[Any, ...], keywords: dict[str, Any]) -> Any:
        return signature(args[0], args[0]) if isinstance(args[0], Lanes) else None


@lower_builtin(operator.neg, Lanes)
def _negative(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return builder.fneg(args[0])


@type_callable(eight)
def _type_of_eight(context: Any) -> Any:
    return lambda array, at: Lanes(array.dtype)


@type_callable(put)
def _type_of_put(context: Any) -> Any:
    return lambda array, at, lanes: types.none


@type_callable(fetch)
def _type_of_fetch(context: Any) -> Any:
    return lambda array, at: types.none


@type_callable(alike)
def _type_of_alike(context: Any) -> Any:
    return lambda number: Lanes(number)  # noqa: PLW0108  (Numba asks for its parameters)


@type_callable(nought)
def _type_of_nought(context: Any) -> Any:
    return lambda like: like


@type_callable(answers)
def _type_of_answers(context: Any) -> Any:
    return lambda asked: types.intp if asked in (_ASKED, types.boolean) else None


@type_callable(one_of)
def _type_of_one_of(context: Any) -> Any:
    return lambda lanes, lane: lanes.number


@type_callable(first_of)
def _type_of_first_of(context: Any) -> Any:
    return lambda answered: types.intp


@type_callable(total)
def _type_of_total(context: Any) -> Any:
    return lambda lanes: lanes.number


@type_callable(root)
def _type_of_root(context: Any) -> Any:
    return lambda lanes: lanes


@infer_global(where)
class _Where(AbstractTemplate):
    def generic(self, args: tuple[Any, ...], keywords: dict[str, Any]) -> Any:
        if args[0] == types.boolean:
            return signature(types.float64, types.boolean, types.float64, types.float64)
        kind = _same(*args[1:])
        return kind and signature(kind, _ASKED, *(one if isinstance(one, Lanes) else kind.number for one in args[1:]))


def _begin(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> tuple[Any, int]:
    """Where eight numbers of an array begin, and how each of them is aligned."""
    array = context.make_array(made.args[0])(context, builder, args[0])
    number = context.get_data_type(made.args[0].dtype)
    at = builder.gep(array.data, [args[1]])
    return builder.bitcast(at, ir.VectorType(number, EIGHT).as_pointer()), context.get_abi_sizeof(number)


@lower_builtin(eight, types.Array, types.Integer)
def _eight(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    begin, aligned = _begin(context, builder, made, args)
    return builder.load(begin, align=aligned)


@lower_builtin(put, types.Array, types.Integer, Lanes)
def _put(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    begin, aligned = _begin(context, builder, made, args)
    builder.store(args[2], begin, align=aligned)
    return context.get_dummy_value()


@lower_builtin(fetch, types.Array, types.Integer)
def _fetch(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    array = context.make_array(made.args[0])(context, builder, args[0])
    at = builder.bitcast(builder.gep(array.data, [args[1]]), ir.IntType(8).as_pointer())
    kind = ir.FunctionType(ir.VoidType(), [at.type, _INDEX, _INDEX, _INDEX])
    call = get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
    builder.call(call, [at, *(_INDEX(value) for value in (0, 3, 1))])  # to be read, to be kept near, data
    return context.get_dummy_value()


@lower_builtin(alike, types.Float)
def _alike(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return _spread(builder, args[0])


@lower_builtin(nought, Lanes)
@lower_builtin(nought, types.Float)
def _nought(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return ir.Constant(args[0].type, None)


@lower_builtin(answers, types.Boolean)
def _answer(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return builder.zext(args[0], context.get_value_type(made.return_type))


@lower_builtin(answers, Lanes)
def _answers(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return builder.zext(builder.bitcast(args[0], ir.IntType(EIGHT)), context.get_value_type(made.return_type))


@lower_builtin(one_of, Lanes, types.Integer)
def _one_of(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return builder.extract_element(*args)


@lower_builtin(first_of, types.Integer)
def _first_of(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    return builder.cttz(args[0], ir.Constant(ir.IntType(1), 0))


@lower_builtin(total, Lanes)
def _total(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    part, size = args[0], EIGHT
    while size > 1:
        size //= 2
        halves = (_picked(builder, part, list(range(begin, begin + size))) for begin in (0, size))
        part = builder.fadd(*halves)
    return builder.extract_element(part, _INDEX(0))


@lower_builtin(root, Lanes)
@lower_builtin(root, types.Float)
def _root(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    kind = args[0].type
    many, one = (f"v{EIGHT}", kind.element) if isinstance(kind, ir.VectorType) else ("", kind)
    name = f"llvm.sqrt.{many}f{8 * context.get_abi_sizeof(one)}"
    return builder.call(get_or_insert_function(builder.module, ir.FunctionType(kind, [kind]), name), args)


@lower_builtin(where, types.Boolean, types.Float, types.Float)
@lower_builtin(where, Lanes, Lanes, Lanes)
@lower_builtin(where, Lanes, types.Number, Lanes)
@lower_builtin(where, Lanes, Lanes, types.Number)
def _where(context: Any, builder: Any, made: Any, args: tuple[Any, ...]) -> Any:
    this, that = args[1:] if made.args[0] == types.boolean else (_spread(builder, value) for value in args[1:])
    return builder.select(args[0], this, that)
