"""States of many things at once: nested tuples (and frozen dataclasses) of arrays whose last axis counts the things."""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def mapped(act: Callable[..., np.ndarray], *trees: Any) -> Any:
    """`act` on the arrays at the same place of every tree; None stays None."""
    first = trees[0]
    if first is None:
        return None
    if isinstance(first, tuple):
        return tuple(mapped(act, *parts) for parts in zip(*trees, strict=True))
    if is_dataclass(first):
        return type(first)(*(mapped(act, *(getattr(tree, f.name) for tree in trees)) for f in fields(first)))
    return act(*trees)


def chosen(tree: Any, index: np.ndarray) -> Any:
    """The things at `index` alone."""
    return mapped(lambda leaf: leaf[..., index], tree)


def joined(one: Any, other: Any) -> Any:
    """The things of both trees."""
    return mapped(lambda a, b: np.concatenate([a, b], axis=-1), one, other)
