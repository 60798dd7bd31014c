"""Compare the readers with what an independent reader understood of the same files.

The folder holds score files, and for each a `reference/<file>.json` with tempo and notes in ticks.
Prints one line for each part of each file, and the first differences: notes with onset, string,
fret and pitch that only one of the two has. Differences that are explained stand in
`docs/formats.md`.

    python benchmarks/agreement.py FOLDER
"""

from __future__ import annotations

import argparse
import json
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from roboguitarist import formats
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.formats import detection
from roboguitarist.formats.play_order import expand
from roboguitarist.formats.tempo_map import bar_starts
from roboguitarist.tablature import Tablature, Technique

TOLERANCE_S = 0.001
SHOWN = 6


@dataclass(frozen=True)
class Heard:
    """A note as one of the readers understood it; string and fret are None where not written."""

    onset_s: float
    pitch: int
    string: int | None = None
    fret: int | None = None
    harmonic: bool = False

    def __str__(self) -> str:
        """Short form for the report."""
        place = f" {self.string}/{self.fret}" if self.string else ""
        return f"{self.onset_s:.3f}s p{self.pitch}{place}"

    def agrees(self, other: Heard) -> bool:
        """Whether both are the same note; a harmonic's sounding pitch is not compared."""
        places = (self.string, other.string, self.fret, other.fret)
        placed = None not in places
        same = (self.string, self.fret) == (other.string, other.fret) if placed else True
        pitch = self.pitch == other.pitch or (placed and (self.harmonic or other.harmonic))
        return same and pitch and abs(self.onset_s - other.onset_s) <= TOLERANCE_S


@dataclass(frozen=True)
class Difference:
    """What only one of the two readers has."""

    ours: tuple[Heard, ...]
    theirs: tuple[Heard, ...]

    def __bool__(self) -> bool:
        """Whether there is any."""
        return bool(self.ours or self.theirs)


def ours(tablature: Tablature) -> list[Heard]:
    """Our notes, from the first bar line on."""
    start_s = tablature.bars[0].onset_s if tablature.bars else 0.0
    harmonics = {Technique.HARMONIC, Technique.ARTIFICIAL_HARMONIC}
    notes = (
        Heard(
            note.onset_s - start_s,
            tablature.pitch(note),
            note.string,
            note.fret,
            bool(harmonics & {*note.techniques}),
        )
        for note in tablature.notes
    )
    return sorted(notes, key=_order)


def theirs(reference: dict[str, Any], track: dict[str, Any]) -> list[Heard]:
    """Notes of one part of the reference, in seconds; voices in unison are one note."""
    seconds = _Seconds(reference)
    notes = (n for staff in track["staves"] for n in staff["notes"])
    heard = {
        (seconds(n["tick"]), n["midi"], n["string"], n["fret"], bool(n.get("harm"))): None
        for n in notes
    }
    return sorted((Heard(*values) for values in heard), key=_order)


class _Seconds:
    def __init__(self, reference: dict[str, Any]) -> None:
        self._per_quarter = reference["ticksPerQuarter"]
        marks = [tuple(mark) for bar in reference["play"] for mark in bar["tempo"]]
        self._ticks, self._tempi, self._at_s = [0], [float(reference["tempo"])], [0.0]
        for tick, tempo in marks:
            self._at_s.append(self(tick))
            self._ticks.append(tick)
            self._tempi.append(tempo)

    def __call__(self, tick: int) -> float:
        k = max(0, bisect_right(self._ticks, tick) - 1)
        return self._at_s[k] + (tick - self._ticks[k]) / self._per_quarter * 60 / self._tempi[k]


def _order(heard: Heard) -> tuple[float, int, int]:
    return heard.onset_s, heard.pitch, heard.string or 0


def compare(a: Sequence[Heard], b: Sequence[Heard]) -> Difference:
    """Match notes one to one; what is left over is the difference."""
    rest, only_ours = list(b), []
    for heard in a:
        near = (k for k, other in enumerate(rest) if heard.agrees(other))
        match = next(near, None)
        if match is None:
            only_ours.append(heard)
        else:
            rest.pop(match)
    return Difference(tuple(only_ours), tuple(rest))


def parts(path: Path, reference: dict[str, Any]) -> Iterator[tuple[str, Difference | str]]:
    """Name of each part, and how the readers differ there, or why ours refuses it."""
    for number, track in enumerate(reference["tracks"], 1):
        expected = theirs(reference, track)
        try:
            found = ours(formats.load(path, number))
        except RoboGuitaristError as error:
            yield track["name"], f"refused, {len(expected)} notes: {error}"
        else:
            yield track["name"], compare(found, expected)


def order(path: Path, reference: dict[str, Any]) -> str:
    """How the played bars differ, or nothing: their order, and where they start."""
    score = detection.read(path.read_bytes(), path.suffix)
    played = expand(score.bars)
    starts = [float(start) for start in bar_starts(score.bars, played, Fraction(0))]
    ours = list(zip(played, starts, strict=True))
    per_quarter = reference["ticksPerQuarter"]
    theirs = [(bar["bar"], bar["start"] / per_quarter) for bar in reference["play"]]
    if [bar for bar, _ in ours] != [bar for bar, _ in theirs]:
        return f"bars {[bar + 1 for bar, _ in ours]}, theirs {[bar + 1 for bar, _ in theirs]}"
    pairs = zip(ours, theirs, strict=True)
    moved = next(((a, b) for a, b in pairs if abs(a[1] - b[1]) > 1e-3), None)
    return f"bar {moved[0][0] + 1} at quarter {moved[0][1]}, theirs {moved[1][1]}" if moved else ""


def main() -> int:
    """Print the report; the exit status is 1 if notes differ anywhere."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path)
    differing = agreeing = 0
    for record in sorted((parser.parse_args().folder / "reference").glob("*.json")):
        reference = json.loads(record.read_text(encoding="utf-8"))
        path = record.parents[1] / record.name.removesuffix(".json")
        different_order = order(path, reference)
        if different_order:
            print(f"{path.name}: order differs: {different_order}")
        for name, result in parts(path, reference):
            if isinstance(result, str):
                print(f"{path.name} [{name}]: {result}")
            elif result:
                differing += 1
                print(f"{path.name} [{name}]: differs")
                for who, notes in (("ours", result.ours), ("theirs", result.theirs)):
                    more = f" and {len(notes) - SHOWN} more" if len(notes) > SHOWN else ""
                    print(f"  only {who}:", ", ".join(map(str, notes[:SHOWN])) + more)
            else:
                agreeing += 1
                print(f"{path.name} [{name}]: agrees")
    print(f"{agreeing} parts agree, {differing} differ")
    return int(differing > 0)


if __name__ == "__main__":
    raise SystemExit(main())
