r"""The part of alphaTex that people write by hand, to the score as written.

    \title "Song" \tempo 90 \tuning e4 b3 g3 d3 a2 e2 \capo 2
    .
    :4 0.6 2.5 (0.1 1.2 0.3).8 r.8 {d} | \ro 3.3{h} 5.3 x.4 -.4 \rc 2

Notes are fret.string.duration; the language is documented at https://www.alphatab.net.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from roboguitarist.errors import TabError
from roboguitarist.formats.alphatex_beats import Beat, Scanner, read_beat
from roboguitarist.formats.linked import Linked, linked
from roboguitarist.formats.musicxml_bars import FASTEST, MAX_TIMES, SLOWEST
from roboguitarist.formats.musicxml_part import GRACE_LENGTH
from roboguitarist.formats.written import (
    MAX_NOTES,
    WrittenBar,
    WrittenNote,
    WrittenPart,
    WrittenScore,
)
from roboguitarist.tablature import Technique

_STEPS = {"c": 0, "d": 2, "e": 4, "f": 5, "g": 7, "a": 9, "b": 11}
_PITCH = re.compile(r"([A-Ga-g])([#b]?)(\d)")
_START = re.compile(
    r"\s*(//[^\n]*\n\s*)*(\\(title|subtitle|artist|music|words|tempo|track|tuning|capo|ts|staff)\b|:\d)"
)
_TEXTS = ("title", "subtitle", "artist", "album", "words", "music", "copyright", "instructions",
          "notices", "tab", "instrument", "clef", "ks", "section", "tf", "ac", "simile", "ottava",
          "chord", "lyrics", "voice", "accidentals", "defaultSystemsLayout",
          "systemsLayout", "displaytranspose", "volume", "balance", "db")  # fmt: skip
_MAX_BARS = 10_000
MAX_CHARACTERS = 1_000_000


def is_alphatex(text: str) -> bool:
    """Whether a text begins like alphaTex."""
    return _START.match(text) is not None


@dataclass
class _Track:
    """One instrument, being read."""

    name: str = ""
    tuning: tuple[int, ...] | None = None
    capo: int = 0
    links: list[Linked] = field(default_factory=list)
    bars: list[WrittenBar] = field(default_factory=list)


class _Reader:
    """Goes through the text once."""

    def __init__(self, text: str) -> None:
        self._scan = Scanner(text)
        self.facts: dict[str, str] = {}
        self.tracks = [_Track()]
        self._length = Fraction(1)
        self._now = Fraction(0)
        self._grace: list[Beat] = []
        self._signature = (4, 4)
        self._open = False

    def read(self) -> None:
        """Read everything."""
        while not self._scan.at_end():
            if self._scan.take("|"):
                self._begin_bar()
                self._open = False
                continue
            if self._scan.peek() == "\\":
                self._command(self._scan.word())
            elif self._scan.take(":"):
                self._length = self._scan.duration()
            elif not self._scan.take_dot():
                self._beat()

    def _begin_bar(self) -> WrittenBar:
        """The bar that is being read; a new one behind a bar line."""
        track = self.tracks[-1]
        if not self._open:
            if len(track.bars) >= _MAX_BARS:
                raise TabError(f"more than {_MAX_BARS} bars")
            beats, beat_type = self._signature
            length = Fraction(4 * beats, beat_type)
            track.bars.append(WrittenBar(len(track.bars) + 1, length, beats, beat_type))
            self._open, self._now = True, Fraction(0)
        return track.bars[-1]

    def _change(self, **values: object) -> None:
        bar = self._begin_bar()
        self.tracks[-1].bars[-1] = replace(bar, **values)  # pyright: ignore[reportArgumentType]

    def _command(self, name: str) -> None:
        name = name.lower()
        match name:
            case "tempo":
                self._tempo(self._scan.number("tempo"))
            case "capo":
                self.tracks[-1].capo = int(self._scan.number("capo"))
            case "tuning":
                self.tracks[-1].tuning = tuple(map(_pitch, self._scan.words())) or None
            case "track":
                self._track(self._scan.string())
                self._scan.string()
            case "staff":
                self._scan.braces()
            case _ if name in map(str.lower, _TEXTS):
                self.facts.setdefault(name, self._scan.argument())
            case _:
                self._bar_command(name)

    def _bar_command(self, name: str) -> None:
        """What holds for a bar."""
        match name:
            case "ts":
                beats, beat_type = self._scan.number("beats"), self._scan.number("beat type")
                self._change_signature(_signature(int(beats), int(beat_type)))
            case "ro":
                self._change(repeat_start=True)
            case "rc":
                times = min(MAX_TIMES, max(2, int(self._scan.number("repeats"))))
                self._change(repeat_times=times)
            case "ae":
                self._change(endings=self._scan.endings())
            case "jump":
                self._jump(self._scan.words())
            case _:
                raise TabError(f"\\{name[:20]} is not read", bar=len(self.tracks[-1].bars) or 1)

    def _change_signature(self, signature: tuple[int, int]) -> None:
        self._signature = signature
        if self._open and not self._now:
            beats, beat_type = signature
            length = Fraction(4 * beats, beat_type)
            self._change(length=length, beats=beats, beat_type=beat_type)

    def _track(self, name: str) -> None:
        if self.tracks[-1].bars or self.tracks[-1].name:
            self.tracks.append(_Track())
            self._open = False
        self.tracks[-1].name = name

    def _tempo(self, tempo: Fraction) -> None:
        if not SLOWEST <= tempo <= FASTEST:
            hint = f"{SLOWEST} to {FASTEST} quarter notes a minute"
            raise TabError(f"tempo {float(tempo):g}", hint=hint)
        bar = self._begin_bar()
        self._change(tempi=(*bar.tempi, (self._now, tempo)))

    def _jump(self, words: Sequence[str]) -> None:
        word = (words or [""])[0].lower()
        signs = {"segno": "segno", "coda": "coda", "fine": "fine", "dacoda": "to_coda"}
        if word in signs:
            self._change(**{signs[word]: True})
        else:
            self._change(jump="dacapo" if word.startswith("dacapo") else "dalsegno")

    def _beat(self) -> None:
        bar = self._begin_bar()
        try:
            beat, times = read_beat(self._scan, self._length)
        except TabError as error:
            raise TabError(error.reason, bar=bar.number, hint=error.hint) from error
        self._length = beat.plain_length
        for _ in range(times):
            if beat.grace:
                self._grace.append(beat)
                continue
            for k, small in enumerate(self._grace):
                offset = self._now - (len(self._grace) - k) * GRACE_LENGTH
                self._add(small, offset, GRACE_LENGTH)
            self._grace = []
            self._add(beat, self._now, beat.length)
            self._now += beat.length

    def _add(self, beat: Beat, offset: Fraction, length: Fraction) -> None:
        track = self.tracks[-1]
        for sign in beat.notes:
            kinds = sign.techniques | beat.techniques
            kinds |= {Technique.GRACE} if beat.grace else set()
            note = WrittenNote(
                bar=len(track.bars) - 1,
                offset=offset,
                length=length,
                string=sign.string,
                fret=sign.fret if sign.fret is not None else self._tied_fret(sign.string),
                tied=sign.fret is None,
                techniques=tuple(sorted(kinds)),
                left_finger=sign.left_finger,
                right_finger=sign.right_finger,
                bend=sign.bend,
                velocity=beat.velocity,
            )
            if len(track.links) >= MAX_NOTES:
                raise TabError(f"more than {MAX_NOTES} notes")
            track.links.append(Linked(note, slurs=sign.slurs, slides=sign.slides))

    def _tied_fret(self, string: int) -> int:
        before = (link.note for link in reversed(self.tracks[-1].links[-100:]))
        return next((note.fret or 0 for note in before if note.string == string), 0)


def read(text: str) -> WrittenScore:
    """Read alphaTex.

    Raises:
        TabError: If it is broken or uses what is not read.
    """
    if len(text) > MAX_CHARACTERS:
        raise TabError("alphaTex too long", hint=f"at most {MAX_CHARACTERS} characters")
    reader = _Reader(text)
    reader.read()
    tracks = [track for track in reader.tracks if track.bars]
    parts = tuple(_part(track, k) for k, track in enumerate(tracks, 1))
    bars = max((track.bars for track in tracks), key=len, default=[])
    bars = [replace(bar, tempi=tuple(dict(bar.tempi).items())) for bar in bars]
    composer = reader.facts.get("music") or reader.facts.get("artist", "")
    return WrittenScore(tuple(bars), parts, title=reader.facts.get("title", ""), composer=composer)


def _part(track: _Track, number: int) -> WrittenPart:
    return WrittenPart(
        name=track.name or f"track {number}",
        notes=tuple(linked(track.links)),
        n_strings=len(track.tuning) if track.tuning else None,
        tuning=track.tuning if track.tuning and len(track.tuning) == 6 else None,
        capo=track.capo,
    )


def _signature(beats: int, beat_type: int) -> tuple[int, int]:
    if not 0 < beats <= 64 or beat_type not in (1, 2, 4, 8, 16, 32, 64):
        raise TabError(f"time signature {beats}/{beat_type}")
    return beats, beat_type


def _pitch(name: str) -> int:
    found = _PITCH.fullmatch(name)
    if found is None:
        raise TabError(f"{name[:9]!r} is not a pitch", hint="such as e4 or f#3")
    sharp = {"#": 1, "b": -1, "": 0}[found[2]]
    return 12 * (int(found[3]) + 1) + _STEPS[found[1].lower()] + sharp
