"""Sums of windows that sensors see of one line of numbers, in registers.

Numba's loops store what they have after each sensor, or few: with four at a time an image of 16 x 16 sensors took a
third longer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

from .hats import AT_ONCE, LANES, REGISTERS

_Single = npt.NDArray[np.float32]


def windows(line: _Single, start: npt.NDArray[np.int64], pull: _Single, at: int, registers: int, out: _Single) -> None:
    """Put pull (n,) times line[start + at + k] into out[k], for k from 0 to `LANES` times 1 to `REGISTERS`.

    n is a multiple of `AT_ONCE`.
    """
    for k in range(LANES * registers):
        out[k] = pull @ line[start + at + k]


@overload(windows)
def _compiled_windows(line, start, pull, at, registers, out):  # type: ignore[no-untyped-def]
    def run(line, start, pull, at, registers, out):  # type: ignore[no-untyped-def]
        _sums(line, start, pull, at, registers, out)  # type: ignore[call-arg]

    return run


@intrinsic
def _sums(typing: Any, line: Any, start: Any, pull: Any, at: Any, registers: Any, out: Any) -> Any:
    whole, short, register = ir.IntType(64), ir.IntType(32), ir.VectorType(ir.FloatType(), LANES)
    zero, none, room = ir.Constant(whole, 0), ir.Constant(register, None), cgutils.alloca_once_value

    def register_at(builder: Any, numbers: Any, k: int) -> Any:
        return builder.bitcast(builder.gep(numbers, [ir.Constant(whole, k * LANES)]), register.as_pointer())

    def build(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        arrays = [context.make_array(signature.args[i])(context, builder, given[i]) for i in (0, 1, 2, 5)]
        numbers, starts, pulls, sums = (array.data for array in arrays)
        count, first = builder.extract_value(arrays[2].shape, 0), builder.gep(numbers, [given[3]])
        after = builder.append_basic_block("after")
        cases = builder.switch(given[4], after)
        for many in range(1, REGISTERS + 1):
            case = builder.append_basic_block("case")
            cases.add_case(ir.Constant(whole, many), case)
            builder.position_at_end(case)
            # sums of every second sensor wait for each other half as often
            totals = [[room(builder, none) for _ in range(many)] for _ in range(AT_ONCE)]  # type: ignore[no-untyped-call]
            with cgutils.for_range_slice(builder, zero, count, ir.Constant(whole, AT_ONCE), whole) as (index, _):
                for apart, total in enumerate(totals):
                    sensor = builder.add(index, ir.Constant(whole, apart))
                    seen = builder.gep(first, [builder.load(builder.gep(starts, [sensor]))])
                    share = builder.load(builder.gep(pulls, [sensor]))
                    share = builder.insert_element(none, share, ir.Constant(short, 0))
                    share = builder.shuffle_vector(share, share, ir.Constant(ir.VectorType(short, LANES), None))
                    for k, part in enumerate(total):
                        there = builder.load(register_at(builder, seen, k), align=4)
                        more = builder.fmul(there, share, flags=("fast",))
                        builder.store(builder.fadd(builder.load(part), more, flags=("fast",)), part)
            for k, parts in enumerate(zip(*totals, strict=True)):
                one, two = (builder.load(part) for part in parts)
                builder.store(builder.fadd(one, two), register_at(builder, sums, k), align=4)
            builder.branch(after)
        builder.position_at_end(after)
        return context.get_dummy_value()

    return types.void(line, start, pull, types.intp, types.intp, out), build
