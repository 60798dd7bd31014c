"""Plots of the paper's figures with the paper's values beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from paper_arms import Figure

NAMES = ("precision", "recall", "f1")
OURS = ("#5b8c5a", "#3f6c9b", "#b4552d")
PAPER = "#222222"


def draw(figure: Figure, document: dict[str, Any], path: Path) -> None:
    """Draw a figure's document into a PNG file."""
    wide = 3.5 + 1.1 * max(len(document["arms"]), 4)
    picture, axes = plt.subplots(figsize=(wide, 3.6), layout="constrained")
    if figure.number == 12:
        _transfer(axes, document["transfer"])
    elif figure.curve:
        _curves(axes, document["arms"], figure.metric)
    else:
        _bars(axes, document["arms"], figure.metric)
    axes.set(title=f"Figure {figure.number}: {figure.title}", ylim=(0, 1.02))
    axes.grid(axis="y", alpha=0.3)
    picture.legend(fontsize=8, loc="outside right upper")
    plt.savefig(path, dpi=130, metadata={"Software": None})
    plt.close()


def _bars(axes: Axes, arms: list[dict[str, Any]], metric: str) -> None:
    """Precision, recall and F1 of each piece, the mean over seeds with each seed as a dot."""
    if metric == "recall":
        arms = sorted(arms, key=lambda arm: -_mean(arm, "recall"))
    for index, (name, colour) in enumerate(zip(NAMES, OURS, strict=True)):
        place = np.arange(len(arms)) + 0.27 * (index - 1)
        axes.bar(place, [_mean(arm, name) for arm in arms], 0.25, color=colour, label=name)
        for x, arm in zip(place, arms, strict=True):
            values = [one["best"][f"frame/{name}"] for one in arm["runs"]]
            axes.plot([x] * len(values), values, ".", color="black", markersize=3)
        paper = [(x, arm["paper"][name]) for x, arm in zip(place, arms, strict=True)
                 if name in arm["paper"]]  # fmt: skip
        if paper:
            axes.plot(*zip(*paper, strict=True), "D", color=PAPER, markersize=6, mfc="white",
                      label=f"paper, {name}")  # fmt: skip
    axes.set_xticks(range(len(arms)), [arm["label"].replace("-", "\n") for arm in arms],
                    fontsize=8)  # fmt: skip


def _curves(axes: Axes, arms: list[dict[str, Any]], metric: str) -> None:
    """Each seed as a thin line, the mean of the seeds as a thick one."""
    column = 2 + NAMES.index(metric)
    for arm, colour in zip(arms, OURS, strict=False):
        curves = [np.array(one["curve"]) for one in arm["runs"] if one["curve"]]
        for curve in curves:
            axes.plot(curve[:, 0] / 1e6, curve[:, column], color=colour, alpha=0.35, linewidth=1)
        if curves:
            shortest = min(map(len, curves))
            mean = np.mean([curve[:shortest] for curve in curves], axis=0)
            axes.plot(mean[:, 0] / 1e6, mean[:, column], color=colour, label=arm["label"])
        if metric in arm["paper"]:
            axes.axhline(arm["paper"][metric], color=colour, linestyle="--", linewidth=1,
                         label=f"paper, {arm['label']}")  # fmt: skip
    axes.set(xlabel="million ticks", ylabel=f"{metric} (frame)")


def _transfer(axes: Axes, rows: list[dict[str, Any]]) -> None:
    """F1 of each piece over the tempo; the paper's at its own tempo."""
    for piece, colour in zip(dict.fromkeys(row["piece"] for row in rows), OURS, strict=False):
        own = [row for row in rows if row["piece"] == piece]
        tempi = sorted({row["tempo"] for row in own})
        mean = [np.mean([row["frame"][2] for row in own if row["tempo"] == t]) for t in tempi]
        axes.plot(tempi, mean, "o-", color=colour, label=piece)
        axes.plot(1.0, own[0]["paper"] or next(row["paper"] for row in own if row["paper"]), "D",
                  color=colour, mfc="white", label=f"paper, {piece}")  # fmt: skip
    axes.set(xlabel="tempo", ylabel="f1 (frame)")


def _mean(arm: dict[str, Any], name: str) -> float:
    values = [one["best"][f"frame/{name}"] for one in arm["runs"]]
    return float(np.mean(values)) if values else 0.0
