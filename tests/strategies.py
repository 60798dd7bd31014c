"""Hypothesis strategies that several test modules share."""

from __future__ import annotations

from itertools import accumulate

from hypothesis import strategies as st

from roboguitarist.tablature import (
    N_STRINGS,
    STANDARD_TUNING,
    Bar,
    Note,
    Tablature,
    Technique,
    Tempo,
)

_TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=12)


def _microseconds(low: int, high: int) -> st.SearchStrategy[float]:
    return st.integers(low, high).map(lambda n: n / 1_000_000)


@st.composite
def notes(draw: st.DrawFn, *, onset_s: float | None = None, max_fret: int = 12) -> Note:
    """One note, at `onset_s` if given, up to `max_fret`."""
    onset = draw(_microseconds(0, 60_000_000)) if onset_s is None else onset_s
    return Note(
        onset_s=onset,
        string=draw(st.integers(1, N_STRINGS)),
        fret=draw(st.integers(0, max_fret)),
        duration_s=draw(_microseconds(50_000, 2_000_000)),
        bar=draw(st.integers(0, 99)),
        beat=draw(st.integers(4, 20)) / 4,
        voice=draw(st.integers(1, 4)),
        techniques=tuple(sorted(draw(st.sets(st.sampled_from(Technique), max_size=2)))),
        left_finger=draw(st.none() | st.integers(0, 4)),
        right_finger=draw(st.none() | st.sampled_from("pima")),
        bend=draw(st.sampled_from([(), ((0.0, 0.0), (0.5, 2.0)), ((0.0, 1.0), (1.0, 0.0))])),
        velocity=draw(st.none() | st.integers(1, 127)),
    )


@st.composite
def tablatures(
    draw: st.DrawFn, *, min_notes: int = 0, max_notes: int = 20, max_fret: int = 12, chord: int = 3
) -> Tablature:
    """A valid tablature with up to `chord` notes at each onset."""
    wanted = draw(st.integers(min_notes, max_notes))
    found: list[Note] = []
    onset = 0.0
    while len(found) < wanted:
        size = draw(st.integers(1, min(chord, wanted - len(found), N_STRINGS)))
        strings = draw(st.permutations(range(1, N_STRINGS + 1)))[:size]
        for string in sorted(strings):
            note = draw(notes(onset_s=round(onset, 6), max_fret=max_fret))
            found.append(_on_string(note, string))
        onset += draw(_microseconds(60_000, 1_000_000))
    steps = draw(st.lists(_microseconds(500_000, 4_000_000), max_size=5))
    bar_onsets = [round(x, 6) for x in accumulate(steps, initial=0.0)]
    return Tablature(
        notes=tuple(found),
        bars=tuple(Bar(x, k, draw(st.integers(1, 12)), 4) for k, x in enumerate(bar_onsets, 1)),
        tempi=(Tempo(0.0, draw(st.integers(40, 240)) * 1.0),),
        tuning=draw(st.sampled_from([STANDARD_TUNING, (64, 59, 55, 50, 45, 38)])),
        capo=draw(st.integers(0, 5)),
        title=draw(_TEXT),
        composer=draw(_TEXT),
        source=draw(_TEXT),
    )


def _on_string(note: Note, string: int) -> Note:
    values = {name: getattr(note, name) for name in Note.__dataclass_fields__}
    return Note(**{**values, "string": string})
