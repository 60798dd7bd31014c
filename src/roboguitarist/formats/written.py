"""A score as it is written: what every reader makes before repeats are played out."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from roboguitarist.tablature import Technique

MAX_NOTES = 50_000
"""Notes of a file that are read; real ones have some thousands."""


@dataclass(frozen=True, slots=True)
class WrittenNote:
    """One written note; times are in quarter notes.

    Attributes:
        bar: Index of the written bar, from 0.
        offset: Start from the start of the bar; below 0 for a grace note before the bar.
        length: Written length, above 0.
        pitch: MIDI pitch that sounds, if written.
        string, fret: As written, if written.
        voice, staff: From 1.
        tied: Continues the note of this pitch that ends where it begins.
        techniques: In alphabetical order, without repeats.
        left_finger, right_finger: As marked, if marked.
        bend: Curve of a bend, as in `Note`.
        velocity: MIDI velocity, if the file says how loud.
    """

    bar: int
    offset: Fraction
    length: Fraction
    pitch: int | None = None
    string: int | None = None
    fret: int | None = None
    voice: int = 1
    staff: int = 1
    tied: bool = False
    techniques: tuple[Technique, ...] = ()
    left_finger: int | None = None
    right_finger: str | None = None
    bend: tuple[tuple[float, float], ...] = ()
    velocity: int | None = None


@dataclass(frozen=True, slots=True)
class WrittenBar:
    """One written bar and what its bar lines say about the order of playing.

    Attributes:
        number: Printed number.
        length: In quarter notes.
        beats, beat_type: Time signature.
        tempi: Offset in quarter notes and quarter notes a minute of each tempo mark.
        repeat_start: A repeat begins here.
        repeat_times: How often a repeat that ends here is played; 0 where none ends.
        endings: Numbers of the ending bracket over this bar.
        segno, coda: The sign stands at the start of this bar.
        to_coda, fine: The word stands at the end of this bar.
        jump: "dacapo" or "dalsegno" at the end of this bar, or empty.
    """

    number: int
    length: Fraction = Fraction(4)
    beats: int = 4
    beat_type: int = 4
    tempi: tuple[tuple[Fraction, Fraction], ...] = ()
    repeat_start: bool = False
    repeat_times: int = 0
    endings: frozenset[int] = frozenset()
    segno: bool = False
    coda: bool = False
    to_coda: bool = False
    fine: bool = False
    jump: str = ""


@dataclass(frozen=True, slots=True)
class WrittenPart:
    """One instrument.

    Attributes:
        name: Printed name, or its id.
        notes: In the order of the file.
        n_strings: Number of strings if the file says so.
        tuning: MIDI pitches of the open strings, string 1 first, if the file says so.
        capo: Fret of the capo.
        obstacle: Why it cannot be played on a six-string guitar, or empty.
        warnings: What was read otherwise than written.
    """

    name: str
    notes: tuple[WrittenNote, ...]
    n_strings: int | None = None
    tuning: tuple[int, ...] | None = None
    capo: int = 0
    obstacle: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def has_places(self) -> bool:
        """Whether most of its notes have a string and a fret."""
        placed = sum(note.string is not None and note.fret is not None for note in self.notes)
        return 2 * placed > len(self.notes)


@dataclass(frozen=True, slots=True)
class WrittenScore:
    """All parts of a file with their common bars."""

    bars: tuple[WrittenBar, ...]
    parts: tuple[WrittenPart, ...]
    title: str = ""
    composer: str = ""
    source: str = ""
    grade: str = ""
