"""What an ear that knows nothing of the guitar hears of the eight pieces.

Usage: pip install onnxruntime librosa pretty_midi 'resampy<0.4.3' 'setuptools<81'
       pip install --no-deps basic-pitch
       python benchmarks/ear.py

basic-pitch (R. Bittner and others, "A lightweight instrument-agnostic model for polyphonic note
transcription and multipitch estimation", ICASSP 2022) transcribes the sound of each performance;
mir_eval compares pitches and onsets, within 50 ms, with those of the tablature. Beside it stands
the same for an ideal performance of the tablature, which is the ceiling: what this ear would hear
if every note were right. Writes results/ear.json and prints a table of it.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
from pathlib import Path
from typing import Any

import mir_eval
import numpy as np
import record

from roboguitarist import cli_report, formats, pieces, sound
from roboguitarist.fingering import assign
from roboguitarist.guitar import preset
from roboguitarist.metrics import evaluate
from roboguitarist.performance import Performance, perform
from roboguitarist.tablature import Tablature

PIECES = pieces.names()[:8]
TOLERANCE_S = 0.05
SPEED_M_S = 0.5
"""Of the ideal plucks."""


def ideal(performance: Performance) -> Performance:
    """The same tablature with every note plucked on time and held for its length."""
    tablature, count = performance.tablature, len(performance.tablature.notes)
    time_s, notes = performance.time_s, performance.tablature.notes
    sounding = np.full_like(performance.sounding_fret, tablature.capo)
    force_n = np.zeros_like(performance.press_force_n)
    for note in notes:
        held = (time_s >= note.onset_s - 1e-6) & (time_s < note.end_s - 1e-6)
        fret = tablature.stopped_fret(note)
        if fret:
            sounding[held, note.string - 1] = fret
            force_n[held, note.string - 1, fret - 1] = 3.0
    arrays = {name: getattr(performance, name) for name in performance.__dataclass_fields__}
    return Performance(**{
        **arrays,
        "sounding_fret": sounding,
        "press_force_n": force_n,
        "pluck_time_s": np.array([note.onset_s for note in notes]),
        "pluck_string": np.array([note.string for note in notes], np.int8),
        "pluck_finger": performance.right.copy(),
        "pluck_fret": np.array([note.fret + tablature.capo for note in notes], np.int8),
        "pluck_speed_m_s": np.full(count, SPEED_M_S, np.float32),
        "pluck_x_m": np.full(count, preset(performance.guitar).sound_hole_x_m, np.float32),
    })  # fmt: skip


def transcribed(samples: np.ndarray, model: Any) -> tuple[np.ndarray, np.ndarray]:
    """Onsets (n,) in seconds and MIDI pitches (n,) that basic-pitch hears."""
    from basic_pitch.inference import predict  # noqa: PLC0415 - slow, and it talks  # pyright: ignore[reportMissingImports]

    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        path = Path(folder) / "sound.wav"
        sound.write_wav(path, samples)
        _, _, events = predict(path, model)
    rows = sorted((start, pitch) for start, _, pitch, *_ in events)
    return np.array([row[0] for row in rows], float), np.array([row[1] for row in rows], float)


def onset_f1(tablature: Tablature, onset_s: np.ndarray, pitch: np.ndarray) -> float:
    """F1 of pitch and onset against the tablature."""
    if not onset_s.size:
        return 0.0
    asked_s = np.array([note.onset_s for note in tablature.notes])
    asked = np.array([tablature.pitch(note) for note in tablature.notes], float)
    _, _, f1, _ = mir_eval.transcription.precision_recall_f1_overlap(
        asked_s[:, None] + [0.0, 1.0],
        mir_eval.util.midi_to_hz(asked),
        onset_s[:, None] + [0.0, 1.0],
        mir_eval.util.midi_to_hz(pitch),
        onset_tolerance=TOLERANCE_S,
        offset_ratio=None,  # pyright: ignore[reportArgumentType] - mir_eval has no types
    )
    return float(f1)


def heard(name: str, model: Any) -> dict[str, Any]:
    """Scores of one piece."""
    performance = perform(assign(formats.load(pieces.path(name))))
    perfect = ideal(performance)
    scores = [
        onset_f1(performance.tablature, *transcribed(sound.synthesize(one), model))
        for one in (performance, perfect)
    ]
    metrics = evaluate(performance)
    return {
        "name": name,
        "onset_f1": scores[0],
        "ceiling_f1": scores[1],
        "ratio": scores[0] / scores[1] if scores[1] else None,
        "onset_f1_by_sensors": metrics.onset.f1 if metrics.onset else None,
    }


def main() -> None:
    """Play and transcribe everything, print the table, write the file."""
    from basic_pitch.inference import Model  # noqa: PLC0415  # pyright: ignore[reportMissingImports]

    weights = Path(__import__("basic_pitch").__file__).parent / "saved_models/icassp_2022/nmp.onnx"
    model = Model(weights)
    results = []
    for name in PIECES:
        results.append(heard(name, model))
        print(results[-1], flush=True)
    keys = ("onset_f1", "ceiling_f1", "ratio", "onset_f1_by_sensors")
    rows = [(r["name"], *(f"{r[key]:.3f}" for key in keys)) for r in results]
    print(cli_report.table([("piece", "heard", "ceiling", "ratio", "by sensors"), *rows]))
    print(record.write("ear", results))


if __name__ == "__main__":
    main()
