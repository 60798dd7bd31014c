import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist.fingering.arrangement import N_FRETS, STRETCH, Sound, arrange, fold
from roboguitarist.tablature import STANDARD_TUNING

steady = settings(deadline=None)

PITCHES = st.integers(40, 84)
DROP_D = (64, 59, 55, 50, 45, 38)


def chord(*pitches, onset=0.0):
    return [Sound(onset, onset + 1, pitch) for pitch in pitches]


def line(*pitches):
    return [Sound(k, k + 1, pitch) for k, pitch in enumerate(pitches)]


def places(sounds, **settings):
    return [place and (place.string, place.fret) for place in arrange(sounds, **settings)]


@st.composite
def pieces(draw):
    sounds = []
    for onset in range(draw(st.integers(0, 6))):
        for pitch in draw(st.lists(PITCHES, min_size=1, max_size=5, unique=True)):
            sounds.append(Sound(onset, onset + draw(st.integers(1, 3)), pitch))
    return sounds


@steady
@given(pieces(), st.sampled_from([STANDARD_TUNING, DROP_D]), st.integers(0, 5))
def test_every_place_sounds_its_pitch_within_one_hands_reach(sounds, tuning, capo):
    found = arrange(sounds, tuning, capo)
    assert len(found) == len(sounds)
    for sound, place in zip(sounds, found, strict=True):
        if place is not None:
            assert tuning[place.string - 1] + capo + place.fret == sound.pitch
            assert 0 <= place.fret <= N_FRETS - capo
    for onset in {sound.onset_s for sound in sounds}:
        shape = [p for s, p in zip(sounds, found, strict=True) if s.onset_s == onset and p]
        assert len({place.string for place in shape}) == len(shape)
        stopped = [place.fret for place in shape if place.fret]
        assert not stopped or max(stopped) - min(stopped) <= STRETCH


@steady
@given(st.lists(PITCHES, min_size=1, max_size=12))
def test_a_single_line_loses_no_note(pitches):
    assert None not in arrange(line(*pitches))


@steady
@given(st.lists(st.integers(40, 79), min_size=1, max_size=8))
def test_the_same_line_between_higher_strings_is_played_at_the_same_places(pitches):
    higher = [pitch + 2 for pitch in STANDARD_TUNING]
    moved = arrange(line(*(pitch + 2 for pitch in pitches)), higher)
    assert moved == arrange(line(*pitches))


@steady
@given(st.integers(0, 127), st.sampled_from([STANDARD_TUNING, DROP_D]), st.integers(0, 7))
def test_folding_keeps_the_pitch_class_and_reaches_the_neck(pitch, tuning, capo):
    folded = fold(pitch, tuning, capo)
    assert (folded - pitch) % 12 == 0
    assert min(tuning) + capo <= folded <= max(tuning) + N_FRETS
    assert fold(folded, tuning, capo) == folded


@pytest.mark.parametrize(
    ("pitches", "frets"),
    [
        ((40, 47, 52, 56, 59, 64), {6: 0, 5: 2, 4: 2, 3: 1, 2: 0, 1: 0}),  # E
        ((48, 52, 55, 60, 64), {5: 3, 4: 2, 3: 0, 2: 1, 1: 0}),  # C
        ((43, 47, 50, 55, 59, 67), {6: 3, 5: 2, 4: 0, 3: 0, 2: 0, 1: 3}),  # G
        ((50, 57, 62, 66), {4: 0, 3: 2, 2: 3, 1: 2}),  # D
        ((41, 48, 53, 57, 60, 65), {6: 1, 5: 3, 4: 3, 3: 2, 2: 1, 1: 1}),  # F, barre
    ],
)
def test_chords_take_their_usual_shapes(pitches, frets):
    assert {place[0]: place[1] for place in places(chord(*pitches)) if place} == frets


def test_the_c_major_scale_stays_in_the_open_position():
    scale = (48, 50, 52, 53, 55, 57, 59, 60, 62, 64)
    frets = [place.fret for place in arrange(line(*scale)) if place]
    assert frets == [3, 0, 2, 3, 0, 2, 0, 1, 3, 0]


def test_a_ringing_string_is_left_alone():
    bass = Sound(0, 4, 45)
    melody = [Sound(k, k + 1, pitch) for k, pitch in ((0, 64), (1, 47), (2, 64))]
    found = [place for place in arrange([bass, *melody]) if place]
    assert found[2].string != found[0].string
    assert found[3] == found[1]


def test_given_places_are_kept_and_others_go_around_them():
    sounds = [Sound(0, 1, 64, string=2, fret=5), Sound(0, 1, 59)]
    assert places(sounds) == [(2, 5), (3, 4)]


def test_a_given_stretch_is_accepted():
    sounds = [Sound(0, 1, 41, 6, 1), Sound(0, 1, 73, 1, 9)]
    assert places(sounds) == [(6, 1), (1, 9)]


@pytest.mark.parametrize(("string", "fret"), [(1, 0), (2, 5), (3, 9), (4, 14)])
def test_a_string_number_alone_is_followed(string, fret):
    assert places([Sound(0, 1, 64, string=string)]) == [(string, fret)]


def test_an_impossible_string_number_is_not():
    assert places([Sound(0, 1, 64, string=1, finger=0), Sound(1, 2, 41, string=1)])[1] == (6, 1)


@pytest.mark.parametrize(("finger", "fret"), [(0, 0), (4, 5), (None, 0)])
def test_a_marked_finger_tells_open_from_stopped(finger, fret):
    (place,) = arrange([Sound(0, 1, 59, finger=finger)])
    assert place
    assert (place.fret == 0) == (fret == 0)


def test_what_does_not_fit_is_left_out_but_not_melody_and_bass():
    pitches = (40, 52, 55, 57, 59, 62, 64, 67)
    found = arrange(chord(*pitches))
    assert found[0] is not None
    assert found[-1] is not None
    assert found.count(None) >= 2
    assert places(chord(40, 41)) == [None, (6, 1)]


def test_no_notes_need_no_places():
    assert arrange([]) == []
