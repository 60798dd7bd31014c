"""Branching policy search over a `FrettingBatch`: reads from top to bottom.

Hands play in groups. All of a group begin a window of some ticks in the same state; one plays as
the policy says, the others add a constant offset to its actions, in opposite pairs. What an offset
did is judged against the mean of its group in the same ticks, so no critic is needed, and an
offset that lasts moves a finger where noise that changes with every tick only shakes it. The
policy then takes a clipped step (Schulman et al., Proximal Policy Optimization Algorithms, arXiv
1707.06347, equation 7, with group means as baseline as in Shao et al., DeepSeekMath, arXiv
2402.03300, section 4.1), and the group goes on from where the policy alone has led.
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
class BranchingConfig:
    """Settings of the learner.

    Attributes:
        steps: Control ticks to learn from, over all hands.
        copies: Hands in a group, even; the batch is a whole number of groups.
        ticks: Longest window, in ticks; the shortest is half of it.
        epochs: Passes over the ticks of a window.
        minibatch: Samples in a gradient step.
        learning_rate: Of Adam, at the beginning; it falls to a twentieth.
        discount: Gamma.
        deviation: Of the offsets, at the beginning and at the end.
        clip: Range of the probability ratio.
        effort: Price of a mean square action of 1.
        hidden: Units in each of the two hidden layers.
        seed: Of weights, episodes, offsets and minibatches.
    """

    steps: int = 2_500_000
    copies: int = 16
    ticks: int = 16
    epochs: int = 2
    minibatch: int = 2048
    learning_rate: float = 2e-4
    discount: float = 0.93
    deviation: tuple[float, float] = (0.1, 0.06)
    clip: float = 0.2
    effort: float = 0.01
    hidden: int = 256
    seed: int = 0


class Branching:
    """A learner and its state.

    Args:
        batch: The environments; their random generator is seeded.
        config: Settings.
    """

    def __init__(self, batch: FrettingBatch, config: BranchingConfig) -> None:
        self.batch, self.config, self.steps, self._begun = batch, config, 0, False
        torch.manual_seed(config.seed)
        self.rng = torch.Generator().manual_seed(config.seed)
        batch.rng = np.random.default_rng(config.seed)
        task = batch.task
        self.actor = network(batch.observation_size, config.hidden, batch.n_actions)
        with torch.no_grad():  # the first actions hold the hand where it begins
            list(self.actor.parameters())[-1].copy_(torch.from_numpy(task.resting_action()))
        self.credit = torch.tensor(task.credit, dtype=torch.float32)
        groups = torch.from_numpy(task.groups)
        self.members = nn.functional.one_hot(groups, len(self.credit)).float()
        self.optimiser = torch.optim.Adam(self.actor.parameters(), config.learning_rate, eps=1e-5)
        self.moments = Moments.of(batch.observation_size)
        self.spread = torch.ones(len(self.credit))
        self.leaders = np.arange(batch.n_envs) // config.copies * config.copies

    def learn(self) -> Iterator[Progress]:
        """Learn until the steps are done; one report for each update."""
        if not self._begun:
            self.batch.reset()
            self.batch.follow(self.leaders)
            self._begun = True
        while self.steps < self.config.steps:
            begin = time.perf_counter()
            done = self.steps / self.config.steps
            rate = self.config.learning_rate * (1.0 - 0.95 * done)
            self.optimiser.param_groups[0]["lr"] = rate
            first, last = self.config.deviation
            samples, progress = self._window(first + done * (last - first))
            self._update(samples)
            n_steps = round(progress["ticks"]) * self.batch.n_envs
            self.steps += n_steps
            reward = progress.pop("reward")
            progress.pop("ticks")
            yield Progress(
                self.steps, n_steps / (time.perf_counter() - begin), reward, terms=progress
            )

    def policy(self) -> Policy:
        """The network as it is now, for playing."""
        return exported(self.actor, self.moments, self.batch.config)

    def state(self) -> dict[str, Any]:
        """All that learning goes on from, the environments' state too."""
        return {
            "actor": self.actor.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "moments": self.moments.state(),
            "spread": self.spread,
            "steps": self.steps,
            "rng": self.rng.get_state(),
            "batch": self.batch.state(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from what `state` gave."""
        self.actor.load_state_dict(state["actor"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.moments.restore(state["moments"])
        self.spread, self.steps = state["spread"], state["steps"]
        self.rng.set_state(state["rng"])
        self.batch.restore(state["batch"])
        self._begun = True

    def _offsets(self, deviation: float) -> torch.Tensor:
        """Offsets (N, A): in each group none first, then opposite pairs."""
        config, n_groups = self.config, self.batch.n_envs // self.config.copies
        shape = (n_groups, config.copies // 2, self.batch.n_actions)
        half = deviation * torch.randn(shape, generator=self.rng)
        half[:, 0] = 0.0
        return torch.stack([half, -half], dim=2).flatten(0, 2)

    @torch.no_grad()
    def _window(self, deviation: float) -> tuple[dict[str, torch.Tensor], dict[str, float]]:
        """Play one window everywhere; samples with advantages, and means over the leaders."""
        batch, config = self.batch, self.config
        n_ticks = int(torch.randint(config.ticks // 2, config.ticks + 1, (), generator=self.rng))
        offsets = self._offsets(deviation)
        leads = np.unique(self.leaders)
        rows: list[tuple[torch.Tensor, ...]] = []
        sums: dict[str, float] = {}
        raw, seen = [], batch.observe()
        for _ in range(n_ticks):
            observed = torch.from_numpy(self.moments.normalised(seen))
            mean = self.actor(observed)
            action = mean + offsets
            raw.append(seen)
            seen, reward, ended, terms = batch.step(action.numpy())
            noise = Normal(mean, deviation)
            parts = torch.from_numpy(batch.parts.astype(np.float32))
            effort = config.effort * action.square() @ self.members / batch.n_actions
            rows.append((
                observed, action, noise.log_prob(action) @ self.members,
                parts @ self.credit.T - effort, torch.from_numpy(ended),
            ))  # fmt: skip
            for name, values in {"reward": reward, **terms}.items():
                sums[name] = sums.get(name, 0.0) + float(values[leads].mean()) / n_ticks
            if ended.any():
                batch.reset(ended[self.leaders])
                batch.follow(self.leaders, ended | ended[self.leaders])
                seen = batch.observe()
        batch.follow(self.leaders)
        self.moments.count_in(np.concatenate(raw))
        observed, action, log_prob, reward, ended = (
            torch.stack(column) for column in zip(*rows, strict=True)
        )
        samples = {"seen": observed, "action": action, "log_prob": log_prob,
                   "advantage": self._advantages(reward, ended)}  # fmt: skip
        self._deviation = deviation
        flat = {name: column.flatten(0, 1) for name, column in samples.items()}
        return flat, {**sums, "ticks": float(n_ticks)}

    def _advantages(self, reward: torch.Tensor, ended: torch.Tensor) -> torch.Tensor:
        """Discounted sums (T, N, G) to the window's end, less the mean of the group."""
        running, out = torch.zeros(reward.shape[1:]), torch.empty_like(reward)
        for tick in range(len(reward) - 1, -1, -1):
            running = reward[tick] + self.config.discount * ~ended[tick][:, None] * running
            out[tick] = running
        grouped = out.unflatten(1, (-1, self.config.copies))
        out = (grouped - grouped.mean(dim=2, keepdim=True)).flatten(1, 2)
        spread = out.flatten(0, 1).std(dim=0)
        self.spread = spread if self.steps == 0 else 0.95 * self.spread + 0.05 * spread
        return out / (self.spread + 1e-8)

    def _update(self, samples: dict[str, torch.Tensor]) -> None:
        config, size = self.config, len(samples["advantage"])
        for _ in range(config.epochs):
            order = torch.randperm(size, generator=self.rng)
            for begin in range(0, size, config.minibatch):
                part = {name: values[order[begin : begin + config.minibatch]]
                        for name, values in samples.items()}  # fmt: skip
                noise = Normal(self.actor(part["seen"]), self._deviation)
                change = noise.log_prob(part["action"]) @ self.members - part["log_prob"]
                ratio, advantage = change.exp(), part["advantage"]
                clipped = ratio.clamp(1 - config.clip, 1 + config.clip)
                gain = torch.minimum(ratio * advantage, clipped * advantage).sum(1).mean()
                self.optimiser.zero_grad()
                (-gain).backward()
                nn.utils.clip_grad_norm_(self.actor.parameters(), 0.5)
                self.optimiser.step()
