"""Proximal policy optimisation over a `FrettingBatch`: reads from top to bottom.

After Schulman et al., Proximal Policy Optimization Algorithms (arXiv 1707.06347, equations 7, 11
and 12), with a running normalisation of observations and a learning rate that falls to zero.
Needs PyTorch (extra `train`).
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.distributions import Normal

from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.learner import Progress
from roboguitarist.fretting.network import Moments, exported, network
from roboguitarist.fretting.policy import Policy


@dataclass(frozen=True)
class PPOConfig:
    """Settings of the learner.

    Attributes:
        steps: Control ticks to learn from, over all environments.
        ticks: Ticks of each environment between two updates.
        epochs: Passes over them in an update.
        minibatch: Samples in a gradient step.
        learning_rate: Of Adam, at the beginning.
        warm_up: Updates in which only the critic learns: before it knows what the plan alone is
            worth, advantages say nothing about actions.
        discount, trace: Gamma and lambda of generalised advantage estimation.
        clip: Range of the probability ratio.
        entropy: Coefficient of the entropy bonus.
        effort: Price of a mean square action of 1, for tasks in which actions are corrections:
            no more correction than helps.
        deviation: Of the actions at the beginning.
        hidden: Units in each of the two hidden layers.
        seed: Of weights, episodes, noise and minibatches.
    """

    steps: int = 3_000_000
    ticks: int = 24
    epochs: int = 4
    minibatch: int = 768
    learning_rate: float = 3e-4
    warm_up: int = 20
    discount: float = 0.93
    trace: float = 0.9
    clip: float = 0.2
    entropy: float = 0.0005
    effort: float = 0.03
    deviation: float = 0.25
    hidden: int = 256
    seed: int = 0


class PPO:
    """A learner and its state.

    Args:
        batch: The environments; their random generator is seeded.
        config: Settings.
    """

    def __init__(self, batch: FrettingBatch, config: PPOConfig) -> None:
        self.batch, self.config, self.steps, self._begun = batch, config, 0, False
        torch.manual_seed(config.seed)
        self.rng = torch.Generator().manual_seed(config.seed)
        batch.rng = np.random.default_rng(config.seed)
        seen, acted = batch.observation_size, batch.n_actions
        self.actor = network(seen, config.hidden, acted)
        with torch.no_grad():  # the first actions hold the hand where it begins
            list(self.actor.parameters())[-1].copy_(torch.from_numpy(batch.task.resting_action()))
        self.critic = network(seen, config.hidden, batch.task.credit.shape[1], 1.0)
        self.credit = torch.tensor(batch.task.credit, dtype=torch.float32)
        self.members = torch.nn.functional.one_hot(
            torch.from_numpy(batch.task.groups), len(self.credit)
        ).float()
        self.log_deviation = nn.Parameter(torch.full((acted,), float(np.log(config.deviation))))
        self.groups = (
            [*self.actor.parameters(), self.log_deviation],
            list(self.critic.parameters()),
        )
        self.optimiser = torch.optim.Adam(
            [*self.groups[0], *self.groups[1]], config.learning_rate, eps=1e-5
        )
        self.moments = Moments.of(seen)

    def learn(self) -> Iterator[Progress]:
        """Learn until the steps are done; one report for each update."""
        seen = self.batch.observe() if self._begun else self.batch.reset()
        self._begun = True
        while self.steps < self.config.steps:
            begin = time.perf_counter()
            self._anneal()
            rollout, seen, reward, terms = self._roll(seen)
            self._update(rollout)
            n_steps = self.config.ticks * self.batch.n_envs
            self.steps += n_steps
            yield Progress(self.steps, n_steps / (time.perf_counter() - begin), reward, terms)

    def policy(self) -> Policy:
        """The network as it is now, for playing."""
        return exported(self.actor, self.moments, self.batch.config)

    def state(self) -> dict[str, Any]:
        """All that learning goes on from, the environments' state too."""
        return {
            "actor": self.actor.state_dict(),
            "critic": self.critic.state_dict(),
            "log_deviation": self.log_deviation.data,
            "optimiser": self.optimiser.state_dict(),
            "moments": self.moments.state(),
            "steps": self.steps,
            "rng": self.rng.get_state(),
            "batch": self.batch.state(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from what `state` gave."""
        self.actor.load_state_dict(state["actor"])
        self.critic.load_state_dict(state["critic"])
        self.log_deviation.data.copy_(state["log_deviation"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.moments.restore(state["moments"])
        self.steps = state["steps"]
        self.rng.set_state(state["rng"])
        self.batch.restore(state["batch"])
        self._begun = True

    def _anneal(self) -> None:
        left = 1.0 - self.steps / self.config.steps
        self.optimiser.param_groups[0]["lr"] = self.config.learning_rate * left

    def _seen(self, observation: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(self.moments.normalised(observation))

    @torch.no_grad()
    def _roll(
        self, seen: np.ndarray
    ) -> tuple[dict[str, torch.Tensor], np.ndarray, float, dict[str, float]]:
        """Play `ticks` ticks everywhere; samples with their advantages and returns."""
        batch, config = self.batch, self.config
        rows: list[tuple[torch.Tensor, ...]] = []
        sums: dict[str, float] = {}
        raw = []
        for _ in range(config.ticks):
            observed = self._seen(seen)
            noise = Normal(self.actor(observed), self.log_deviation.exp())
            action = torch.normal(noise.mean, noise.stddev, generator=self.rng)
            raw.append(seen)
            after, reward, ended, terms = batch.step(action.numpy())
            following = self.critic(self._seen(after))
            rows.append((
                observed, action, noise.log_prob(action) @ self.members, self.critic(observed),
                following, self._priced(batch.parts, action), torch.from_numpy(ended),
            ))  # fmt: skip
            for name, values in {"reward": reward, **terms}.items():
                sums[name] = sums.get(name, 0.0) + float(values.mean()) / config.ticks
            seen = batch.reset(ended) if ended.any() else after
        self.moments.count_in(np.concatenate(raw))
        columns = [torch.stack(column) for column in zip(*rows, strict=True)]
        observed, action, log_prob, value, following, reward, ended = columns
        advantage = self._advantages(value, following, reward, ended)
        samples = {"seen": observed, "action": action, "log_prob": log_prob,
                   "advantage": advantage @ self.credit.T,
                   "return": advantage + value}  # fmt: skip
        flat = {name: column.flatten(0, 1) for name, column in samples.items()}
        return flat, seen, sums.pop("reward"), sums

    def _priced(self, parts: np.ndarray, action: torch.Tensor) -> torch.Tensor:
        """Parts (N, R) of the reward, each less the effort of the group of the same number."""
        effort = action.square() @ self.members / action.shape[1]
        return torch.from_numpy(parts.astype(np.float32)) - self.config.effort * effort

    def _advantages(
        self,
        value: torch.Tensor,
        following: torch.Tensor,
        reward: torch.Tensor,
        ended: torch.Tensor,
    ) -> torch.Tensor:
        """Generalised advantage estimates (T, N, R); an end is a cut, its value goes on."""
        config, running = self.config, torch.zeros(value.shape[1:])
        # In units in which a reward of 1 for ever is worth 1.
        surprise = (1 - config.discount) * reward + config.discount * following - value
        out = torch.empty_like(value)
        for tick in range(len(value) - 1, -1, -1):
            goes_on = ~ended[tick][:, None]
            running = surprise[tick] + config.discount * config.trace * goes_on * running
            out[tick] = running
        return out

    def _update(self, rollout: dict[str, torch.Tensor]) -> None:
        config, size = self.config, len(rollout["advantage"])
        for _ in range(config.epochs):
            order = torch.randperm(size, generator=self.rng)
            for begin in range(0, size, config.minibatch):
                part = {name: values[order[begin : begin + config.minibatch]]
                        for name, values in rollout.items()}  # fmt: skip
                self.optimiser.zero_grad()
                self._loss(part).backward()
                for group in self.groups:  # apart, lest a wrong critic still the actor
                    nn.utils.clip_grad_norm_(group, 0.5)
                self.optimiser.step()

    def _loss(self, part: dict[str, torch.Tensor]) -> torch.Tensor:
        config, advantage = self.config, part["advantage"]
        advantage = (advantage - advantage.mean(0)) / (advantage.std(0) + 1e-8)
        noise = Normal(self.actor(part["seen"]), self.log_deviation.exp())
        ratio = (noise.log_prob(part["action"]) @ self.members - part["log_prob"]).exp()
        clipped = ratio.clamp(1 - config.clip, 1 + config.clip)
        gain = torch.minimum(ratio * advantage, clipped * advantage).sum(1).mean()
        error = (self.critic(part["seen"]) - part["return"]).square().sum(1).mean()
        if self.steps < config.warm_up * config.ticks * self.batch.n_envs:
            return error
        return error - gain - config.entropy * noise.entropy().sum(1).mean()
