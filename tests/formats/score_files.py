"""One short piece as a file of every kind that is read.

Two bars of four quarters at 100 a minute: C, E, G, C' on one string each, then a chord of C that
lasts a whole bar. `PIECE` says where the notes are.
"""

from __future__ import annotations

import io
from collections.abc import Callable

import guitarpro
import mido
from musicxml_texts import archive, attributes, measures, note, score, several

PIECE = (
    (0.0, 5, 3), (0.6, 4, 2), (1.2, 3, 0), (1.8, 2, 1),
    (2.4, 1, 0), (2.4, 2, 1), (2.4, 3, 0), (2.4, 4, 2), (2.4, 5, 3),
)  # fmt: skip
"""Onset in seconds, string and fret of each note."""
TUNING = (64, 59, 55, 50, 45, 40)
_TEMPO = '<sound tempo="100"/>'
_NAMES = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")


def _bars() -> list[list[list[tuple[int, int]]]]:
    """Places of the notes by bar and beat."""
    onsets = sorted({onset for onset, _, _ in PIECE})
    beats = [[(s, f) for at, s, f in PIECE if at == onset] for onset in onsets]
    return [[*beats[:4]], [beats[4]]]


def _pitch(string: int, fret: int) -> str:
    pitch = TUNING[string - 1] + fret
    return f"{_NAMES[pitch % 12]}{pitch // 12 - 1}"


def musicxml() -> bytes:
    bodies = []
    for beats in _bars():
        body = ""
        for places in beats:
            for k, (string, fret) in enumerate(places):
                chord = "<chord/>" if k else ""
                length = 4 // len(beats)
                body += note(_pitch(string, fret), length, chord, place=f"{string}/{fret}")
        bodies.append(body)
    bodies[0] = attributes("<divisions>1</divisions>") + _TEMPO + bodies[0]
    return score(*bodies)


def timewise() -> bytes:
    text = musicxml().decode().replace("score-partwise", "score-timewise")
    text = text.replace('<part id="P1">', "").replace("</part></score", "</score")
    text = text.replace('<measure number="1">', '<measure number="1"><part id="P1">')
    text = text.replace('<measure number="2">', '<measure number="2"><part id="P1">')
    return text.replace("</measure>", "</part></measure>").encode()


def mxl() -> bytes:
    return archive({"score.xml": musicxml()})


def guitar_pro(version: tuple[int, int, int], fret: int | None = None) -> bytes:
    """The piece, or all its notes at one fret."""
    song = guitarpro.Song(tempo=100, title="Short")
    song.measureHeaders = []
    track = song.tracks[0]
    track.measures = []
    for number, beats in enumerate(_bars(), 1):
        header = guitarpro.MeasureHeader(number=number)
        song.addMeasureHeader(header)
        measure = guitarpro.Measure(track, header)
        track.measures.append(measure)
        voice = measure.voices[0]
        for places in beats:
            duration = guitarpro.Duration(len(beats))
            beat = guitarpro.Beat(voice, duration=duration, status=guitarpro.BeatStatus.normal)
            for string, written in places:
                kind = guitarpro.NoteType.normal
                value = written if fret is None else fret
                beat.notes.append(guitarpro.Note(beat, value=value, string=string, type=kind))
            voice.beats.append(beat)
    buffer = io.BytesIO()
    guitarpro.write(song, buffer, version=version)
    return buffer.getvalue()


def gpif(bars: str = "", tuning: str = "40 45 50 55 59 64", tempo: str = "100 2") -> bytes:
    """A GPIF document; `bars` stands in the first master bar."""
    master, bar_list, voices, beats, notes = "", "", "", "", ""
    n_beats = n_notes = 0
    for k, content in enumerate(_bars()):
        first = n_beats
        for places in content:
            for string, fret in places:
                properties = "".join(
                    f'<Property name="{name}"><{name}>{value}</{name}></Property>'
                    for name, value in (("String", 6 - string), ("Fret", fret))
                )
                notes += f'<Note id="{n_notes}"><Properties>{properties}</Properties></Note>'
                n_notes += 1
            numbers = " ".join(str(n) for n in range(n_notes - len(places), n_notes))
            rhythm = 0 if len(content) == 4 else 1
            beats += f'<Beat id="{n_beats}"><Rhythm ref="{rhythm}"/><Notes>{numbers}</Notes></Beat>'
            n_beats += 1
        numbers = " ".join(str(n) for n in range(first, n_beats))
        master += f"<MasterBar>{bars if not k else ''}<Time>4/4</Time><Bars>{k}</Bars></MasterBar>"
        bar_list += f'<Bar id="{k}"><Voices>{k} -1 -1 -1</Voices></Bar>'
        voices += f'<Voice id="{k}"><Beats>{numbers}</Beats></Voice>'
    automation = (
        "<Automation><Type>Tempo</Type><Bar>0</Bar><Position>0</Position>"
        f"<Value>{tempo}</Value></Automation>"
    )
    staff = f'<Staff><Properties><Property name="Tuning"><Pitches>{tuning}</Pitches></Property>'
    values = (("0", "Quarter"), ("1", "Whole"))
    rhythms = "".join(f'<Rhythm id="{k}"><NoteValue>{v}</NoteValue></Rhythm>' for k, v in values)
    return (
        f"<GPIF><MasterTrack><Automations>{automation}</Automations></MasterTrack>"
        f'<Tracks><Track id="0"><Name>Guitar</Name><Staves>{staff}</Properties></Staff></Staves>'
        f"</Track></Tracks><MasterBars>{master}</MasterBars><Bars>{bar_list}</Bars>"
        f"<Voices>{voices}</Voices><Beats>{beats}</Beats><Notes>{notes}</Notes>"
        f"<Rhythms>{rhythms}</Rhythms></GPIF>"
    ).encode()


