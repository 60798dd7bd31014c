"""What is asked: the notes of a piece with their strings, frets and times."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from itertools import pairwise
from typing import Any

from roboguitarist.errors import TabError

N_STRINGS = 6
STANDARD_TUNING = (64, 59, 55, 50, 45, 40)
"""MIDI pitches of the open strings, string 1 (high E) first."""


class Technique(StrEnum):
    """How a note is played, beside fretting and plucking it."""

    HAMMER_ON = "hammer-on"
    PULL_OFF = "pull-off"
    SLIDE = "slide"
    BEND = "bend"
    VIBRATO = "vibrato"
    PALM_MUTE = "palm-mute"
    DEAD = "dead"
    HARMONIC = "harmonic"
    LET_RING = "let-ring"
    STACCATO = "staccato"
    TREMOLO = "tremolo"
    TRILL = "trill"
    GRACE = "grace"
    STRUM_DOWN = "strum-down"
    STRUM_UP = "strum-up"


@dataclass(frozen=True, slots=True)
class Note:
    """One note as the tab asks for it.

    Attributes:
        onset_s: Start in seconds from the start of the piece, at least 0.
        string: 1 (high E) to 6.
        fret: Fret number relative to the capo, 0 for the open string.
        duration_s: Written length in seconds, above 0.
        bar: Written bar number, from 1 (0 for a pick-up bar).
        beat: Place in the bar in quarter notes, from 1.
        voice: Voice in the part, from 1.
        techniques: In alphabetical order, without repeats.
        left_finger: Finger 0 to 4 as marked in the file, if any.
        right_finger: One of p, i, m, a, c as marked in the file, if any.
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
            data: dict[str, Any] = json.loads(text)
            data["notes"] = tuple(_note(item) for item in data["notes"])
            data["bars"] = tuple(Bar(**item) for item in data["bars"])
            data["tempi"] = tuple(Tempo(**item) for item in data["tempi"])
            data["tuning"] = tuple(data["tuning"])
            data["warnings"] = tuple(data.get("warnings", ()))
            tablature = cls(**data)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise TabError(f"not a saved tablature: {error}") from error
        return validate(tablature)


def _note(item: dict[str, Any]) -> Note:
    techniques = tuple(Technique(name) for name in item.get("techniques", ()))
    return Note(**{**item, "techniques": techniques})


MAX_FRET = 24
MAX_DURATION_S = 4 * 3600.0


def validate(tablature: Tablature, file: str | None = None) -> Tablature:
    """Check that a tablature makes sense on a six-string guitar.

    Args:
        tablature: What was read.
        file: Name for the error message.

    Returns:
        The same tablature.

    Raises:
        TabError: On a number of strings other than six, a string or fret out of range, a
            negative or absurd time, a tempo that is not positive.
    """
    if len(tablature.tuning) != N_STRINGS:
        reason = f"the part has {len(tablature.tuning)} strings"
        raise TabError(reason, file=file, hint="six strings are needed")
    if not 0 <= tablature.capo <= 12:
        raise TabError(f"capo at fret {tablature.capo}", file=file, hint="0 to 12")
    if not tablature.tempi or any(not 1 <= t.quarters_per_minute <= 2000 for t in tablature.tempi):
        raise TabError("tempo out of range", file=file, hint="1 to 2000 quarter notes a minute")
    for note in tablature.notes:
        reason = _complaint(note, tablature.capo)
        if reason:
            raise TabError(reason[0], file=file, bar=note.bar, beat=note.beat, hint=reason[1])
    if any(a.place > b.place for a, b in pairwise(tablature.notes)):
        raise TabError("the notes are not in order of time", file=file)
    return tablature


def _complaint(note: Note, capo: int) -> tuple[str, str] | None:
    if not 1 <= note.string <= N_STRINGS:
        return f"string {note.string}", "1 to 6"
    if not 0 <= note.fret <= MAX_FRET - capo:
        return f"fret {note.fret}", f"0 to {MAX_FRET - capo}"
    if not 0 <= note.onset_s <= MAX_DURATION_S:
        return f"onset at {note.onset_s:g} s", "0 to four hours"
    if not 0 < note.duration_s <= MAX_DURATION_S:
        return f"duration of {note.duration_s:g} s", "above 0"
    return None
