"""How every function of the kernel is compiled: cached on disk, IEEE arithmetic (no fastmath: results must not depend on the
optimiser's mood), division by zero gives infinity instead of a branch to an exception.

Nothing of it allocates, so arrays are not counted (`_nrt=False`; whoever calls keeps them alive): the counting of every array at every
inlined function, atomic and between the arithmetic, took two fifths of the kernel's time. numba refuses an allocation in such a function.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NoReturn, TypeVar

from numba import njit
from numba.np import linalg

from sim_backend.memory import compile_cache

Function = TypeVar("Function", bound=Callable[..., Any])


def _load_without_blas() -> None:
    """numba asks for BLAS by importing scipy.linalg, as long as all else it loads. Nothing here multiplies matrices: it may find none.

    The answer only chooses how a compiled `numpy.kron` multiplies.
    """

    def absent() -> NoReturn:
        raise ImportError("not needed")

    ask = linalg.ensure_blas
    linalg.ensure_blas = absent
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ask


compile_cache.prepare()  # before anything is compiled
_load_without_blas()


def compiled(function: Function) -> Function:
    """Decorator of the kernel's functions."""
    return njit(cache=True, error_model="numpy", forceinline=True, _nrt=False)(function)  # type: ignore[no-any-return]


def released(function: Function) -> Function:
    """The same for what runs long: free of the interpreter lock, so that threads run beside each other; called, not inlined."""
    return njit(cache=True, error_model="numpy", nogil=True, _nrt=False)(function)  # type: ignore[no-any-return]
