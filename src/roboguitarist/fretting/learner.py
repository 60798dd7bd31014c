"""What every learner can do, whichever library it is made with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

from roboguitarist.fretting.policy import Policy


@dataclass(frozen=True)
class Progress:
    """What an update reports: ticks so far, ticks per second, means over the last rollout.

    Attributes:
        steps: Control ticks learned from so far, over all environments.
        per_s: Of them, per second of the last update.
        reward: Mean reward of a tick.
        terms: Means of the reward's terms.
        losses: What the learner minimises, and whatever else tells how it does, by name.
    """

    steps: int
    per_s: float
    reward: float
    terms: dict[str, float] = field(default_factory=dict)
    losses: dict[str, float] = field(default_factory=dict)


class Learner(Protocol):
    """A learner and its state."""

    @property
    def steps(self) -> int:
        """Control ticks learned from so far."""
        ...

    def learn(self) -> Iterator[Progress]:
        """Learn until the configured steps are done; between two reports the state is whole."""
        ...

    def policy(self) -> Policy:
        """The policy as it is now, for playing."""
        ...

    def state(self) -> dict[str, Any]:
        """All that learning goes on from: numbers, text, arrays and tensors in dictionaries."""
        ...

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from what `state` gave."""
        ...
