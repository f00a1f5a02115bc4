"""A claim: the assertion that a cause gains, to be compared with what hardware may do instead."""

from dataclasses import dataclass

from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model


@dataclass(frozen=True)
class Claim:
    """The claim that the model `after` gains over `before` by the cause and place `key`; both models were fitted to the sessions
    `train`."""

    key: Key
    gain: Gain
    before: Model
    after: Model
    train: list[Session]

    @property
    def cause(self) -> str:
        """The cause, without its place."""
        return self.key[0]

    @property
    def channel(self) -> str:
        """The channel that gains most."""
        return self.gain.channel

    @property
    def driven(self) -> bool:
        """Whether a force drives the test, so that no depth is read."""
        return self.train[0].drive is not None
