"""Operators that run along every row of an array sample by sample: compiled, or in numpy where there is no compiler."""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.ctypeslib import ndpointer

from skin_models.native import library

FLOATS = ndpointer(float, flags="C")


def compiled(name: str, operator: str, *more: Any) -> Callable | None:
    """`operator(y, z, rows, samples, …)` of `data/native/<name>.c`, with `more` types of arguments; None without a compiler."""
    native = library(name)
    if native is None:
        return None
    found = getattr(native, operator)
    found.argtypes, found.restype = (FLOATS, FLOATS, ctypes.c_int64, ctypes.c_int64, *more), None
    return found


def by_rows(y: np.ndarray, fast: Callable | None, plain: Callable, *arguments: Any) -> np.ndarray:
    """z (..., N) of y, by the compiled operator `fast`, or where that is None by `plain(row, …)` on every row (N,)."""
    rows = np.ascontiguousarray(y, float).reshape(-1, y.shape[-1])
    if fast is None:
        z = np.array([plain(row, *arguments) for row in rows])
    else:
        z = np.empty(rows.shape)
        fast(rows, z, *rows.shape, *arguments)
    return z.reshape(y.shape)
