"""How every function of the kernel is compiled: cached on disk, IEEE arithmetic (no fastmath: results must not depend on the
optimiser's mood), division by zero gives infinity instead of a branch to an exception."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Decorator of the kernel's functions."""
    return njit(cache=True, error_model="numpy", forceinline=True)(function)  # type: ignore[no-any-return]
