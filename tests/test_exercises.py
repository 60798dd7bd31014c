from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import groupby, islice, pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist import exercises, formats, pieces
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.exercises import KINDS, ExerciseConfig, Kind, generate, stream
from roboguitarist.exercises.shapes import (
    BARRE_CHORDS,
    GRIPS,
    OPEN_CHORDS,
    POWER_CHORDS,
    Shape,
    read,
)
from roboguitarist.exercises.sheet import playable
from roboguitarist.fingering import assign
from roboguitarist.tablature import Note, Tablature, validate

SEEDS = range(24)
EVERY_KIND = pytest.mark.parametrize("kind", KINDS)
MOVABLE = (*BARRE_CHORDS, *POWER_CHORDS, *GRIPS)
configs = st.builds(
    ExerciseConfig,
    tempo=st.tuples(st.integers(40, 120), st.integers(120, 200)),
    bars=st.tuples(st.integers(1, 4), st.integers(4, 8)),
    duration_s=st.none() | st.floats(1, 20),
    highest_fret=st.integers(5, 20),
)


@cache
def sample(kind: Kind) -> tuple[Tablature, ...]:
    return tuple(generate(kind, seed) for seed in SEEDS)


def onsets(tablature: Tablature) -> list[list[Note]]:
    """Notes that start together, in order of time."""
    return [list(group) for _, group in groupby(tablature.notes, lambda note: note.onset_s)]


def places(notes: list[Note]) -> frozenset[tuple[int, int]]:
    return frozenset((note.string, note.fret) for note in notes)


def notes_of(shape: Shape) -> tuple[Note, ...]:
    return tuple(Note(0.0, s, fret, 1.0, left_finger=f or None) for s, fret, f in shape.stops)


def intervals(kind: Kind) -> set[tuple[int, ...]]:
    """Semitones above the lowest note, of every onset of the sample."""
    found = set()
    for tablature in sample(kind):
        for notes in onsets(tablature):
            pitches = sorted(tablature.pitch(note) for note in notes)
            found.add(tuple(pitch - pitches[0] for pitch in pitches[1:]))
    return found


@given(st.sampled_from(KINDS), st.integers(0, 2**40), configs)
@settings(max_examples=40, deadline=None)
def test_every_exercise_is_sound_and_playable(kind: Kind, seed: int, config: ExerciseConfig):
    tablature = validate(generate(kind, seed, config))
    assert tablature == generate(kind, seed, config)
    assert tablature.title == f"{kind}, seed {seed}"
    assert tablature.notes
    assert tablature.notes[0].onset_s == 0
    assert max(note.fret for note in tablature.notes) <= config.highest_fret
    assert config.tempo[0] <= tablature.tempi[0].quarters_per_minute <= config.tempo[1]
    for string in range(1, 7):
        alone = [note for note in tablature.notes if note.string == string]
        assert all(a.end_s <= b.onset_s + 1e-9 for a, b in pairwise(alone))
    fingering = assign(tablature)
    assert not fingering.problems
    assert fingering.left.min() >= 0


@given(st.sampled_from(KINDS), st.integers(0, 1000), st.floats(1, 30))
@settings(max_examples=20, deadline=None)
def test_a_length_in_seconds_is_kept(kind: Kind, seed: int, duration_s: float):
    tablature = generate(kind, seed, ExerciseConfig(duration_s=duration_s))
    assert tablature.duration_s <= duration_s + 1e-6
    bar_s = 240 / tablature.tempi[0].quarters_per_minute
    assert len(tablature.bars) == np.ceil(duration_s / bar_s - 1e-9)


@EVERY_KIND
def test_notes_say_the_bar_and_beat_where_they_are(kind: Kind):
    for tablature in sample(kind)[:6]:
        quarter_s = 60 / tablature.tempi[0].quarters_per_minute
        for note in tablature.notes:
            written_s = (4 * (note.bar - 1) + note.beat - 1) * quarter_s
            assert note.onset_s == pytest.approx(written_s, abs=1e-5)
            assert tablature.bars[note.bar - 1].onset_s <= note.onset_s + 1e-6


