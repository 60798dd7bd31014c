"""How often the fingering agrees with the left-hand fingers that human editors wrote.

Usage: python benchmarks/editors.py FOLDER
Reads FOLDER/*.csv (columns: score, onset_whole, grace, duration_whole, bar, midi, finger, string,
voice; times in whole notes), one file for each piece. Weights are learned from all files but one
and tried on that one, in turn. Prints the learned weights, writes results/editors.json, and prints
a table of the share of marked notes that get the marked finger. Strings and frets are arranged
unless marked; the fingers are hidden.
"""

from __future__ import annotations

import csv
import sys
from collections import defaultdict
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import record
from likelihood import LEARNED, Example, Graph, learn
from tqdm import tqdm

from roboguitarist.fingering import Costs, Fingering
from roboguitarist.fingering.arrangement import Place, Sound, arrange
from roboguitarist.fingering.assign import MEMORY, by_search
from roboguitarist.fingering.given import moments
from roboguitarist.fingering.paper import paper
from roboguitarist.fingering.settings import setting
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import STANDARD_TUNING, Note, Tablature

WHOLE_S = 3.0
"""80 quarter notes a minute: the data have no tempo."""
GUITAR = Guitar(n_frets=24)
PULL, STEPS = 5.0, 12
USUAL_MARKS = 100
"""A file counts as the square root of its number of marks, one with so many as it is."""


@dataclass(frozen=True)
class Piece:
    """Notes in order of time, and the finger that the editor wrote for each, if any."""

    file: str
    sounds: tuple[Sound, ...]
    marks: tuple[int | None, ...]
    tuning: tuple[int, ...]

    @property
    def marked(self) -> tuple[Sound, ...]:
        """The notes with their fingers."""
        pairs = zip(self.sounds, self.marks, strict=True)
        return tuple(replace(sound, finger=mark) for sound, mark in pairs)


def read(path: Path) -> list[Piece]:
    """The scores of one file; notes that two voices share are one."""
    scores: dict[str, dict[tuple[float, int], dict[str, str]]] = defaultdict(dict)
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if not float(row["grace"]):
                key = float(row["onset_whole"]), int(row["midi"])
                kept = scores[row["score"]].get(key, row)
                scores[row["score"]][key] = {name: kept[name] or row[name] for name in row}
    return [_piece(path.stem, notes) for notes in scores.values()]


def _piece(file: str, notes: dict[tuple[float, int], dict[str, str]]) -> Piece:
    sounds, marks = [], []
    for (onset, pitch), row in sorted(notes.items()):
        times_s = [round(WHOLE_S * t, 6) for t in (onset, onset + float(row["duration_whole"]))]
        string = int(row["string"]) if row["string"] else None
        sounds.append(Sound(times_s[0], max(times_s[1], times_s[0] + 1e-3), pitch, string))
        marks.append(int(row["finger"]) if row["finger"] else None)
    lowest = min(sound.pitch for sound in sounds)
    tuning = (*STANDARD_TUNING[:5], min(STANDARD_TUNING[5], max(lowest, 38)))
    return Piece(file, tuple(sounds), tuple(marks), tuning)


Method = Callable[[Tablature], Fingering]


def tab(piece: Piece, places: list[Place | None]) -> tuple[Tablature, list[int]]:
    """A piece with its marks, and the number of each of its notes."""
    notes = [
        (Note(sound.onset_s, *place, sound.end_s - sound.onset_s, left_finger=mark), k)
        for k, (sound, mark, place) in enumerate(
            zip(piece.sounds, piece.marks, places, strict=True)
        )
        if place
    ]
    notes.sort(key=lambda pair: pair[0].place)
    tablature = Tablature(tuple(note for note, _ in notes), tuning=piece.tuning)
    return tablature, [k for _, k in notes]


def unmarked(tablature: Tablature) -> Tablature:
    """The same without fingers."""
    notes = (replace(note, left_finger=None) for note in tablature.notes)
    return replace(tablature, notes=tuple(notes))


def hits(piece: Piece, costs: Costs, method: Method) -> int:
    """Marked notes that get the finger that the editor wrote, who is not asked."""
    tablature, numbers = tab(piece, arrange(piece.sounds, piece.tuning, costs=costs))
    fingering = method(unmarked(tablature))
    found = {k: int(left) for k, left in zip(numbers, fingering.left, strict=True)}
    return sum(mark is not None and found.get(k) == mark for k, mark in enumerate(piece.marks))


def one_finger_per_fret(tablature: Tablature) -> Fingering:
    """The hand shifts as little as brings the notes into four frets; each has its finger."""
    fingering = paper(tablature, GUITAR)
    position = 1
    left = fingering.left.copy()
    for k, note in enumerate(tablature.notes):
        if note.fret:
            position = min(max(position, note.fret - 3), note.fret)
            left[k] = note.fret - position + 1
    return replace(fingering, left=left)


def examples(pieces: list[Piece]) -> list[Example]:
    """The scores of a file to learn from, at places that go with the marks."""
    n_marks = sum(mark is not None for piece in pieces for mark in piece.marks)
    result = []
    for piece in pieces:
        if any(mark is not None for mark in piece.marks):
            tablature, _ = tab(piece, arrange(piece.marked, piece.tuning, costs=Costs()))
            nut_fret = 0 if any(not note.fret for note in tablature.notes) else None
            marked, every = (
                Graph(setting(moments(t, GUITAR), nut_fret, None), MEMORY)
                for t in (tablature, unmarked(tablature))
            )
            result.append(Example(marked, every, (USUAL_MARKS / n_marks) ** 0.5))
    return result


def searched(costs: Costs) -> Method:
    """The search with these costs."""
    return lambda tablature: by_search(tablature, GUITAR, costs)


def main() -> None:
    """Learn, try, print and write."""
    files = {path.stem: read(path) for path in sorted(Path(sys.argv[1]).glob("*.csv"))}
    known = {
        file: found
        for file, pieces in tqdm(files.items(), "ways", disable=None)
        if (found := examples(pieces))
    }
    learned = learn([e for found in known.values() for e in found], Costs(), PULL, STEPS)
    print("Weights from all files:")
    print({name: value for name, value in asdict(learned).items() if name in LEARNED}, flush=True)
    results = []
    for file in known:
        others = [example for other in known if other != file for example in known[other]]
        learned = learn(others, Costs(), PULL, STEPS) if others else Costs()
        results.append(_row(file, files[file], learned))
        _show(results[-1])
    total = {"piece": "all"}
    total |= {key: sum(row[key] for row in results) for key in results[0] if key != "piece"}
    _show(total)
    print(record.write("editors", [*results, total]))


def _show(row: dict) -> None:
    shares = (f"{key} {row[key] / row['marked']:.3f}" for key in list(row)[2:])
    print(f"{row['piece']}: {row['marked']} marked notes,", ", ".join(shares), flush=True)


def _row(file: str, pieces: list[Piece], learned: Costs) -> dict:
    """Marked notes of a file, and how many of them each method finds."""
    start = Costs()
    methods: dict[str, tuple[Costs, Method]] = {
        "nearest finger": (start, lambda tablature: paper(tablature, GUITAR)),
        "one finger per fret": (start, one_finger_per_fret),
        "untuned search": (start, searched(start)),
        "search learned from the others": (learned, searched(learned)),
    }
    marked = sum(mark is not None for piece in pieces for mark in piece.marks)
    return {"piece": file, "marked": marked} | {
        name: sum(hits(piece, costs, method) for piece in pieces)
        for name, (costs, method) in methods.items()
    }


if __name__ == "__main__":
    main()
