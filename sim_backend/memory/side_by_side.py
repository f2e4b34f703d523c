"""Four numbers at once in one vector register, for what keeps a processor's divider busy longest: the same bits as one after the other,
because IEEE roots and quotients are rounded alike in every lane, in a quarter of the divider's time."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import float64, types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 4
_NUMBERS = ir.VectorType(ir.DoubleType(), LANES)
_TUPLE = types.UniTuple(float64, LANES)


@intrinsic  # type: ignore[untyped-decorator]
def signed_roots(_: Any, drops: Any, smoothing_squared: Any) -> Any:
    """Δ / (Δ² + δ²)^(1/4) of four pressure drops, each as `physics.valve.land_flow` has it."""
    return _TUPLE(_TUPLE, _TUPLE), _signed_roots


def _signed_roots(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    drops, smoothing = (_in_register(builder, cgutils.unpack_tuple(builder, each, LANES)) for each in arguments)
    root = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_NUMBERS, [_NUMBERS]), f"llvm.sqrt.v{LANES}f64")
    sums = builder.fadd(builder.fmul(drops, drops), smoothing)
    flows = builder.fdiv(drops, builder.call(root, [builder.call(root, [sums])]))
    return context.make_tuple(builder, _TUPLE, [builder.extract_element(flows, _lane(number)) for number in range(LANES)])


def _in_register(builder: Any, numbers: Any) -> Any:
    register = ir.Constant(_NUMBERS, ir.Undefined)
    for number, value in enumerate(numbers):
        register = builder.insert_element(register, value, _lane(number))
    return register


def _lane(number: int) -> Any:
    return ir.Constant(ir.IntType(32), number)
