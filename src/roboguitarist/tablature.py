"""What is asked: the notes of a piece with their strings, frets and times."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields, replace
from enum import StrEnum
from itertools import chain, pairwise
from math import isfinite
from types import NoneType
from typing import Any

from roboguitarist.errors import TabError

N_STRINGS = 6
MIN_SPEED, MAX_SPEED = 0.1, 10.0
STANDARD_TUNING = (64, 59, 55, 50, 45, 40)
"""MIDI pitches of the open strings, string 1 (high E) first."""


class Technique(StrEnum):
    """How a note is played, beside fretting and plucking it."""

    HAMMER_ON = "hammer-on"
    PULL_OFF = "pull-off"
    SLIDE = "slide"
    """From the note before on this string to this one."""
    SLIDE_IN = "slide-in"
    SLIDE_OUT = "slide-out"
    BEND = "bend"
    VIBRATO = "vibrato"
    PALM_MUTE = "palm-mute"
    DEAD = "dead"
    HARMONIC = "harmonic"
    """A natural one."""
    ARTIFICIAL_HARMONIC = "artificial-harmonic"
    LET_RING = "let-ring"
    STACCATO = "staccato"
    TREMOLO = "tremolo"
    TRILL = "trill"
    GRACE = "grace"
    STRUM_DOWN = "strum-down"
    STRUM_UP = "strum-up"
    RASGUEADO = "rasgueado"


@dataclass(frozen=True, slots=True)
class Note:
    """One note as the tab asks for it.

    Attributes:
        onset_s: Start in seconds from the start of the piece, at least 0.
        string: 1 (high E) to 6.
        fret: Fret number relative to the capo, 0 for the open string.
        duration_s: Written length in seconds, above 0.
        bar: Written bar number, from 1 (0 for a pick-up bar).
        beat: Place in the bar in quarter notes, from 1; less for a grace note before the bar.
        voice: Voice in the part, from 1.
        techniques: In alphabetical order, without repeats.
        left_finger: Finger 0 to 4 as marked in the file, if any.
        right_finger: One of p, i, m, a, c as marked in the file, if any.
        bend: Curve of a bend: share of the duration from 0 to 1, and semitones above the fret.
        velocity: How loud, 1 to 127 as in MIDI, if the file says so.
    """

    onset_s: float
    string: int
    fret: int
    duration_s: float
    bar: int = 1
    beat: float = 1.0
    voice: int = 1
    techniques: tuple[Technique, ...] = ()
    left_finger: int | None = None
    right_finger: str | None = None
    bend: tuple[tuple[float, float], ...] = ()
    velocity: int | None = None

    @property
    def end_s(self) -> float:
        """Written end in seconds."""
        return self.onset_s + self.duration_s

    @property
    def place(self) -> tuple[float, int, int]:
        """What a tablature's notes are sorted by: onset, string, fret."""
        return self.onset_s, self.string, self.fret


@dataclass(frozen=True, slots=True)
class Bar:
    """One bar as it is played: repeats make the same number come again."""

    onset_s: float
    number: int
    beats: int = 4
    beat_type: int = 4


@dataclass(frozen=True, slots=True)
class Tempo:
    """From `onset_s` on there are `quarters_per_minute`."""

    onset_s: float
    quarters_per_minute: float


