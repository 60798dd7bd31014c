"""How long a score of 10,000 notes takes to be read, in every format that we write.

The piece goes up and down the neck in eighth notes and chords, made from a seed. MusicXML and MIDI
are also read without strings and frets, which the reader then has to find.

Usage: python benchmarks/reading.py
Writes results/reading.json and prints seconds of processor time, the best of three.
"""

from __future__ import annotations

import io
import os
import random
import re
import tempfile
import time
import zipfile
from pathlib import Path

import mido
import record
from speed import processor

from roboguitarist import formats
from roboguitarist.formats import ascii_writer, midi_writer, musicxml_writer
from roboguitarist.tablature import Bar, Note, Tablature

N_NOTES, STEP_S, REPEATS = 10_000, 0.25, 3
CHORDS = ("x32010", "022100", "320003", "xx3211", "xx0232", "x02210")
PLACES = re.compile(rb"<(string|fret)>\d+</\1>")
CONTAINER = '<container><rootfiles><rootfile full-path="score.xml"/></rootfiles></container>'


def piece() -> Tablature:
    """Single notes in slowly moving positions, and open chords."""
    rng = random.Random(0)
    notes: list[Note] = []
    onset_s, position = 0.0, 0
    while len(notes) < N_NOTES:
        if rng.random() < 0.15:
            frets = enumerate(reversed(rng.choice(CHORDS)), 1)
            places = [(string, int(fret)) for string, fret in frets if fret != "x"]
        else:
            position = min(9, max(0, position + rng.choice((-2, -1, 0, 0, 0, 1, 2))))
            places = [(rng.randint(1, 6), position + rng.randint(0, 3))]
        notes += [Note(onset_s, string, fret, STEP_S) for string, fret in places]
        onset_s += STEP_S
    bars = tuple(Bar(2.0 * k, k + 1) for k in range(int(onset_s / 2) + 1))
    return Tablature(tuple(sorted(notes[:N_NOTES], key=lambda note: note.place)), bars)


def files(tablature: Tablature) -> dict[str, bytes]:
    """The piece in every format that we write, and without strings and frets."""
    musicxml, midi = musicxml_writer.write(tablature), midi_writer.write(tablature)
    plain = PLACES.sub(b"", musicxml)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("META-INF/container.xml", CONTAINER)
        archive.writestr("score.xml", musicxml)
    return {
        "tab.musicxml": musicxml,
        "notes.musicxml": plain,
        "tab.mxl": packed.getvalue(),
        "tab.mid": midi,
        "notes.mid": _without_text(midi),
        "tab.txt": ascii_writer.write(tablature),
        "tab.alphatex": alphatex(tablature),
        "tab.json": tablature.to_json().encode(),
    }


def _without_text(midi: bytes) -> bytes:
    """The MIDI file without the event that says which channel is which string."""
    file = mido.MidiFile(file=io.BytesIO(midi))
    for track in file.tracks:
        track[:] = [message for message in track if message.type != "text"]
    buffer = io.BytesIO()
    file.save(file=buffer)
    return buffer.getvalue()


def alphatex(tablature: Tablature) -> bytes:
    """The notes as eighths, four quarters to a bar."""
    beats: dict[float, list[str]] = {}
    for note in tablature.notes:
        beats.setdefault(note.onset_s, []).append(f"{note.fret}.{note.string}")
    texts = [f"({' '.join(places)})" for places in beats.values()]
    bars = [" ".join(texts[k : k + 8]) for k in range(0, len(texts), 8)]
    return ("\\tempo 120\n.\n:8 " + " |\n".join(bars) + "\n").encode()


def measure(path: Path) -> dict[str, float]:
    """The fewest seconds of processor time that reading the file took."""
    spent, n_notes = [], 0
    for _ in range(REPEATS):
        start = time.process_time()
        n_notes = len(formats.load(path).notes)
        spent.append(time.process_time() - start)
    return {"notes": n_notes, "cpu_s": round(min(spent), 2)}


def main() -> None:
    """Measure every format, print it, write the file."""
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, data in files(piece()).items():
            path = Path(folder, name)
            path.write_bytes(data)
            results[name] = measure(path)
            print(f"{name:<16}{results[name]['notes']:>8} notes{results[name]['cpu_s']:>8.2f} s")
    facts = {"processor": processor(), "load": os.getloadavg()[0], "best_of": REPEATS}
    print(record.write("reading", results, **facts))


if __name__ == "__main__":
    main()
