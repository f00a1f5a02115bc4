"""Random numbers that can be drawn one sample at a time, without changing a state in place, or for a whole recording: the same numbers.

They come in blocks; block b of a stream is made from the stream's key and b alone. A state is the key, the number of samples drawn so
far and the present block, so a step can be tried and taken back.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

BLOCK = 4096

Draw = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def gaussian(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Standard normal numbers."""
    return rng.standard_normal(shape)


def uniform(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Numbers evenly spread over [0, 1)."""
    return rng.random(shape)


def new_key(rng: np.random.Generator) -> int:
    """A key for a stream of its own."""
    return int(rng.integers(2**63))


@dataclass(frozen=True)
class Stream:
    """A position in a stream of random numbers."""

    key: int
    drawn: int = 0
    block: np.ndarray | None = None

    def next(self, shape: tuple[int, ...], draw: Draw) -> tuple["Stream", np.ndarray]:
        """One number of each of `shape` = () or (T,), and the stream after it."""
        number, i = divmod(self.drawn, BLOCK)
        block = _block(self.key, number, shape, draw) if i == 0 else self.block
        return replace(self, drawn=self.drawn + 1, block=block), block[..., i]


def whole(key: int, shape: tuple[int, ...], draw: Draw) -> np.ndarray:
    """The first shape[-1] numbers of a stream, shape (N,) or (T, N): the same as from `Stream.next`."""
    blocks = [_block(key, number, shape[:-1], draw) for number in range(-(-shape[-1] // BLOCK))]
    return np.concatenate(blocks, axis=-1)[..., : shape[-1]]


def _block(key: int, number: int, shape: tuple[int, ...], draw: Draw) -> np.ndarray:
    return draw(np.random.default_rng([key, number]), (*shape, BLOCK))