@dataclass(frozen=True)
class Tablature:
    """A piece in the order it is played, repeats written out.

    Attributes:
        notes: Sorted by onset, then string, then fret. Times are whole microseconds.
        bars: Bars in playing order.
        tempi: Tempo marks in playing order, at least one.
        tuning: MIDI pitch of each open string without capo, string 1 first.
        capo: Fret of the capo, 0 for none.
        title, composer, source, grade: As printed, or empty.
    """

    notes: tuple[Note, ...]
    bars: tuple[Bar, ...] = (Bar(0.0, 1),)
    tempi: tuple[Tempo, ...] = (Tempo(0.0, 120.0),)
    tuning: tuple[int, ...] = STANDARD_TUNING
    capo: int = 0
    title: str = ""
    composer: str = ""
    source: str = ""
    grade: str = ""
    warnings: tuple[str, ...] = field(default=(), compare=False)

    @property
    def duration_s(self) -> float:
        """End of the last note in seconds, 0 for an empty piece."""
        return max((note.end_s for note in self.notes), default=0.0)

    def pitch(self, note: Note) -> int:
        """MIDI pitch that the note sounds: tuning plus capo plus fret."""
        return self.tuning[note.string - 1] + self.capo + note.fret

    def stopped_fret(self, note: Note) -> int:
        """Fret of the neck that a finger stops, counted from the nut; 0 for an open string."""
        return note.fret + self.capo if note.fret else 0

    def at_speed(self, factor: float) -> Tablature:
        """The same piece, `factor` times as fast; times are again whole microseconds.

        Raises:
            TabError: If the factor is not from 0.1 to 10, or a time or tempo gets out of range.
        """
        if not MIN_SPEED <= factor <= MAX_SPEED:
            raise TabError(f"speed {factor:g} ({MIN_SPEED:g} to {MAX_SPEED:g} times the tempo)")

        def scaled(time_s: float) -> float:
            return round(time_s / factor, 6)

        notes = (
            replace(
                note,
                onset_s=scaled(note.onset_s),
                duration_s=max(scaled(note.duration_s), 1e-6),
            )
            for note in self.notes
        )
        bars = (replace(bar, onset_s=scaled(bar.onset_s)) for bar in self.bars)
        tempi = (
            Tempo(scaled(tempo.onset_s), tempo.quarters_per_minute * factor) for tempo in self.tempi
        )
        in_order = sorted(notes, key=lambda note: note.place)
        return validate(replace(self, notes=tuple(in_order), bars=tuple(bars), tempi=tuple(tempi)))

    def to_json(self) -> str:
        """This tablature as JSON text."""
        return json.dumps(asdict(self), ensure_ascii=False, indent=1)

    @classmethod
    def from_json(cls, text: str) -> Tablature:
        """Read what `to_json` wrote.

        Raises:
            TabError: If the text is not such JSON or breaks a rule of `validate`.
        """
        try:
            data = _values(cls, json.loads(text))
            data["notes"] = tuple(_note(item) for item in data["notes"])
            data["bars"] = tuple(Bar(**_values(Bar, item)) for item in data["bars"])
            data["tempi"] = tuple(Tempo(**_values(Tempo, item)) for item in data["tempi"])
            data["tuning"] = tuple(_checked("int", pitch) for pitch in data["tuning"])
            data["warnings"] = tuple(_checked("str", line) for line in data.get("warnings", ()))
            tablature = cls(**data)
        except KeyError as error:
            raise TabError(f"not a saved tablature: no or unknown {error}") from error
        except (ValueError, TypeError, OverflowError, RecursionError) as error:
            raise TabError(f"not a saved tablature: {error}") from error
        return validate(tablature)


_JSON_TYPES: dict[str, tuple[type, ...]] = {
    "float": (float, int),
    "int": (int,),
    "str": (str,),
    "int | None": (int, NoneType),
    "str | None": (str, NoneType),
}


def _values(kind: type, item: Any) -> dict[str, Any]:
    """Fields of a dataclass from JSON, each of the type that it is declared with."""
    if not isinstance(item, dict):
        raise TypeError(f"{kind.__name__} without names")
    declared = {entry.name: str(entry.type) for entry in fields(kind)}
    return {name: _checked(declared[name], value) for name, value in item.items()}


def _checked(declared: str, value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, _JSON_TYPES.get(declared, (list,))):
        raise TypeError(f"{str(value)[:20]!r} where {declared} is needed")
    return float(value) if declared == "float" else value


def _note(item: Any) -> Note:
    values = _values(Note, item)
    values["techniques"] = tuple(Technique(name) for name in values.get("techniques", ()))
    values["bend"] = tuple(
        (_checked("float", share), _checked("float", semitones))
        for share, semitones in values.get("bend", ())
    )
    return Note(**values)