@EVERY_KIND
def test_seeds_differ(kind: Kind):
    assert len({tablature.notes for tablature in sample(kind)}) == len(SEEDS)


def test_a_stream_can_be_made_again_from_its_titles():
    first = list(islice(stream(3), 20))
    assert first == list(islice(stream(3), 20))
    assert first != list(islice(stream(4), 20))
    for tablature in first:
        kind, seed = tablature.title.split(", seed ")
        assert tablature == generate(kind, int(seed))
    assert len({tablature.title.split(",")[0] for tablature in first}) > 6


def test_a_stream_keeps_to_its_kinds_and_limits():
    config = ExerciseConfig(tempo=(90, 90), bars=(2, 2), highest_fret=7)
    for tablature in islice(stream(0, ["scales", Kind.DYADS], config), 10):
        assert tablature.title.startswith(("scales", "dyads"))
        assert tablature.tempi[0].quarters_per_minute == 90
        assert len(tablature.bars) == 2
        assert max(note.fret for note in tablature.notes) <= 7


FRETS = {
    Kind.OPEN_CHORDS: (0, 0, 3, 4),
    Kind.LOW_LINES: (0, 0, 5, 6),
    Kind.HIGH_LINES: (7, 7, 15, 15),
}


@EVERY_KIND
def test_every_kind_reaches_its_part_of_the_neck(kind: Kind):
    notes = [note for tablature in sample(kind) for note in tablature.notes]
    lowest, at_least, at_most, highest = FRETS.get(kind, (0, 2, 12, 15))
    frets = [note.fret for note in notes]
    assert lowest <= min(frets) <= at_least
    assert at_most <= max(frets) <= highest
    shares = np.bincount([note.string for note in notes], minlength=7)[1:] / len(notes)
    assert shares.min() > 0.02


@EVERY_KIND
def test_tempo_and_length_vary(kind: Kind):
    tempi = [tablature.tempi[0].quarters_per_minute for tablature in sample(kind)]
    bars = [len(tablature.bars) for tablature in sample(kind)]
    assert 40 <= min(tempi) < 80
    assert 160 < max(tempi) <= 200
    assert 4 <= min(bars) < 7
    assert 13 < max(bars) <= 16


def test_rests_staccato_and_legato_all_come():
    gaps = []
    for kind in (Kind.SCALES, Kind.LOW_LINES, Kind.HIGH_LINES):
        for tablature in sample(kind):
            held = [(a.duration_s, b.onset_s - a.onset_s) for a, b in pairwise(tablature.notes)]
            gaps.append(np.mean([duration / step for duration, step in held]))
            assert all(duration >= min(0.1, step) - 2e-6 for duration, step in held)
    assert max(gaps) == pytest.approx(1)
    assert min(gaps) < 0.5


@pytest.mark.parametrize(
    "kind", [Kind.SCALES, Kind.LOW_LINES, Kind.HIGH_LINES, Kind.REPEATED_NOTES, Kind.ARPEGGIOS]
)
def test_single_notes_come_at_most_six_a_second(kind: Kind):
    steps = [b.onset_s - a.onset_s for t in sample(kind) for a, b in pairwise(t.notes)]
    assert 1 / 6 - 2e-6 <= min(steps) < 1 / 4


def test_a_scale_stays_in_one_position():
    sizes = set()
    for tablature in sample(Kind.SCALES):
        frets = [note.fret for note in tablature.notes]
        assert max(frets) - min(frets) <= 4
        sizes.add(len({tablature.pitch(note) % 12 for note in tablature.notes}))
    assert {7, 12} <= sizes


def test_a_scale_leaves_no_note_out():
    for position in range(12):
        found = exercises.lines.in_position(0, tuple(range(12)), position, stretch=True)
        pitches = [Tablature(()).pitch(Note(0, *place, 1)) for place in found]
        assert pitches == list(range(40 + position, 64 + position + 4))


