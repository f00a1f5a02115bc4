"""One entry of `findings` in findings.json, whichever part of the diagnosis found it: search, telemetry, array or static scan."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from skin_ident.criticism.vocabulary import BY_NAME, where_and_clock


def no_gain(channel: str) -> dict[str, Any]:
    """The `gain` of a finding that is no term of the model: no numbers."""
    return {"held_out_rmse_before": None, "held_out_rmse_after": None, "ci95": None, "channel": channel, "unit": "N"}


def alternative(cause: str, where: str, short_by: float = 0.0, fitted: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """One of `alternatives`: another name for the same finding, by how much less it explains (squared whitened units), and its parameters
    and forms where it was `fitted`."""
    return {"cause": cause, **where_and_clock(where), "explains_less_by": float(short_by), **(fitted or {})}


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A cause at a place (of the catalogue) with its evidence. `means` and `advice` default to those of its cause. `separating` is the
    experiment that would tell it from its alternatives, `computed` further fields of the entry about that experiment."""

    cause: str
    where: str
    channels: Sequence[str]
    parameters: dict[str, dict[str, Any]]
    evidence: dict[str, Any]
    gain: dict[str, Any]
    alternatives: list[dict[str, Any]] = field(default_factory=list)
    separating: str = ""
    computed: dict[str, Any] = field(default_factory=dict)
    means: str = ""
    advice: str = ""

    @property
    def as_json(self) -> dict[str, Any]:
        """As findings.json holds it."""
        return {
            "cause": self.cause,
            **where_and_clock(self.where),
            "channels": list(self.channels),
            "parameters": self.parameters,
            "evidence": self.evidence,
            "gain": self.gain,
            "alternatives": self.alternatives,
            "separating_experiment": self.separating,
            **self.computed,
            "means": self.means or BY_NAME[self.cause].means,
            "advice": self.advice or BY_NAME[self.cause].act,
        }