MAX_FRET = 24
MAX_CAPO = 12
MAX_DURATION_S = 4 * 3600.0
MAX_BEND = 12


def validate(tablature: Tablature, file: str | None = None) -> Tablature:
    """Check that a tablature makes sense on a six-string guitar.

    Args:
        tablature: What was read.
        file: Name for the error message.

    Returns:
        The same tablature.

    Raises:
        TabError: On a number of strings other than six, a string or fret out of range, a
            negative or absurd time, a tempo that is not positive, two notes that begin on one
            string at once.
    """
    reason = _complaint(tablature)
    if reason:
        raise TabError(reason, file=file)
    for note in tablature.notes:
        reason = _note_complaint(note, tablature.capo)
        if reason:
            raise TabError(reason, file=file, bar=note.bar, beat=note.beat)
    for a, b in pairwise(tablature.notes):
        if a.place > b.place:
            raise TabError("the notes are not in order of time", file=file, bar=b.bar, beat=b.beat)
        if a.place[:2] == b.place[:2]:
            reason = f"two notes on string {b.string} at once"
            raise TabError(reason, file=file, bar=b.bar, beat=b.beat)
    return tablature


def _complaint(tablature: Tablature) -> str:
    """What is wrong with the piece, its notes aside."""
    tempi = [tempo.quarters_per_minute for tempo in tablature.tempi]
    times = [[m.onset_s for m in marks] for marks in (tablature.bars, tablature.tempi)]
    n_strings, capo = len(tablature.tuning), tablature.capo
    rules = (
        (n_strings == N_STRINGS, f"the part has {n_strings} strings (six are needed)"),
        (all(0 <= pitch <= 127 for pitch in tablature.tuning), "tuning out of range"),
        (0 <= capo <= MAX_CAPO, f"capo at fret {capo} (0 to {MAX_CAPO})"),
        (tempi, "no tempo"),
        (all(1 <= t <= 2000 for t in tempi), "tempo out of range (1 to 2000 quarters a minute)"),
        (all(map(isfinite, chain(*times))), "a time of a bar or tempo mark is not a number"),
        (all(t == sorted(t) for t in times), "bars or tempo marks are not in order of time"),
    )
    return next((reason for holds, reason in rules if not holds), "")


def _note_complaint(note: Note, capo: int) -> str:
    highest = MAX_FRET - capo
    rules = (
        (1 <= note.string <= N_STRINGS, f"string {note.string} (1 to {N_STRINGS})"),
        (0 <= note.fret <= highest, f"fret {note.fret} (0 to {highest})"),
        (0 <= note.onset_s <= MAX_DURATION_S, f"onset at {note.onset_s:g} s (0 to four hours)"),
        (0 < note.duration_s <= MAX_DURATION_S, f"duration of {note.duration_s:g} s (above 0)"),
        (isfinite(note.beat), "beat that is not a number"),
        (note.left_finger in (None, *range(5)), f"left finger {note.left_finger} (0 to 4)"),
        (
            note.right_finger in (None, *"pimac"),
            f"right finger {note.right_finger} (p, i, m, a, c)",
        ),
        (
            _is_curve(note.bend),
            f"a bend out of range (0 to {MAX_BEND} semitones, in order of time)",
        ),
        (
            note.velocity is None or 1 <= note.velocity <= 127,
            f"velocity {note.velocity} (1 to 127)",
        ),
    )
    return next((reason for holds, reason in rules if not holds), "")


def _is_curve(bend: tuple[tuple[float, float], ...]) -> bool:
    """Whether shares of time increase from 0 to 1 and heights are in range."""
    shares = [share for share, _ in bend]
    return (
        all(0 <= share <= 1 for share in shares)
        and shares == sorted(shares)
        and all(0 <= semitones <= MAX_BEND for _, semitones in bend)
    )
