"""Short MusicXML texts for the tests."""

from __future__ import annotations

import io
import zipfile

CONTAINER = '<container><rootfiles><rootfile full-path="score.xml"/></rootfiles></container>'
GUITAR = '<score-part id="P1"><part-name>Guitar</part-name></score-part>'


def note(pitch: str = "", duration: object = 1, inside: str = "", place: str = "") -> str:
    """A note; pitch as "C4", "F#3", "Bb2" or empty for a rest, place as "string/fret"."""
    written = "<rest/>"
    if pitch:
        alter = {"#": "<alter>1</alter>", "b": "<alter>-1</alter>"}.get(pitch[1], "")
        written = f"<pitch><step>{pitch[0]}</step>{alter}<octave>{pitch[-1]}</octave></pitch>"
    if place:
        string, fret = place.split("/")
        inside += notations(f"<technical><string>{string}</string><fret>{fret}</fret></technical>")
    chord = "<chord/>" if "<chord/>" in inside else ""
    rest = inside.replace("<chord/>", "")
    return f"<note>{chord}{written}<duration>{duration}</duration>{rest}</note>"


def notations(inside: str) -> str:
    return f"<notations>{inside}</notations>"


def technical(inside: str) -> str:
    return notations(f"<technical>{inside}</technical>")


def repeat(direction: str, **attributes: object) -> str:
    extra = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return f'<barline><repeat direction="{direction}"{extra}/></barline>'


def ending(number: str, kind: str = "start") -> str:
    return f'<barline><ending number="{number}" type="{kind}"/></barline>'


def measures(*bodies: str) -> str:
    numbered = enumerate(bodies, 1)
    return "".join(f'<measure number="{k}">{body}</measure>' for k, body in numbered)


def attributes(inside: str) -> str:
    return f"<attributes>{inside}</attributes>"


def score(*bodies: str, header: str = GUITAR, before: str = "", work: str = "") -> bytes:
    """A score with one part that has these measures."""
    return several(measures(*bodies), header=header, before=before, work=work)


def several(*parts: str, header: str, before: str = "", work: str = "") -> bytes:
    """A score with several parts, P1 and so on."""
    written = "".join(f'<part id="P{k}">{part}</part>' for k, part in enumerate(parts, 1))
    inside = f"{work}<part-list>{header}</part-list>{written}"
    return f'<?xml version="1.0"?>{before}<score-partwise>{inside}</score-partwise>'.encode()


def archive(members: dict[str, bytes], container: str | None = CONTAINER) -> bytes:
    """A zip archive with a container file."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        if container is not None:
            file.writestr("META-INF/container.xml", container)
        for name, data in members.items():
            file.writestr(name, data)
    return buffer.getvalue()
