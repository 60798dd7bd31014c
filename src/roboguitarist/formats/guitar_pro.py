"""Files of Guitar Pro 3 to 5 to the score as written, through PyGuitarPro.

That library is an optional extra: `pip install roboguitarist[guitarpro]`.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from types import ModuleType
from typing import Any

from roboguitarist.errors import TabError
from roboguitarist.formats.guitar_pro_notes import notes_of
from roboguitarist.formats.linked import Linked, linked
from roboguitarist.formats.midi import BASS_PROGRAMS
from roboguitarist.formats.musicxml_bars import FASTEST, MAX_TIMES, SLOWEST
from roboguitarist.formats.note_values import dotted
from roboguitarist.formats.written import WrittenBar, WrittenPart, WrittenScore

MAGIC = (b"FICHIER GUITAR PRO", b"CLIPBOARD G")
MAX_BYTES = 2_000_000
MAX_READS = 1_500_000
MAX_READS_BEHIND_END = 1000
_HIGHEST_BASS_STRING = 52
_Tempi = dict[int, dict[Fraction, Fraction]]


class _BoundedFile(io.BytesIO):
    """Bytes that refuse to be read for ever, as a broken count of bars or notes would have it."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        self._reads = self._behind = 0

    def read(self, size: int | None = -1, /) -> bytes:
        found = super().read(max(0, size or 0))
        self._reads += 1
        self._behind += len(found) < (size or 0)
        if self._reads > MAX_READS or self._behind > MAX_READS_BEHIND_END:
            raise TabError("broken Guitar Pro file: it goes on for ever")
        return found


def read(data: bytes) -> WrittenScore:
    """Read a file of Guitar Pro 3, 4 or 5.

    Raises:
        TabError: If PyGuitarPro is not installed, or the file is broken or makes no sense.
    """
    if len(data) > MAX_BYTES:
        raise TabError("Guitar Pro file too large", hint=f"at most {MAX_BYTES // 10**6} MB")
    song = _parsed(_library(), data)
    tempi: _Tempi = {}
    parts = [_part(track, tempi) for track in song.tracks]
    bars = tuple(_bars(song, tempi))
    return WrittenScore(bars, tuple(parts), title=song.title, composer=song.music or song.artist)


def _library() -> ModuleType:
    try:
        import guitarpro  # noqa: PLC0415 - an optional extra
    except ImportError as error:
        hint = "pip install 'roboguitarist[guitarpro]', or save it as .gp or MusicXML"
        raise TabError("PyGuitarPro is needed for this file", hint=hint) from error
    return guitarpro


def _parsed(guitarpro: ModuleType, data: bytes) -> Any:
    try:
        return guitarpro.parse(_BoundedFile(data))
    except TabError:
        raise
    except Exception as error:  # what PyGuitarPro raises on broken files is of any kind
        reason = " ".join(str(error).split())[:80] or type(error).__name__
        raise TabError(f"broken Guitar Pro file: {reason}") from error


def _part(track: Any, tempi: _Tempi) -> WrittenPart:
    tuning = tuple(string.value for string in track.strings)
    links: list[Linked] = []
    for index, measure in enumerate(track.measures):
        for voice, content in enumerate(measure.voices, 1):
            now = Fraction(0)
            for beat in content.beats:
                length = _length(beat.duration, index + 1) if beat.status.value else Fraction(0)
                change = beat.effect.mixTableChange
                if change is not None and change.tempo is not None:
                    tempo = _tempo(change.tempo.value, index + 1)
                    tempi.setdefault(index, {})[now] = tempo
                links.extend(notes_of(beat, (index, voice), (now, length)))
                now += length
    return WrittenPart(
        name=track.name or f"track {track.number}",
        notes=tuple(linked(links)),
        n_strings=len(tuning) or None,
        tuning=tuning if len(tuning) == 6 else None,
        capo=max(0, track.offset),
        obstacle=_obstacle(track, tuning),
    )


def _length(duration: Any, bar: int) -> Fraction:
    tuplet = duration.tuplet
    if duration.value <= 0 or tuplet.enters <= 0 or tuplet.times <= 0:
        raise TabError("a duration that makes no sense", bar=bar)
    whole = dotted(Fraction(4, duration.value), int(duration.isDotted))
    return whole * tuplet.times / tuplet.enters


def _tempo(quarters_per_minute: int, bar: int) -> Fraction:
    if not SLOWEST <= quarters_per_minute <= FASTEST:
        hint = f"{SLOWEST} to {FASTEST} quarter notes a minute"
        raise TabError(f"tempo {quarters_per_minute}", bar=bar, hint=hint)
    return Fraction(quarters_per_minute)


def _obstacle(track: Any, tuning: Sequence[int]) -> str:
    if track.isPercussionTrack or track.channel.isPercussionChannel:
        return "it is a drum part"
    if tuning and tuning[0] < _HIGHEST_BASS_STRING:
        return "it is a bass part"
    if not tuning and track.channel.instrument in BASS_PROGRAMS:
        return "it is a bass part"
    return ""


def _bars(song: Any, tempi: _Tempi) -> Iterator[WrittenBar]:
    first = tempi.setdefault(0, {})
    first.setdefault(Fraction(0), _tempo(song.tempo, 1))
    ending: frozenset[int] = frozenset()
    for index, header in enumerate(song.measureHeaders):
        bar = _bar(index, header)
        ending = bar.endings or (frozenset() if bar.repeat_start else ending)
        marks = tuple(sorted(tempi.get(index, {}).items()))
        yield replace(bar, endings=ending, tempi=marks)
        ending = frozenset() if bar.repeat_times else ending


def _bar(index: int, header: Any) -> WrittenBar:
    beats, beat_type = header.timeSignature.numerator, header.timeSignature.denominator.value
    if not 0 < beats <= 64 or not 0 < beat_type <= 64:
        raise TabError(f"time signature {beats}/{beat_type}", bar=index + 1)
    signs = {sign.name for sign in (header.direction, header.fromDirection) if sign is not None}
    jumps = {name.partition(" al ")[0] for name in signs}
    jump = "dacapo" if "Da Capo" in jumps else "dalsegno" if "Da Segno" in jumps else ""
    return WrittenBar(
        number=index + 1,
        length=Fraction(4 * beats, beat_type),
        beats=beats,
        beat_type=beat_type,
        repeat_start=header.isRepeatOpen,
        repeat_times=min(MAX_TIMES, max(2, header.repeatClose + 1))
        if header.repeatClose > 0
        else 0,
        endings=frozenset(k + 1 for k in range(8) if header.repeatAlternative >> k & 1),
        segno="Segno" in signs,
        coda="Coda" in signs,
        fine="Fine" in signs,
        to_coda="Da Coda" in signs,
        jump=jump,
    )
