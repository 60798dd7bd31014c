import time
import wave
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist import sound
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.performance import DEAD, Performance
from roboguitarist.sound.damping import Tone
from roboguitarist.sound.events import string_events
from roboguitarist.sound.loop import tuned_loop
from roboguitarist.sound.mix import CEILING, TAIL_S, limited
from roboguitarist.sound.strings import ALONG, pluck_excitation, ring, strength
from roboguitarist.tablature import STANDARD_TUNING, Tablature

RATE_HZ = 44100
TICKS_HZ = 30


def playing(plucks=(), moves=(), duration_s=1.0, *, tuning=STANDARD_TUNING, capo=0, seed=0):
    """Performance of plucks (time, string, fret, speed) and of moves (time, string, fret).

    A plucked fret is held until a move; `moves` say what the string sounds from then on.
    """
    plucks = sorted(plucks)
    n = len(plucks)
    time_s = np.arange(round(duration_s * TICKS_HZ) + 1) / TICKS_HZ
    frets = np.full((len(time_s), 6), capo, np.int8)
    for at_s, string, fret in sorted([*((p[0], p[1], p[2]) for p in plucks), *moves]):
        frets[time_s >= at_s, string - 1] = fret
    columns = list(zip(*plucks, strict=True)) or [()] * 4
    return Performance(
        tablature=Tablature((), tuning=tuning, capo=capo),
        left=np.zeros(0, np.int8),
        right=np.zeros(0, np.int8),
        time_s=time_s,
        qpos=np.zeros((len(time_s), 1), np.float32),
        press_force_n=np.zeros((len(time_s), 6, 20), np.float32),
        sounding_fret=frets,
        pluck_time_s=np.array(columns[0], float),
        pluck_string=np.array(columns[1], np.int8),
        pluck_finger=np.zeros(n, np.int8),
        pluck_fret=np.array(columns[2], np.int8),
        pluck_speed_m_s=np.array(columns[3], np.float32),
        pluck_x_m=np.full(n, 0.5, np.float32),
        power_w=np.zeros(len(time_s), np.float32),
        control_hz=TICKS_HZ,
        seed=seed,
    )


def mono(performance):
    return np.sum(sound.synthesize(performance), axis=1)


def tone_at(frequency_hz):
    """A tone on the string on which it is played nearest to the nut."""
    string = next((s for s in range(1, 7) if pitch_hz(STANDARD_TUNING[s - 1]) <= frequency_hz), 6)
    return Tone(string, frequency_hz, 0.65 * pitch_hz(STANDARD_TUNING[string - 1]) / frequency_hz)


def pitch_hz(midi):
    return 440.0 * 2 ** ((midi - 69) / 12)


def fundamental_hz(samples, near_hz):
    """Frequency of the partial near a guess, from the turn of its phase in a quarter second."""
    n = hop = RATE_HZ // 4
    time_s = np.arange(n + hop) / RATE_HZ
    down = samples[: n + hop] * np.exp(-2j * np.pi * near_hz * time_s)
    window = np.blackman(n)
    turn = np.angle((down[hop:] @ window) / (down[:n] @ window))
    return near_hz + turn / (2 * np.pi * hop / RATE_HZ)


def cents(frequency_hz, wanted_hz):
    return 1200 * np.log2(frequency_hz / wanted_hz)


def energy(samples, start_s, stop_s):
    return float(np.sum(np.square(samples[round(start_s * RATE_HZ) : round(stop_s * RATE_HZ)])))


def partial(samples, frequency_hz, start_s, stop_s):
    """Strength of one partial in a stretch of time."""
    part = samples[round(start_s * RATE_HZ) : round(stop_s * RATE_HZ)]
    window = np.blackman(len(part))
    carrier = np.exp(-2j * np.pi * frequency_hz * np.arange(len(part)) / RATE_HZ)
    return abs((part * window) @ carrier) / window.sum()


def centroid_hz(samples):
    power = np.abs(np.fft.rfft(samples)) ** 2
    return np.sum(power * np.fft.rfftfreq(len(samples), 1 / RATE_HZ)) / power.sum()


