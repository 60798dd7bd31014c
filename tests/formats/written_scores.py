"""Scores as they are written, for tests of what is made of them."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import strategies as st

from roboguitarist.formats.written import WrittenBar, WrittenNote, WrittenPart, WrittenScore
from roboguitarist.tablature import STANDARD_TUNING, Technique

LENGTHS = [Fraction(n, d) for n, d in ((1, 1), (1, 2), (1, 4), (3, 2), (1, 3), (2, 5), (4, 1))]
CURVES = [(), ((0.0, 0.0), (0.5, 2.0)), ((0.0, 1.0), (0.25, 1.0), (1.0, 0.0)), ((0.0, 2.0),)]
TEMPI = [Fraction(60), Fraction(120), Fraction("88.5"), Fraction(60_000_000, 857_143)]


@st.composite
def notes(draw: st.DrawFn, bar: int, length: Fraction, voice: int) -> list[WrittenNote]:
    """Notes and rests of one voice, filling a bar; some chords, some grace notes."""
    found: list[WrittenNote] = []
    now = Fraction(0)
    while now < length:
        step = min(draw(st.sampled_from(LENGTHS)), length - now)
        strings = draw(st.lists(st.integers(1, 6), max_size=3, unique=True))
        grace = draw(st.integers(0, 9)) == 0 and len(strings) == 1
        for string in strings:
            if grace:
                lead = WrittenNote(bar, now - Fraction(1, 8), Fraction(1, 8), string=string, fret=2)
                found.append(_marked(draw, lead, {Technique.GRACE}, voice))
            plain = WrittenNote(bar, now, step, string=string, fret=draw(st.integers(0, 12)))
            found.append(_marked(draw, plain, set(), voice))
        now += step
    return found


def _marked(draw: st.DrawFn, note: WrittenNote, kinds: set[Technique], voice: int) -> WrittenNote:
    kinds = kinds | draw(
        st.sets(st.sampled_from(sorted(set(Technique) - {Technique.GRACE})), max_size=2)
    )
    values = {name: getattr(note, name) for name in WrittenNote.__dataclass_fields__}
    values |= {
        "voice": voice,
        "techniques": tuple(sorted(kinds)),
        "left_finger": draw(st.none() | st.integers(0, 4)),
        "right_finger": draw(st.none() | st.sampled_from("pimac")),
        "bend": draw(st.sampled_from(CURVES)) if Technique.BEND in kinds else (),
        "velocity": draw(st.none() | st.integers(1, 127)),
    }
    return WrittenNote(**values)


@st.composite
def scores(draw: st.DrawFn) -> WrittenScore:
    """One part, one to three bars, up to two voices, repeats and tempo changes."""
    bars, written = [], []
    for k in range(draw(st.integers(1, 3))):
        beats, beat_type = draw(st.sampled_from([(4, 4), (3, 4), (6, 8)]))
        length = Fraction(4 * beats, beat_type)
        tempi = ((Fraction(0), draw(st.sampled_from(TEMPI))),) if draw(st.booleans()) else ()
        times = draw(st.sampled_from([0, 0, 2]))
        bars.append(WrittenBar(k + 1, length, beats, beat_type, tempi, repeat_times=times))
        for voice in range(1, draw(st.integers(1, 2)) + 1):
            written.extend(draw(notes(k, length, voice)))
    part = WrittenPart(
        "Guitar",
        tuple(written),
        tuning=draw(st.sampled_from([STANDARD_TUNING, (64, 59, 55, 50, 45, 38)])),
        capo=draw(st.integers(0, 3)),
    )
    return WrittenScore(tuple(bars), (part,), title="Étude & <more>", composer="N. N.")
