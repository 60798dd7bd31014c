"""A performance as one web page that opens from disk and asks nothing of a network."""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
from importlib.resources import files
from pathlib import Path

import numpy as np

from roboguitarist import replay, sound, storage
from roboguitarist.export.glb import FPS, animated_scene
from roboguitarist.performance import Performance
from roboguitarist.viewer.content import content
from roboguitarist.viewer.sound_file import encoded

__all__ = ["page", "write_page"]

RATE_HZ = 44100
SCRIPTS = ("player.js", "strings.js", "stage.js", "tab.js", "page.js")


def write_page(
    performance: Performance, path: str | Path, samples: np.ndarray | None = None
) -> None:
    """Write a performance as a web page: 3D scene, sound, tablature and metrics in one file.

    Args:
        performance: What to show.
        path: File to write; it appears when it is complete.
        samples: (N, 2) sound at 44.1 kHz from time 0 on; synthesised if not given.

    Raises:
        RoboGuitaristError: If the performance does not fit its scene, or the file cannot be
            written.
    """
    text = page(performance, samples)
    with storage.replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def page(performance: Performance, samples: np.ndarray | None = None) -> str:
    """The text of the page; arguments and errors as for `write_page`."""
    samples = sound.synthesize(performance, RATE_HZ) if samples is None else samples
    times_s = replay.frame_times(performance, FPS, len(samples) / RATE_HZ)
    start_s, end_s = float(times_s[0]), float(times_s[-1])
    kind, audio = encoded(replay.sound_from(start_s, samples, RATE_HZ), RATE_HZ)
    data = content(performance, replay.scene(performance), start_s, end_s)
    scene = gzip.compress(animated_scene(performance, times_s), mtime=0)
    parts = {
        "TITLE": html.escape(data["title"]),
        "CSS": _asset("page.css"),
        "DATA": _inert(json.dumps(data, ensure_ascii=False, separators=(",", ":"))),
        "SCENE": base64.b64encode(scene).decode(),
        "SOUND_TYPE": kind,
        "SOUND": base64.b64encode(audio).decode(),
        "LICENCES": html.escape(_asset("README.md") + "\n" + _asset("three.LICENSE")),
        "THREE": _inert(_asset("three.min.js")),
        "SCRIPTS": "\n".join(f"<script>\n{_asset(name)}</script>" for name in SCRIPTS),
    }
    return re.sub("@@([A-Z_]+)@@", lambda mark: parts[mark[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return (files(__name__) / name).read_text(encoding="utf-8")


def _inert(text: str) -> str:
    """The text of a script that cannot end its own element, whatever strings it holds."""
    return re.sub("<(?=/script|!--)", "\\\\u003c", text, flags=re.IGNORECASE)
