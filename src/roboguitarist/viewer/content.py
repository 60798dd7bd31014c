"""What the page knows of a performance, as an object for JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import mujoco
import numpy as np

from roboguitarist.alignment import Miss, misses
from roboguitarist.guitar import preset
from roboguitarist.looks.materials import FINGER_RGB
from roboguitarist.metrics import Metrics, Score, evaluate
from roboguitarist.performance import Performance
from roboguitarist.replay import presses
from roboguitarist.ringing import rings

FINGER_NAMES = {"FF": "index, 1 and i", "MF": "middle, 2 and m", "RF": "ring, 3 and a",
                "LF": "little, 4", "TH": "thumb, p"}  # fmt: skip
LEFT, RIGHT = ("FF", "MF", "RF", "LF"), ("TH", "FF", "MF", "RF")


def content(
    performance: Performance, model: mujoco.MjModel, start_s: float, end_s: float
) -> dict[str, Any]:
    """All that the page shows beside the scene and the sound.

    Notes, bars, presses, plucks, rings and misses are lists of lists, whose columns `page.js` and
    its sisters name where they read them. Times are seconds from the start of the piece.

    Args:
        performance: What to show.
        model: Its scene.
        start_s: When the animation and the sound begin.
        end_s: When they end.
    """
    tablature, guitar = performance.tablature, preset(performance.guitar)
    missed = misses(performance)
    metrics = evaluate(performance)
    title = tablature.title or "Untitled"
    return {
        "title": title,
        "byline": tablature.composer,
        "score": _score(metrics),
        "start_s": start_s,
        "end_s": end_s,
        "length_s": tablature.duration_s,
        "control_hz": performance.control_hz,
        "guitar": asdict(guitar),
        "fingers": {
            "left": [_css(name) for name in LEFT],
            "right": [_css(name) for name in RIGHT],
            "names": list(FINGER_NAMES.values()),
            "colours": [_css(name) for name in FINGER_NAMES],
        },
        "notes": _notes(performance),
        "bars": [[_ms(bar.onset_s), bar.number] for bar in tablature.bars],
        "misses": [[miss.index, str(miss)] for miss in missed],
        "metrics": [
            *_table(metrics, missed),
            ("Played by", f"{performance.controller}, {performance.hand} hand"),
        ],
        "presses": [
            [_ms(p.start_s), _ms(p.end_s), p.string, p.fret, p.finger]
            for p in presses(performance, model)
        ],
        "plucks": _plucks(performance),
        "rings": [
            [_ms(r.start_s), _ms(r.end_s), r.string, r.fret, round(r.width_m, 6), _ms(r.decay_s)]
            for r in rings(performance)
        ],
    }


def _score(metrics: Metrics) -> str:
    return f"{metrics.counts.right} of {metrics.counts.asked} notes right"


def _notes(performance: Performance) -> list[list[float]]:
    """Onset, string, fret, duration, finger of each hand, and the fret that is stopped."""
    notes, tablature = performance.tablature.notes, performance.tablature
    fingers = zip(performance.left.tolist(), performance.right.tolist(), strict=True)
    return [
        [
            _ms(n.onset_s),
            n.string,
            n.fret,
            _ms(n.duration_s),
            left,
            right,
            tablature.stopped_fret(n),
        ]
        for n, (left, right) in zip(notes, fingers, strict=True)
    ]


def _plucks(performance: Performance) -> list[list[float]]:
    columns = (
        np.round(performance.pluck_time_s, 4),
        performance.pluck_string,
        np.round(performance.pluck_x_m.astype(float), 4),
        performance.pluck_finger,
    )
    return [list(row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def _table(metrics: Metrics, missed: tuple[Miss, ...]) -> list[tuple[str, str]]:
    """Names and values of the metrics, for people."""

    def f1(score: Score | None) -> str:
        return f"{score.f1:.3f}" if score else "-"

    timing, motion, counts = metrics.timing_ms, metrics.motion, metrics.counts
    return [
        ("Notes, F1", f1(metrics.note)),
        ("Pitch and onset, F1", f1(metrics.onset)),
        ("Fretting, F1", f1(metrics.frame)),
        ("Fretting with freedom, F1", f1(metrics.frame_free)),
        ("Onset error, median", f"{timing.median:.1f} ms" if timing else "-"),
        ("Onset error, 95 %", f"{timing.p95:.1f} ms" if timing else "-"),
        ("Power of the left hand", f"{motion.power_w:.2f} W" if motion else "-"),
        ("Notes asked, plucked, missed", f"{counts.asked}, {counts.played}, {len(missed)}"),
    ]


def _ms(time_s: float) -> float:
    """A time to tenths of a millisecond, which is what the page needs of it."""
    return round(float(time_s), 4)


def _css(finger: str) -> str:
    return "#" + "".join(f"{round(255 * value):02x}" for value in FINGER_RGB[finger])