def test_shifts_repeat_one_phrase_with_one_fingering():
    for tablature in sample(Kind.POSITION_SHIFTS):
        fingers = {(n.string, n.left_finger) for n in tablature.notes}
        assert len(fingers) <= 6
        assert all(n.left_finger is not None for n in tablature.notes)
    positions = {
        n.fret - n.left_finger + 1
        for t in sample(Kind.POSITION_SHIFTS)
        for n in t.notes
        if n.left_finger
    }
    assert positions == set(range(1, 13))


def test_basses_alternate_under_a_melody():
    moves = []
    for tablature in sample(Kind.MELODY_OVER_BASS):
        basses = [note for note in tablature.notes if note.string > 3]
        assert 0 < len(basses) < len(tablature.notes)
        moves += [a.string != b.string for a, b in pairwise(basses)]
    assert np.mean(moves) > 0.8  # a rest may take one


def test_repeated_notes_repeat():
    for tablature in sample(Kind.REPEATED_NOTES):
        same = [(a.string, a.fret) == (b.string, b.fret) for a, b in pairwise(tablature.notes)]
        assert 0.3 < np.mean(same) < 1


def test_dyads_and_power_chords_have_their_intervals():
    assert intervals(Kind.DYADS) == {(3,), (4,), (8,), (9,), (12,)}
    assert intervals(Kind.POWER_CHORDS) == {(7,), (7, 12)}


def test_barre_chords_are_fingered_with_a_barre():
    frets, widths = set(), set()
    for tablature in sample(Kind.BARRE_CHORDS):
        fingering = assign(tablature)
        for notes in onsets(tablature):
            first = tablature.notes.index(notes[0])
            flat = [n.string for k, n in enumerate(notes, first) if fingering.barre[k]]
            assert len(flat) > 1
            widths.add(max(flat) - min(flat) + 1)
            frets.add(min(note.fret for note in notes))
    assert frets == set(range(1, 13))
    assert widths == {2, 3, 4, 5, 6}


def test_random_shapes_take_one_to_four_fingers_within_four_frets():
    fingers, shared = set(), 0
    for tablature in sample(Kind.RANDOM_SHAPES):
        for notes in onsets(tablature):
            frets = [note.fret for note in notes if note.fret]
            assert max(frets) - min(frets) <= 3
            fingers.add(frozenset(n.left_finger for n in notes if n.left_finger))
            shared += len(set(frets)) < len(frets)
    assert len(fingers) == 15
    assert shared > 20


def test_fast_changes_are_faster_than_slow_ones():
    def seconds_per_shape(kind: Kind) -> list[float]:
        return [
            t.duration_s / sum(places(a) != places(b) for a, b in pairwise(onsets(t)))
            for t in sample(kind)
            if len({places(notes) for notes in onsets(t)}) > 1
        ]

    assert np.median(seconds_per_shape(Kind.SLOW_CHANGES)) > 2
    assert np.median(seconds_per_shape(Kind.FAST_CHANGES)) < 1


def test_a_mixed_exercise_has_lines_and_chords():
    sizes = [len(notes) for t in sample(Kind.MIXED) for notes in onsets(t)]
    assert {1, 2, 3, 4, 6} <= set(sizes)


QUALITIES = {
    "": {0, 4, 7}, "m": {0, 3, 7}, "7": {0, 4, 7, 10}, "m7": {0, 3, 7, 10}, "maj7": {0, 4, 7, 11},
    "5": {0, 7}, "sus2": {0, 2, 7}, "sus4": {0, 5, 7}, "7sus4": {0, 5, 7, 10}, "m6": {0, 3, 7, 9},
    "add9": {0, 2, 4, 7}, "9": {0, 2, 4, 7, 10}, "m7b5": {0, 3, 6, 10}, "dim7": {0, 3, 6, 9},
}  # fmt: skip
PITCHES = {"C": 0, "D": 2, "E": 4, "F": 5, "G": 7, "A": 9, "B": 11}


