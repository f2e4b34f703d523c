"""How every function of the kernel is compiled: cached on disk, IEEE arithmetic (no fastmath: results must not depend on the
optimiser's mood), division by zero gives infinity instead of a branch to an exception.

Nothing of it allocates, so arrays are not counted (`_nrt=False`; whoever calls keeps them alive): the counting of every array at every
inlined function, atomic and between the arithmetic, took two fifths of the kernel's time. numba refuses an allocation in such a function.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Decorator of the kernel's functions."""
    return njit(cache=True, error_model="numpy", forceinline=True, _nrt=False)(function)  # type: ignore[no-any-return]


def released(function: Function) -> Function:
    """The same for what runs long: free of the interpreter lock, so that threads run beside each other; called, not inlined."""
    return njit(cache=True, error_model="numpy", nogil=True, _nrt=False)(function)  # type: ignore[no-any-return]
