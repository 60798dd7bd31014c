"""From the written score to the tablature as it is played."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby, pairwise

from roboguitarist.errors import TabError
from roboguitarist.fingering.arrangement import Place, Sound, arrange, fold
from roboguitarist.formats.play_order import expand
from roboguitarist.formats.tempo_map import TempoMap, bar_starts, tempo_map
from roboguitarist.formats.written import WrittenBar, WrittenNote, WrittenPart, WrittenScore
from roboguitarist.tablature import (
    MAX_DURATION_S,
    MAX_FRET,
    N_STRINGS,
    STANDARD_TUNING,
    Bar,
    Note,
    Tablature,
    Technique,
    Tempo,
    validate,
)

MAX_PLAYED_NOTES = 50_000
MAX_WARNINGS = 100


@dataclass(frozen=True, slots=True)
class _Played:
    """A note with its times in quarter notes from the start of the piece."""

    start: Fraction
    end: Fraction
    pitch: int
    note: WrittenNote

    @property
    def given(self) -> bool:
        """Whether string and fret are written."""
        return self.note.string is not None and self.note.fret is not None


def unroll(score: WrittenScore, part: WrittenPart, warnings: Sequence[str] = ()) -> Tablature:
    """Play a part through: repeats, ties, tempo, and places for notes that have a pitch only.

    Raises:
        TabError: If it cannot be played on a guitar, or repeats make it absurdly long.
    """
    _check_places(score.bars, part)
    tuning = part.tuning or STANDARD_TUNING
    order = expand(score.bars)
    grace_lead_in = _lead_in(part, order)
    starts = bar_starts(score.bars, order, grace_lead_in)
    seconds = tempo_map(score.bars, order, starts)
    if starts and seconds(starts[-1]) > MAX_DURATION_S:
        raise TabError("the piece lasts more than four hours")
    played, clashes = _one_at_a_time(_merge_unisons(_play(part, order, starts, tuning)))
    placed, changes = _place(played, tuning, part.capo, seconds)
    remarks = _warnings(score.bars, clashes + changes)
    notes = [_note(p, place, seconds, score.bars[p.note.bar].number) for p, place in placed]
    tablature = Tablature(
        notes=tuple(sorted(_clear_for_grace(notes), key=lambda note: note.place)),
        bars=tuple(_bar(score.bars[k], seconds(s)) for k, s in zip(order, starts, strict=True)),
        tempi=tuple(Tempo(seconds(quarter), float(tempo)) for quarter, tempo in seconds.marks),
        tuning=tuning,
        capo=part.capo,
        title=score.title,
        composer=score.composer,
        source=score.source,
        grade=score.grade,
        warnings=(*warnings, *part.warnings, *remarks),
    )
    return validate(tablature)


def _check_places(bars: Sequence[WrittenBar], part: WrittenPart) -> None:
    highest = MAX_FRET - part.capo
    for note in part.notes:
        reason = ""
        if note.string is not None and not 1 <= note.string <= N_STRINGS:
            reason = f"string {note.string} (1 to {N_STRINGS})"
        elif note.fret is not None and not 0 <= note.fret <= highest:
            reason = f"fret {note.fret} (0 to {highest})"
        if reason:
            beat = float(note.offset + 1)
            raise TabError(reason, part=part.name, bar=bars[note.bar].number, beat=beat)


def _lead_in(part: WrittenPart, order: Sequence[int]) -> Fraction:
    """Time in quarter notes that grace notes before the first beat need."""
    first = (note.offset for note in part.notes if order and note.bar == order[0])
    return max(Fraction(0), -min(first, default=Fraction(0)))


def _play(
    part: WrittenPart, order: Sequence[int], starts: Sequence[Fraction], tuning: Sequence[int]
) -> list[_Played]:
    """Written notes in playing order, each chain of ties as one note."""
    by_bar = {k: list(group) for k, group in groupby(part.notes, key=lambda note: note.bar)}
    if sum(len(by_bar.get(index, ())) for index in order) > MAX_PLAYED_NOTES:
        raise TabError(f"repeats make more than {MAX_PLAYED_NOTES} notes", part=part.name)
    played: list[_Played] = []
    ending: dict[tuple[int, int, Fraction], list[int]] = defaultdict(list)
    for index, bar_start in zip(order, starts, strict=True):
        for note in sorted(by_bar.get(index, ()), key=lambda note: note.offset):
            start = bar_start + note.offset
            pitch = _pitch(note, tuning, part.capo)
            end = start + note.length
            tied = ending[note.voice, pitch, start] if note.tied else []
            if tied:
                same = [k for k in tied if played[k].note.string == note.string]
                k = (same or tied)[0]
                tied.remove(k)
                played[k] = replace(played[k], end=end)
            else:
                k = len(played)
                played.append(_Played(start, end, pitch, note))
            ending[note.voice, pitch, end].append(k)
    return sorted(played, key=lambda p: p.start)


def _pitch(note: WrittenNote, tuning: Sequence[int], capo: int) -> int:
    """What string and fret give, else the written pitch."""
    if note.string is not None and note.fret is not None:
        return tuning[note.string - 1] + capo + note.fret
    return note.pitch or 0


def _merge_unisons(played: list[_Played]) -> list[_Played]:
    """Make one note of a pitch that two voices begin together, or that a string has twice."""
    merged: list[_Played] = []
    for _, group in groupby(played, key=lambda p: p.start):
        places: dict[tuple[int | None, int | None], int] = {}
        pitches: dict[int, int] = {}
        for p in sorted(group, key=lambda p: not p.given):
            place = p.note.string, p.note.fret
            twin = places.get(place) if p.given else pitches.get(p.pitch)
            if twin is not None and (p.given or merged[twin].note.voice != p.note.voice):
                merged[twin] = _join(merged[twin], p)
                continue
            pitches.setdefault(p.pitch, len(merged))
            if p.given:
                places[place] = len(merged)
            merged.append(p)
    return merged


def _join(a: _Played, b: _Played) -> _Played:
    note = replace(
        a.note,
        techniques=tuple(sorted({*a.note.techniques, *b.note.techniques})),
        left_finger=b.note.left_finger if a.note.left_finger is None else a.note.left_finger,
        right_finger=a.note.right_finger or b.note.right_finger,
        bend=a.note.bend or b.note.bend,
        velocity=a.note.velocity or b.note.velocity,
    )
    return replace(a, end=max(a.end, b.end), note=note)


_Remarks = list[tuple[WrittenNote, str]]


def _warnings(bars: Sequence[WrittenBar], remarks: _Remarks) -> list[str]:
    """One line for each remark, repeated bars once, at most `MAX_WARNINGS`."""
    lines = {
        f"bar {bars[note.bar].number}, beat {float(note.offset + 1):g}: {what}": None
        for note, what in remarks
    }
    shown = list(lines)[:MAX_WARNINGS]
    more = len(lines) - len(shown)
    return [*shown, f"and {more} more of this kind"] if more else shown


def _one_at_a_time(played: list[_Played]) -> tuple[list[_Played], _Remarks]:
    """Of several notes on one string at once, free all but the highest from that string."""
    result: list[_Played] = []
    remarks: _Remarks = []
    for _, group in groupby(played, key=lambda p: p.start):
        taken: set[int | None] = set()
        for p in sorted(group, key=lambda p: -p.pitch):
            note = p.note
            if p.given and note.string in taken:
                remarks.append((note, f"two notes on string {note.string}, one is moved"))
                note = replace(note, string=None, fret=None)
            elif p.given:
                taken.add(note.string)
            result.append(p if note is p.note else replace(p, note=note))
    return result, remarks


def _place(
    played: list[_Played], tuning: Sequence[int], capo: int, seconds: TempoMap
) -> tuple[list[tuple[_Played, Place]], _Remarks]:
    """Give a string and a fret to notes that lack one; say what had to be changed."""
    remarks: _Remarks = []
    sounds = []
    for p in played:
        note, pitch = p.note, p.pitch if p.given else fold(p.pitch, tuning, capo)
        if pitch != p.pitch:
            remarks.append((note, f"pitch {p.pitch} is out of range, {pitch} is played"))
        times = seconds(p.start), seconds(p.end)
        sounds.append(Sound(*times, pitch, note.string, note.fret, note.left_finger))
    placed = []
    for p, place in zip(played, arrange(sounds, tuning, capo), strict=True):
        if place is None:
            remarks.append((p.note, f"pitch {p.pitch} left out, no string in reach is free"))
        else:
            placed.append((p, place))
    return placed, remarks


def _bar(bar: WrittenBar, onset_s: float) -> Bar:
    return Bar(onset_s, bar.number, bar.beats, bar.beat_type)


def _note(p: _Played, place: Place, seconds: TempoMap, bar: int) -> Note:
    onset = seconds(p.start)
    return Note(
        onset_s=onset,
        string=place.string,
        fret=place.fret,
        duration_s=round(seconds(p.end) - onset, 6),
        bar=bar,
        beat=round(float(p.note.offset + 1), 6),
        voice=p.note.voice,
        techniques=p.note.techniques,
        left_finger=p.note.left_finger,
        right_finger=p.note.right_finger,
        bend=p.note.bend,
        velocity=p.note.velocity,
    )


def _clear_for_grace(notes: Sequence[Note]) -> list[Note]:
    """End a note where a grace note on its string begins."""
    result = sorted(notes, key=lambda note: (note.string, note.onset_s))
    for k, (note, following) in enumerate(pairwise(result)):
        overlap = note.string == following.string and note.end_s > following.onset_s
        if overlap and Technique.GRACE in following.techniques:
            result[k] = replace(note, duration_s=round(following.onset_s - note.onset_s, 6))
    return result