@pytest.mark.parametrize("shape", [*OPEN_CHORDS, *MOVABLE], ids=lambda shape: shape.name)
def test_a_shape_sounds_the_chord_of_its_name(shape: Shape):
    name = shape.name.partition("/")[0]
    accidental = name[1:2] if name[1:2] in ("b", "#") else ""
    root = PITCHES[name[0]] + {"": 0, "b": -1, "#": 1}[accidental]
    chord = QUALITIES[name[1 + len(accidental) :]]
    tablature = Tablature(notes_of(shape))
    sounding = {(tablature.pitch(note) - root) % 12 for note in tablature.notes}
    assert chord - {7} <= sounding <= chord  # the fifth may be left out


@pytest.mark.parametrize("shape", MOVABLE, ids=lambda shape: shape.name)
def test_a_movable_shape_moves_along_the_neck(shape: Shape):
    assert min(fret for _, fret, _ in shape.stops) == 1
    for root in (1 if shape.positions else 2, 7, 12):
        assert assign(Tablature(notes_of(shape.at(root)))).problems == ()
        assert shape.at(root).positions
    assert {(s, f) for s, f, _ in shape.stops} - {(s, f) for s, f, _ in shape.at(2).stops}


@pytest.mark.parametrize("shape", OPEN_CHORDS, ids=lambda shape: shape.name)
def test_an_open_chord_is_played_with_its_usual_fingers(shape: Shape):
    fingering = assign(Tablature(notes_of(shape)))
    assert fingering.left.tolist() == [finger for _, _, finger in shape.stops]


def test_a_chord_diagram_is_read_from_string_6():
    shape = read("F xx3211 xx3211")
    assert shape.stops == ((1, 1, 1), (2, 1, 1), (3, 2, 2), (4, 3, 3))
    assert (shape.highest_fret, shape.barres) == (3, {1})
    assert shape.at(5).stops[0] == (1, 5, 1)
    assert len({shape.name for shape in OPEN_CHORDS}) >= 20


def test_what_no_hand_can_play_is_taken_out():
    notes = (Note(0, 1, 1, 1.0, left_finger=4), Note(0, 2, 12, 1.0), Note(2, 3, 5, 1.0))
    impossible = Tablature(notes)
    assert assign(impossible).problems
    mended = playable(impossible)
    assert not assign(mended).problems
    assert len(mended.notes) == 2
    assert playable(mended) == mended


def test_nothing_of_the_repertoire_appears():
    def windows(tablature: Tablature) -> set[tuple]:
        row = [places(notes) for notes in onsets(tablature)]
        return {tuple(row[k : k + 8]) for k in range(len(row) - 7)}

    kept = set().union(*(windows(formats.load(pieces.path(name))) for name in pieces.names()))
    assert kept
    for kind in KINDS:
        for tablature in sample(kind):
            assert not windows(tablature) & kept, tablature.title


def test_the_page_names_every_kind_and_its_code_runs():
    page = (Path(__file__).parents[1] / "docs" / "exercises.md").read_text(encoding="utf-8")
    assert [line.split("`")[1] for line in page.splitlines() if line.startswith("| `")] == [*KINDS]
    names: dict = {}
    exec(page.split("```python\n")[1].split("```")[0], names)
    assert isinstance(names["study"], Tablature)


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        (lambda: generate("yodelling", 0), "yodelling.*scales"),
        (lambda: generate("scales", -1), "seed -1"),
        (lambda: stream(0, []), "no kind"),
        (lambda: stream(0, ["scales", "polka"]), "polka"),
        (lambda: stream(-1), "seed -1"),
        (lambda: ExerciseConfig(tempo=(30, 90)), "tempo 30 to 90"),
        (lambda: ExerciseConfig(bars=(9, 8)), "9 to 8 bars"),
        (lambda: ExerciseConfig(duration_s=float("nan")), "duration"),
        (lambda: replace(ExerciseConfig(), highest_fret=4), "highest fret 4"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(wrong, named: str):
    with pytest.raises(RoboGuitaristError, match=named):
        wrong()