@pytest.mark.parametrize("midi", range(36, 89))
def test_every_pitch_from_c2_is_tuned(midi):
    loop = tuned_loop(tone_at(pitch_hz(midi)), RATE_HZ)
    excitation = pluck_excitation(loop.period, 0.23, 0.4, RATE_HZ, np.random.default_rng(3))
    ringing = ring(loop, excitation, RATE_HZ)
    settled = ringing[len(excitation) :]
    assert abs(cents(fundamental_hz(settled, pitch_hz(midi)), pitch_hz(midi))) < 0.2


@pytest.mark.parametrize("string", range(1, 7))
def test_every_string_and_fret_is_in_tune_with_the_body(string):
    frets = range(20)
    performance = playing([(0.8 * f, string, f, 0.4) for f in frets], duration_s=16)
    samples = mono(performance)
    for fret in frets:
        wanted_hz = pitch_hz(STANDARD_TUNING[string - 1] + fret)
        start = round((0.8 * fret + 0.1) * RATE_HZ)
        assert abs(cents(fundamental_hz(samples[start:], wanted_hz), wanted_hz)) < 1.0


@pytest.mark.parametrize(("string", "fret"), [(1, 0), (2, 5), (3, 0), (3, 12), (4, 3), (6, 0)])
def test_partials_are_sharp_by_the_stiffness_of_the_string(string, fret):
    frequency_hz = pitch_hz(STANDARD_TUNING[string - 1] + fret)
    tone = Tone(string, frequency_hz, 0.65 * 2 ** (-fret / 12))
    samples = mono(playing([(0.0, string, fret, 0.5)], duration_s=1))[RATE_HZ // 10 :]
    last = int(min(12, 4000 / frequency_hz))
    assert last >= 6
    for n in range(1, last + 1):
        sharp_hz = float(tone.partial_hz(n))
        assert abs(cents(fundamental_hz(samples, sharp_hz), sharp_hz)) < 1.0
    assert cents(float(tone.partial_hz(last)), last * frequency_hz) > 1.0


@given(st.floats(60.0, 1300.0), st.sampled_from([22050, 44100, 48000]))
def test_loop_loses_at_every_frequency(frequency_hz, rate_hz):
    kernel = tuned_loop(tone_at(frequency_hz), rate_hz).kernel
    assert np.abs(np.fft.rfft(kernel, 65536)).max() < 1.0


@pytest.mark.parametrize("rate_hz", [22050, 44100, 48000])
@pytest.mark.parametrize("string", range(1, 7))
def test_a_loop_has_pitch_and_loss_of_every_partial(string, rate_hz):
    for fret in range(20):
        frequency_hz = pitch_hz(STANDARD_TUNING[string - 1] + fret)
        tone = Tone(string, frequency_hz, 0.65 * 2 ** (-fret / 12))
        loop = tuned_loop(tone, rate_hz)
        n = np.arange(1, int(tone.partial_at(5000.0)) + 1)
        omega = 2 * np.pi * tone.partial_hz(n) / rate_hz
        taps = loop.delay + np.arange(len(loop.kernel))
        response = np.exp(-1j * np.outer(omega, taps)) @ loop.kernel
        off_cents = 1200 / np.log(2) * np.angle(response) / (2 * np.pi * n)
        assert np.abs(off_cents).max() < 0.5
        rates = -np.log(np.abs(response)) * frequency_hz
        ratio = rates / tone.decay_rate(tone.partial_hz(n))
        assert np.all((ratio > 0.5) & (ratio < 1.5))
        assert ratio[0] == pytest.approx(1.0, abs=1e-3)


@given(st.floats(60.0, 1300.0), st.integers(1, 5000))
@settings(max_examples=30)
def test_blocks_give_what_the_difference_equation_gives(frequency_hz, length):
    loop = tuned_loop(tone_at(frequency_hz), RATE_HZ)
    excitation = np.random.default_rng(length).standard_normal(300)
    wanted = np.zeros(length)
    wanted[:300] = excitation[:length]
    for n in range(loop.delay, length):
        past = wanted[max(n - loop.delay - len(loop.kernel) + 1, 0) : n - loop.delay + 1][::-1]
        wanted[n] += past @ loop.kernel[: len(past)]
    np.testing.assert_allclose(ring(loop, excitation, length), wanted, atol=1e-10)


def test_open_string_with_capo_sounds_the_capo_fret():
    samples = mono(playing([(0.0, 5, 2, 0.4)], capo=2))[2000:]
    assert abs(cents(fundamental_hz(samples, pitch_hz(47)), pitch_hz(47))) < 1.0


@pytest.mark.parametrize(("string", "fret"), [(1, 0), (1, 12), (3, 5), (4, 0), (6, 0), (6, 19)])
def test_energy_falls_after_a_pluck(string, fret):
    samples = mono(playing([(0.0, string, fret, 0.5)], duration_s=2))
    windows = [energy(samples, t, t + 0.1) for t in np.arange(0.05, 3.3, 0.1)]
    assert np.all(np.diff(windows) < 0)


def amplitude_db(samples, frequency_hz, start_s, stop_s):
    return 20 * np.log10(partial(samples, frequency_hz, start_s, stop_s))


@pytest.mark.parametrize("string", range(1, 7))
def test_decays_are_those_of_the_table(string):
    """Both polarisations together, on frets from the nut to the body."""
    early, late = 0.2, 0.8
    frets = (0, 3, 7, 12, 19)
    performance = playing([(1.2 * k, string, f, 0.5) for k, f in enumerate(frets)], duration_s=6)
    samples = mono(performance)
    for k, fret in enumerate(frets):
        frequency_hz = pitch_hz(STANDARD_TUNING[string - 1] + fret)
        tone = Tone(string, frequency_hz, 0.65 * 2 ** (-fret / 12))
        rates = np.array([tone.decay_rate(frequency_hz, across) for across in (True, False)])
        wanted = np.array([[1, ALONG]]) @ np.exp(-np.outer(rates, [early, late]))
        lost_db = amplitude_db(samples, frequency_hz, 1.2 * k + 0.1, 1.2 * k + 0.3) - amplitude_db(
            samples, frequency_hz, 1.2 * k + 0.7, 1.2 * k + 0.9
        )
        assert lost_db == pytest.approx(20 * np.log10(wanted[0, 0] / wanted[0, 1]), rel=0.1)


@pytest.mark.parametrize("midi", range(40, 84, 3))
def test_a_loop_loses_at_its_fundamental_what_the_table_says(midi):
    tone = tone_at(pitch_hz(midi))
    loop = tuned_loop(tone, RATE_HZ)
    omega = 2 * np.pi / loop.period
    gain = abs(loop.kernel @ np.exp(-1j * omega * np.arange(len(loop.kernel))))
    assert -np.log(1000) / np.log(gain) / tone.frequency_hz == pytest.approx(
        tone.decay_s(), rel=0.01
    )


def test_bass_rings_longer_than_treble():
    def lost_db(string, fret):
        samples = mono(playing([(0.0, string, fret, 0.5)], duration_s=2))
        return 10 * np.log10(energy(samples, 0.2, 0.4) / energy(samples, 1.2, 1.4))

    losses = lost_db(6, 0), lost_db(1, 0), lost_db(1, 12)
    assert 8 < losses[0] < losses[1] < losses[2] < 60


def test_strings_are_equally_loud():
    heard = [mono(playing([(0.0, s, f, 0.4)])) for s in range(1, 7) for f in (0, 3, 7, 12)]
    level_db = 10 * np.log10([energy(samples, 0.0, 0.4) for samples in heard])
    assert np.ptp(level_db) < 7
    assert np.std(level_db) < 2


def test_faster_plucks_are_louder_and_brighter():
    heard = [mono(playing([(0.0, 2, 1, v)]))[:RATE_HZ] for v in (0.1, 0.2, 0.4, 0.8)]
    assert np.all(np.diff([energy(samples, 0, 1) for samples in heard]) > 0)
    assert np.all(np.diff([centroid_hz(samples) for samples in heard]) > 0)


@given(st.floats(0.001, 10.0))
def test_loudness_saturates(speed_m_s):
    assert 0 <= strength(speed_m_s) < 1
    assert strength(2 * speed_m_s) <= 2 * strength(speed_m_s)


def test_a_partial_with_a_node_at_the_plucked_point_is_missing():
    rng = np.random.default_rng(0)
    period = 400.0
    middle = np.abs(np.fft.rfft(pluck_excitation(period, 0.5, 0.4, RATE_HZ, rng)[:400]))
    assert middle[2] < 0.05 * middle[1]
    assert middle[4] < 0.05 * middle[1]


def test_nothing_plucked_is_silent():
    moves = [(0.2, 1, 3), (0.4, 1, 0), (0.6, 1, DEAD)]
    assert not sound.synthesize(playing(moves=moves)).any()
    assert not sound.synthesize(playing([(0.3, 4, 0, 0.0)])).any()


def test_quiet_playing_is_not_made_loud():
    quiet, loud = (np.abs(mono(playing([(0.0, 3, 0, v)]))).max() for v in (0.02, 0.4))
    assert quiet < 0.15 * loud


def test_dead_note_is_short_and_has_no_pitch():
    others = [(0.0, string, DEAD) for string in range(1, 7)]
    samples = mono(playing([(0.0, 4, DEAD, 0.5)], others))
    assert energy(samples, 0.1, 2.0) < 1e-3 * energy(samples, 0.0, 2.0)

    def recurrence(part):
        spectrum = np.abs(np.fft.rfft(part, 2 * len(part))) ** 2
        correlation = np.fft.irfft(spectrum)
        return np.max(correlation[round(RATE_HZ / 700) : round(RATE_HZ / 60)]) / correlation[0]

    tone = mono(playing([(0.0, 4, 0, 0.5)]))
    assert recurrence(samples[: RATE_HZ // 20]) < 0.35 < recurrence(tone[: RATE_HZ // 20])


@pytest.mark.parametrize("then", [0, DEAD])
def test_release_stops_a_fretted_note(then):
    held = mono(playing([(0.0, 3, 4, 0.5)]))
    released = mono(playing([(0.0, 3, 4, 0.5)], [(0.5, 3, then)]))
    np.testing.assert_allclose(released[: RATE_HZ // 2], held[: RATE_HZ // 2], atol=1e-6)
    assert energy(released, 0.6, 0.7) < 0.01 * energy(held, 0.6, 0.7)
    assert partial(released, pitch_hz(55), 0.55, 0.75) < 0.02 * partial(held, pitch_hz(59), 0, 0.2)


def test_open_string_rings_until_touched():
    rings = mono(playing([(0.0, 4, 0, 0.5)]))
    touched = mono(playing([(0.0, 4, 0, 0.5)], [(0.5, 4, DEAD)]))
    assert energy(rings, 0.6, 0.7) > 0.2 * energy(rings, 0.1, 0.2)
    assert energy(touched, 0.6, 0.7) < 0.01 * energy(rings, 0.6, 0.7)


def test_slide_goes_on_weaker_at_the_new_pitch():
    samples = mono(playing([(0.0, 2, 3, 0.5)], [(0.5, 2, 5)], duration_s=1.5))
    before = partial(samples, pitch_hz(62), 0.25, 0.45)
    after = partial(samples, pitch_hz(64), 0.6, 0.8)
    assert 0.05 * before < after < 0.6 * before
    assert partial(samples, pitch_hz(62), 0.6, 0.8) < 0.1 * before


def test_second_pluck_adds_to_what_is_left_of_the_first():
    once = mono(playing([(0.6, 1, 0, 0.1)], duration_s=1.2))
    twice = mono(playing([(0.0, 1, 0, 0.6), (0.6, 1, 0, 0.1)], duration_s=1.2))
    rest = energy(twice, 0.7, 0.9) / energy(once, 0.7, 0.9)
    assert rest != pytest.approx(1.0, rel=1e-3)
    assert 0.3 < rest < 3.0
    touched_s = 0.6 - 0.012
    assert energy(twice, 0.595, 0.6) < 0.5 * energy(twice, touched_s - 0.005, touched_s)


@pytest.mark.parametrize("moves", [[(0.5, 3, 0)], [(0.5, 3, 7)], [(0.5, 3, 2)]])
def test_moves_do_not_click(moves):
    samples = mono(playing([(0.0, 3, 4, 0.5)], moves))

    def steepest(start_s, stop_s):
        part = samples[round(start_s * RATE_HZ) : round(stop_s * RATE_HZ)]
        return np.abs(np.diff(part)).max()

    assert steepest(0.48, 0.6) <= 1.2 * steepest(0.4, 0.48)


@pytest.mark.parametrize("at_s", [0.0, 0.25, 0.7123])
def test_sound_begins_with_the_pluck(at_s):
    samples = np.abs(mono(playing([(at_s, 2, 3, 0.4)])))
    first = np.flatnonzero(samples > 0.01 * samples.max())[0]
    assert -1 / RATE_HZ < first / RATE_HZ - at_s < 1e-3
    assert not samples[: int(at_s * RATE_HZ)].max(initial=0.0) > 1e-4 * samples.max()


def test_pluck_before_the_start_is_heard_at_the_start():
    samples = mono(playing([(-0.05, 2, 0, 0.4)]))
    assert energy(samples, 0, 0.1) > 0


def test_worst_case_does_not_clip():
    plucks = [(0.05 * i + 1e-4 * s, s, 0, 20.0) for i in range(20) for s in range(1, 7)]
    samples = sound.synthesize(playing(plucks))
    assert 0.5 < np.abs(samples).max() <= 1.0


def test_limiter_leaves_soft_passages_alone():
    rng = np.random.default_rng(0)
    soft = rng.uniform(-0.9, 0.9, (2000, 2)).astype(np.float32)
    np.testing.assert_array_equal(limited(soft, RATE_HZ), soft)
    loud = soft.copy()
    loud[1000:1010] = 5.0
    out = limited(loud, RATE_HZ)
    assert np.abs(out).max() <= CEILING + 1e-6
    np.testing.assert_array_equal(out[:400], soft[:400])


@pytest.mark.slow
def test_a_minute_of_six_strings_takes_less_than_a_second_and_a_half():
    plucks = [(0.5 * k + 0.01 * s, s, (k + s) % 8, 0.4) for k in range(117) for s in range(1, 7)]
    performance = playing(plucks, duration_s=58.5)
    sound.synthesize(playing(plucks[:6]))
    spent = []
    for _ in range(3):
        start = time.process_time()
        assert len(sound.synthesize(performance)) == 60 * RATE_HZ
        spent.append(time.process_time() - start)
    assert min(spent) < 1.5


def test_shape_length_and_stereo():
    samples = sound.synthesize(playing([(0.0, 6, 0, 0.4)], duration_s=1.0))
    assert samples.dtype == np.float32
    assert samples.shape == (round((1.0 + TAIL_S) * RATE_HZ), 2)
    assert np.abs(samples[-1]).max() < 1e-4
    left, right = np.square(samples).sum(axis=0)
    assert right < left < 10 * right


def test_same_performance_gives_same_bytes(tmp_path):
    performance = playing([(0.1 * i, 1 + i % 6, i % 5, 0.3) for i in range(10)])
    performance.save(tmp_path / "a.npz")
    for name, one in (("a", performance), ("b", Performance.load(tmp_path / "a.npz"))):
        sound.write_wav(tmp_path / f"{name}.wav", sound.synthesize(one))
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()


def test_seed_changes_the_noise_of_the_pluck_only_a_little():
    one, other = (mono(playing([(0.0, 3, 0, 0.4)], seed=seed)) for seed in (1, 2))
    assert 0 < energy(one - other, 0, 1) < 0.2 * energy(one, 0, 1)


def test_wav_round_trip(tmp_path):
    samples = np.random.default_rng(0).uniform(-1, 1, (1000, 2)).astype(np.float32)
    samples[0] = [-1, 1]
    sound.write_wav(tmp_path / "new" / "x.wav", samples, 48000)
    with wave.open(str(tmp_path / "new" / "x.wav")) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (2, 2, 48000)
        read = np.frombuffer(file.readframes(2000), "<i2").reshape(-1, 2)
    np.testing.assert_allclose(read / 32767, samples, atol=0.5 / 32767 + 1e-7)


def test_wav_that_cannot_be_written_is_a_clear_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RoboGuitaristError, match="cannot write"):
        sound.write_wav(tmp_path / "file" / "x.wav", np.zeros((10, 2)))


def test_too_low_a_sampling_rate_is_a_clear_error():
    with pytest.raises(RoboGuitaristError, match="too few"):
        sound.synthesize(playing([(0.0, 1, 20, 0.4)]), 2000)


def test_events_follow_plucks_and_moves():
    performance = playing([(0.11, 2, 3, 0.4)], [(0.5, 2, 0), (0.8, 2, 2)])
    events = string_events(performance, 2)
    assert [(e.fret, e.pluck, e.move) for e in events] == [
        (0, -1, "damp"),
        (3, 0, None),
        (0, -1, "damp"),
        (2, -1, "slide"),
    ]
    assert [e.time_s for e in events] == pytest.approx([0.0, 0.11, 0.5, 0.8])


def test_a_hammer_on_and_a_pull_off_are_told_from_slides_by_the_other_finger():
    performance = playing([(0.1, 2, 3, 0.4)], [(0.4, 2, 5), (0.7, 2, 3)])
    moves = [event.move for event in string_events(performance, 2)[-2:]]
    assert moves == ["slide", "slide"]
    force_n = performance.press_force_n.copy()
    force_n[:, 1, 2] = 2.0
    held = replace(performance, press_force_n=force_n)
    assert [e.move for e in string_events(held, 2)[-2:]] == ["hammer-on", "pull-off"]
    louder, slid = mono(held), mono(performance)
    assert energy(louder, 0.45, 0.6) > 1.2 * energy(slid, 0.45, 0.6)


def test_a_string_pressed_just_enough_buzzes_and_a_firm_one_does_not():
    performance = playing([(0.1, 3, 4, 0.6)])

    def pressed(newton):
        force_n = performance.press_force_n.copy()
        force_n[:, 2, 3] = newton
        return mono(replace(performance, press_force_n=force_n))

    firm, weak, weaker = (pressed(newton) for newton in (3.0, 1.4, 1.05))
    np.testing.assert_array_equal(firm, mono(performance))

    def above_3_khz(samples, start_s):
        part = np.fft.rfft(samples[round(start_s * RATE_HZ) :][: RATE_HZ // 5])
        return np.sum(np.abs(part[3000 // 5 :]) ** 2)

    assert above_3_khz(weaker, 0.2) > 1.5 * above_3_khz(weak, 0.2) > 2 * above_3_khz(firm, 0.2)
    assert above_3_khz(weaker, 0.9) < 2 * above_3_khz(firm, 0.9)


def test_open_strings_ring_along_unless_they_are_touched():
    """String 6 has the open first string's pitch as its fourth partial."""
    pluck, damp = (0.0, 1, 0, 0.8), (0.6, 1, DEAD)
    others = [(0.0, string, DEAD) for string in range(2, 7)]
    free = mono(playing([pluck], [damp], duration_s=1.5))
    touched = mono(playing([pluck], [damp, *others], duration_s=1.5))
    heard = [partial(samples, pitch_hz(64), 1.0, 1.4) for samples in (free, touched)]
    assert heard[0] > 10 * heard[1]
    assert heard[0] < 0.05 * partial(free, pitch_hz(64), 0.1, 0.5)


def test_plucked_place_is_taken_from_the_guitar_of_the_performance():
    classical = playing([(0.0, 6, 0, 0.4)])
    small = replace(classical, guitar="three-quarter")
    assert energy(mono(classical) - mono(small), 0, 1) > 0.01 * energy(mono(classical), 0, 1)
    with pytest.raises(RoboGuitaristError, match="no guitar"):
        sound.synthesize(replace(classical, guitar="kazoo"))


times_s = st.floats(-0.1, 0.6)
strings = st.integers(1, 6)
frets = st.integers(DEAD, 24)
speeds = st.just(0.0) | st.floats(0.05, 3.0)


@given(
    st.lists(st.tuples(times_s, strings, frets, speeds), max_size=12),
    st.lists(st.tuples(times_s, strings, frets), max_size=12),
    st.tuples(*[st.integers(36, 67)] * 6),
)
@settings(max_examples=25, deadline=None)
def test_any_performance_gives_sound_within_bounds(plucks, moves, tuning):
    samples = sound.synthesize(playing(plucks, moves, 0.6, tuning=tuning), 22050)
    assert np.isfinite(samples).all()
    assert np.abs(samples).max() <= 1.0
    assert samples.any() == any(speed > 0 for *_, speed in plucks)
