"""What the paper's figures compare, and what they show, as far as the paper lets one read it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from roboguitarist import pieces
from roboguitarist.training.settings import Algorithm, TrainConfig, defaults

MONOPHONIC = ("twinkle", "long-long-ago", "fur-elise")
POLYPHONIC = ("happy-birthday", "farewell", "red-river-valley")
EIGHT = pieces.names()[:8]
FREE = (*POLYPHONIC, "chord-transition")
"""Pieces trained with freedom: the paper says so of the first three, and nothing of the last."""
_WITH_RATE = ("substeps", "max_ticks")
"""What follows from the frame rate."""


@dataclass(frozen=True)
class Arm:
    """One thing that a figure compares.

    Attributes:
        piece: What is learned.
        label: What the figure calls it.
        task: Settings of the task other than the usual.
        learner: Settings of the learner other than the usual.
        paper: What the paper shows for it, by metric of `frame`; read from its text and figures.
    """

    piece: str
    label: str
    task: Mapping[str, Any] = field(default_factory=dict)
    learner: Mapping[str, Any] = field(default_factory=dict)
    paper: Mapping[str, float] = field(default_factory=dict)

    def name(self, algorithm: Algorithm, steps: int, seed: int) -> str:
        """Folder of its run: what differs from the usual; figures with the same arm share it."""
        config, usual = self.config(algorithm, steps, seed), defaults(algorithm)
        said = [
            f"{key}-{value}"
            for ours, theirs in ((config.task, usual.task), (config.learner, usual.learner))
            for key, value in vars(ours).items()
            if value != getattr(theirs, key) and key not in ("seed", "steps", *_WITH_RATE)
        ]
        return "_".join([self.piece, algorithm, *said, f"{steps}-ticks", f"seed-{seed}"])

    def config(self, algorithm: Algorithm, steps: int | None, seed: int) -> TrainConfig:
        """Settings of its run."""
        usual = defaults(algorithm)
        learner = {"seed": seed, **({} if steps is None else {"steps": steps}), **self.learner}
        task = {**({"freedom": True} if self.piece in FREE else {}), **self.task}
        rate = usual.task.control_hz * usual.task.substeps
        if "control_hz" in task:  # the physics and the episodes last as long as ever
            share = task["control_hz"] / usual.task.control_hz
            task |= {"substeps": round(rate / task["control_hz"]),
                     "max_ticks": round(usual.task.max_ticks * share)}  # fmt: skip
        return replace(
            usual, task=replace(usual.task, **task), learner=replace(usual.learner, **learner)
        )


@dataclass(frozen=True)
class Figure:
    """A figure of the paper.

    Attributes:
        number: Of the figure.
        title: What it shows.
        claim: What the paper concludes from it.
        arms: What it compares.
        metric: The metric that it is about.
        curve: It shows learning, not only its end.
    """

    number: int
    title: str
    claim: str
    arms: tuple[Arm, ...]
    metric: str = "f1"
    curve: bool = False


# F1 as published for each piece; where the text gives none it was read from the bars (about).
PAPER_F1 = {
    "twinkle": 0.9, "long-long-ago": 0.9, "fur-elise": 0.71, "happy-birthday": 0.62,
    "farewell": 0.64, "red-river-valley": 0.75, "scales-practice": 0.8, "chord-transition": 0.35,
}  # fmt: skip
TRANSFER_F1 = {"twinkle": 0.82, "long-long-ago": 0.23, "fur-elise": 0.05}
"""Figure 12: a policy of Scales Practice on other pieces."""
TEMPI = (0.75, 1.0, 1.25)


def _plain(piece: str) -> Arm:
    paper = {"f1": PAPER_F1[piece]} if piece in PAPER_F1 else {}
    return Arm(piece, piece, paper=paper)


FIGURES = {
    figure.number: figure
    for figure in (
        Figure(9, "Monophonic pieces", "precision is high; Für Elise, the fastest, has the lowest"
               " recall", tuple(_plain(piece) for piece in MONOPHONIC)),
        Figure(10, "Polyphonic pieces", "F1 is around .6, below the monophonic pieces, and recall"
               " above .6", tuple(_plain(piece) for piece in POLYPHONIC)),
        Figure(11, "Scales and chords", "Scales Practice goes better than Chord Transition",
               tuple(_plain(piece) for piece in ("scales-practice", "chord-transition"))),
        Figure(12, "A policy of Scales Practice on other pieces", "it plays pieces of the same"
               " tempo, and fails on faster ones", (_plain("scales-practice"),)),
        Figure(13, "Mapping function", "reciprocal learns faster than gaussian, and ends better", (
            Arm("twinkle", "reciprocal", {"mapping": "reciprocal"}),
            Arm("twinkle", "gaussian", {"mapping": "gaussian"}),
        ), curve=True),
        Figure(14, "Finger reward", "the reward by components learns faster than the plain"
               " distance, which stays around .6", (
            Arm("twinkle", "by components", {"euclidean": False}),
            Arm("twinkle", "distance", {"euclidean": True}, paper={"f1": 0.6}),
        ), curve=True),
        Figure(15, "Freedom", "freedom raises recall much and lowers precision little", (
            Arm("fur-elise", "without", {"freedom": False}),
            Arm("fur-elise", "with freedom", {"freedom": True}),
        ), metric="recall", curve=True),
        Figure(16, "Frame rate", "a higher frame rate plays better, and may be less stable",
               tuple(Arm("twinkle", f"{rate} Hz", {"control_hz": float(rate)})
                     for rate in (10, 20, 30)), curve=True),
        Figure(17, "Discount", ".84 learns faster than .99, and ends better", (
            Arm("happy-birthday", ".84", learner={"discount": 0.84}),
            Arm("happy-birthday", ".99", learner={"discount": 0.99}),
        ), curve=True),
        Figure(18, "All pieces by recall", "most pieces reach a recall above .7",
               tuple(_plain(piece) for piece in pieces.names()), metric="recall"),
    )
}  # fmt: skip
