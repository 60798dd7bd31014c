"""What the left hand can fret in physics: every finger, string and fret, and the chord shapes.

Usage: python benchmarks/reach.py [linkage] [tendon]
Writes the map that the fingering reads (src/roboguitarist/fingering/reach-HAND.npz), its picture
(docs/_static/reach-HAND.png) and results/reach.json, the same for the same versions; what is known
of a hand that is not named stays. Takes about five minutes a hand on two cores.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from itertools import product
from pathlib import Path
from typing import get_args

import matplotlib as mpl
import numpy as np
import record
from tqdm import tqdm

from roboguitarist import cli_report
from roboguitarist.exercises.shapes import (
    BARRE_CHORDS,
    GRIPS,
    OPEN_CHORDS,
    POWER_CHORDS,
    Shape,
)
from roboguitarist.fingering.reach import Reach
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.fretting.holds import Hold, SearchConfig, hold
from roboguitarist.guitar import Guitar
from roboguitarist.hands import Variant
from roboguitarist.scene import SceneConfig

mpl.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[1]
HIGHEST_FRET = 15
AT_FRETS = (2, 7)
"""Movable shapes are tried with their lowest fret here."""
CELL, CHORD = SearchConfig(rounds=4), SearchConfig(rounds=14)
CANDIDATES = 64


def chords() -> list[tuple[str, Shape]]:
    """The catalogue: kind and shape."""
    movable = {"barre": BARRE_CHORDS, "power": POWER_CHORDS, "grip": GRIPS}
    placed = [
        (kind, shape.at(max(fret, 1 if shape.positions else 2)))
        for kind, shapes in movable.items()
        for shape in shapes
        for fret in AT_FRETS
    ]
    return [("open", shape) for shape in OPEN_CHORDS] + placed


def measure(hand: Variant) -> tuple[np.ndarray, list[tuple[str, Shape, Hold]]]:
    """Forces (4, 6, F) of single fingers, and how each chord was held."""
    scene = SceneConfig(hand=hand, sides=("left",), timestep_s=1 / 300, visuals=False)
    hands = HandBatch(scene, CANDIDATES, n_threads=1)
    force_n = np.zeros((4, 6, Guitar().n_frets), np.float32)
    cells = list(product(range(1, 5), range(1, 7), range(1, HIGHEST_FRET + 1)))
    for finger, string, fret in tqdm(cells, desc=f"{hand}: places", disable=None):
        one = Shape("", ((string, fret, finger),))
        force_n[finger - 1, string - 1, fret - 1] = hold(one, hands, scene, CELL).force_n[0]
    held = [
        (kind, shape, hold(shape, hands, scene, CHORD))
        for kind, shape in tqdm(chords(), desc=f"{hand}: chords", disable=None)
    ]
    hands.close()
    return force_n, held


def draw(hand: Variant, force_n: np.ndarray, held: list[tuple[str, Shape, Hold]]) -> None:
    """The map of each finger, and the chords by kind."""
    figure, axes = plt.subplots(
        1, 5, figsize=(15, 2.8), width_ratios=(1, 1, 1, 1, 1.3), layout="constrained"
    )
    for axis, cells, name in zip(
        axes[:4], force_n[:, :, :HIGHEST_FRET], ("index", "middle", "ring", "little"), strict=True
    ):
        axis.imshow(cells, vmin=0, vmax=3, cmap="viridis", aspect="auto",
                            extent=(0.5, HIGHEST_FRET + 0.5, 6.5, 0.5))  # fmt: skip
        axis.set(title=name, xlabel="fret", ylabel="string")
    figure.colorbar(axes[0].images[0], ax=axes[:4], label="N", pad=0.01)
    kinds = list(dict.fromkeys(kind for kind, _, _ in held))
    share = [np.mean([h.held for kind, _, h in held if kind == name]) for name in kinds]
    axes[4].barh(kinds, share)
    axes[4].set(title="chord shapes held", xlim=(0, 1))
    axes[4].invert_yaxis()
    figure.savefig(ROOT / "docs/_static" / f"reach-{hand}.png", dpi=100)


def summary(force_n: np.ndarray, held: list[tuple[str, Shape, Hold]]) -> dict[str, object]:
    """As JSON: shares, reasons, and every chord."""
    cells = force_n[:, :, :HIGHEST_FRET]
    by_kind = {
        kind: round(float(np.mean([h.held for k, _, h in held if k == kind])), 3)
        for kind in dict.fromkeys(kind for kind, _, _ in held)
    }
    return {
        "places held": round(float((cells >= 1.0).mean()), 3),
        "chords": len(held),
        "chords held": round(float(np.mean([h.held for _, _, h in held])), 3),
        "held by kind": by_kind,
        "reasons": dict(Counter(h.reason for _, _, h in held if not h.held)),
        "shapes": [
            {"kind": kind, "name": shape.name, "stops": shape.stops, "force_n": h.force_n,
             "held": h.held, "reason": h.reason}
            for kind, shape, h in held
        ],
    }  # fmt: skip


def main() -> None:
    """Measure the hands named, or all."""
    hands: list[Variant] = [
        hand for hand in get_args(Variant) if hand in sys.argv[1:] or not sys.argv[1:]
    ]
    known = record.FOLDER / "reach.json"
    results = json.loads(known.read_text())["results"] if known.exists() else {}
    for hand in hands:
        force_n, held = measure(hand)
        unheld = [
            frozenset((finger, string, fret) for string, fret, finger in shape.stops if finger)
            for _, shape, how in held
            if not how.held
        ]
        Reach(force_n, frozenset(unheld)).save(
            ROOT / "src/roboguitarist/fingering" / f"reach-{hand}.npz"
        )
        draw(hand, force_n, held)
        results[hand] = summary(force_n, held)
        rows = [(k, str(v)) for k, v in results[hand].items() if k != "shapes"]
        print(cli_report.table([(hand, ""), *rows]))
    print(record.write("reach", results))


if __name__ == "__main__":
    main()