def gp(document: bytes | None = None) -> bytes:
    return archive({"Content/score.gpif": gpif() if document is None else document}, None)


def bcfs(document: bytes) -> bytes:
    """The file system of Guitar Pro 6 with one file."""
    n_sectors = -(-len(document) // 0x1000)
    entry = bytearray(0x1000)
    entry[0:4] = (2).to_bytes(4, "little")
    entry[4:14] = b"score.gpif"
    entry[0x8C:0x90] = len(document).to_bytes(4, "little")
    for k in range(n_sectors):
        entry[0x94 + 4 * k : 0x98 + 4 * k] = (2 + k).to_bytes(4, "little")
    return b"BCFS" + bytes(0x1000) + bytes(entry) + document.ljust(n_sectors * 0x1000, b"\0")


def packed(data: bytes) -> bytes:
    """Guitar Pro 6's code: runs of one byte as copies, everything else as it is."""
    bits, at = [], 0
    while at < len(data):
        run = 0
        while at and run < 255 and data[at + run : at + run + 1] == data[at - 1 : at]:
            run += 1
        size = 1 << (run.bit_length() - 1) if run > 8 else 0
        while size and size > at:
            size //= 2
        if size and len(set(data[at - size : at])) == 1:
            bits.append(f"1{8:04b}{f'{size:08b}'[::-1]}{f'{size:08b}'[::-1]}")
            at += size
        else:
            bits.append("010" + f"{data[at]:08b}")
            at += 1
    text = "".join(bits)
    text += "0" * (-len(text) % 8)
    return b"BCFZ" + len(data).to_bytes(4, "little") + int(text, 2).to_bytes(len(text) // 8, "big")


def gpx() -> bytes:
    return packed(bcfs(gpif()))


def midi() -> bytes:
    track = mido.MidiTrack([mido.MetaMessage("set_tempo", tempo=600_000)])
    file = mido.MidiFile(type=0, ticks_per_beat=480)
    file.tracks.append(track)
    for beats in _bars():
        for places in beats:
            pitches = [TUNING[string - 1] + fret for string, fret in places]
            track.extend(mido.Message("note_on", note=p, velocity=70) for p in pitches)
            ticks = 4 * 480 // len(beats)
            for k, p in enumerate(pitches):
                track.append(mido.Message("note_off", note=p, time=0 if k else ticks))
    buffer = io.BytesIO()
    file.save(file=buffer)
    return buffer.getvalue()


ASCII = """\
Short piece, by hand
Tempo: 100
Grid: 8

e|---------|-0-------|
B|-------1-|-1-------|
G|-----0---|-0-------|
D|---2-----|-2-------|
A|-3-------|-3-------|
E|---------|---------|
"""
ALPHATEX = r"""\title "Short" \tempo 100
.
:4 3.5 2.4 0.3 1.2 | (0.1 1.2 0.3 2.4 3.5).1
"""
FILES: dict[str, Callable[[], bytes]] = {
    "a.musicxml": musicxml,
    "timewise.xml": timewise,
    "a.mxl": mxl,
    "a.gp3": lambda: guitar_pro((3, 0, 0)),
    "a.gp4": lambda: guitar_pro((4, 0, 6)),
    "a.gp5": lambda: guitar_pro((5, 1, 0)),
    "a.gpx": gpx,
    "a.gp": gp,
    "a.mid": midi,
    "a.txt": ASCII.encode,
    "a.alphatex": ALPHATEX.encode,
}
SECOND_PART = several(
    measures(note("C4")),
    measures(note("D4")),
    header='<score-part id="P1"><part-name>One</part-name></score-part>'
    '<score-part id="P2"><part-name>Two</part-name></score-part>',
)
