"""Feed mutated score files to the readers: nothing may hang, grow or fail but with our error.

Every file of the folders is a seed, by its suffix; where they have none of MIDI, ASCII tab or
JSON, what our writers make of the others is. A mutation flips bits, writes over, cuts out, doubles
or joins stretches of bytes, puts in odd numbers, or drops, doubles and swaps elements of XML;
archives are mutated as they are and inside. Each input must be read or refused with a `TabError`
of one line within 5 s of processor time and 900 MB more of memory.

    python benchmarks/fuzz_readers.py FOLDER... --inputs 50000 --kinds gp5 musicxml

Kinds take turns, a thousand inputs each, after which results/fuzz_readers.json is written. What
stands there is not run again, but inputs that showed a fault are. Input k depends on the seeds,
`--seed` and k only.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import re
import resource
import signal
import sys
import time
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import FrameType

from tqdm import tqdm

from roboguitarist import storage
from roboguitarist.errors import TabError
from roboguitarist.formats import ascii_writer, detection, gpx, midi_writer
from roboguitarist.formats.parts import choose
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Tablature

RESULTS = Path(__file__).parent / "results" / "fuzz_readers.json"
BLOCK = 1000
WRITERS: dict[str, Callable[[Tablature], bytes]] = {
    "mid": midi_writer.write,
    "txt": ascii_writer.write,
    "json": lambda tablature: tablature.to_json().encode(),
}
ODD = (b"0", b"-1", b"99", b"999999999", b"1e999", b"nan", b"", b"\xff\xff\xff\xff", b"\0\0\0\0")
SIGNS = tuple(bytes([byte]) for byte in b'-|0129xhpbr/\\~<>()*:= \n{}.#"\xc3')
NUMBERS = re.compile(rb"\d+")
ELEMENTS = re.compile(rb"<(\w+)\b[^<>]*>(?:[^<>]*|(?:(?!<\1\b).){0,400}?)</\1>", re.DOTALL)
MAX_STRETCH = 64


class TooLongError(BaseException):
    """An input took longer than it may; no `except Exception` of a reader may hide it."""


@dataclass
class Tally:
    """What became of the inputs of one kind.

    Attributes:
        inputs: How many were tried, those that were read, and those refused with a `TabError`.
        cpu_s: Processor time for all; the longest for one.
        peak_mb: Highest memory of the process in MB.
        faults: Number of the input and what was wrong.
    """

    inputs: int = 0
    read: int = 0
    refused: int = 0
    cpu_s: float = 0.0
    slowest_s: float = 0.0
    peak_mb: int = 0
    faults: dict[int, str] = field(default_factory=dict)


def mutated(data: bytes, other: bytes, rng: random.Random) -> bytes:
    """The data with one to four things changed; `other` is a seed of the same kind.

    Half of the time the changes keep the file's form, so that they get past its parser.
    """
    change = rng.choice((_changed_anywhere, _changed_in_form))
    for _ in range(rng.randint(1, 4)):
        data = change(data, other, rng)
    return data


def _changed_anywhere(data: bytes, other: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(data) + 1)
    end = min(len(data), start + rng.randint(1, MAX_STRETCH))
    cut = rng.randrange(len(other) + 1)
    new = {
        "flip": lambda: bytes(byte ^ 1 << rng.randrange(8) for byte in data[start : start + 1]),
        "overwrite": lambda: rng.randbytes(end - start),
        "drop": lambda: b"",
        "double": lambda: data[start:end] * rng.randint(2, 9),
        "join": lambda: other[cut : cut + rng.randint(1, 2000)],
    }
    way = rng.choice([*new, "cut", "number"])
    if way == "cut":
        return data[:start]
    if way == "number":
        return _with_odd_number(data, rng)
    return data[:start] + new[way]() + data[start + 1 if way == "flip" else end :]


def _changed_in_form(data: bytes, other: bytes, rng: random.Random) -> bytes:
    """Elements of XML dropped, doubled or swapped, odd numbers, signs of a tab, single bytes."""
    if data.startswith(b"PK"):
        return _inside_archive(data, rng)
    if data.startswith(gpx.MAGIC):
        try:
            data = gpx.score_bytes(data)
        except TabError:
            return data
    if b"<" in data[:100] and rng.random() < 0.6:
        return _with_other_elements(data, rng)
    if rng.random() < 0.5 and b"\0" not in data:
        return _with_odd_number(data, rng)
    at = rng.randrange(len(data) + 1)
    sign = other[at : at + 1] if b"\0" in data else rng.choice(SIGNS)
    return data[:at] + sign + data[at + rng.randint(0, 1) :]


def _with_other_elements(data: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(data) + 1)
    found = list(ELEMENTS.finditer(data, start, start + 4000))
    if len(found) < 2:
        return data
    a, b = (match.span() for match in sorted(rng.sample(found, 2), key=re.Match.start))
    first, second = data[slice(*a)], data[slice(*b)]
    kept = rng.choice(((b"", second), (first * 2, second), (second, first), (second, second)))
    return data[: a[0]] + kept[0] + data[a[1] : b[0]] + kept[1] + data[b[1] :]


def _with_odd_number(data: bytes, rng: random.Random) -> bytes:
    found = list(NUMBERS.finditer(data[:200_000]))
    if not found:
        return rng.choice(ODD) + data
    number = rng.choice(found)
    return data[: number.start()] + rng.choice(ODD) + data[number.end() :]


def _inside_archive(data: bytes, rng: random.Random) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except Exception:  # a broken archive cannot be mutated inside
        return data
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            inside = name.endswith((".gpif", ".xml"))
            archive.writestr(name, _changed_in_form(content, content, rng) if inside else content)
    return buffer.getvalue()


def read(data: bytes) -> Tablature:
    """What `formats.load` does with the bytes of a file."""
    if data.lstrip()[:1] == b"{":
        return Tablature.from_json(data.decode(errors="replace"))
    score = detection.read(data, ".txt")
    part, warnings = choose(score, None)
    return unroll(score, part, warnings)


def fault(data: bytes, seconds: float = 5.0, megabytes: float = 900.0) -> str | None:
    """What is wrong with how an input was taken: "" if it was read, None if it was refused well."""
    signal.signal(signal.SIGVTALRM, _stop)
    peak_mb = _peak_mb()
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        read(data)
    except TabError as error:
        if len(str(error).splitlines()) != 1:
            return f"a message of many lines: {error}"
        result = None
    except TooLongError:
        return f"more than {seconds} s"
    except Exception as error:  # this is what is looked for
        return f"{type(error).__name__}: {error}"
    else:
        result = ""
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return f"more than {megabytes} MB" if _peak_mb() - peak_mb > megabytes else result


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise TooLongError


def made(seeds: list[bytes], seed: int | str, k: int) -> bytes:
    """Input number k."""
    rng = random.Random(f"{seed} {k}")
    return mutated(rng.choice(seeds), rng.choice(seeds), rng)


def fuzz(seeds: list[bytes], inputs: Iterable[int], seed: int | str, tally: Tally) -> None:
    """Try inputs by number, and count in `tally` what became of them."""
    for k in inputs:
        data = made(seeds, seed, k)
        start = time.process_time()
        what = fault(data)
        spent = time.process_time() - start
        tally.inputs += 1
        tally.read += what == ""
        tally.refused += what is None
        tally.cpu_s = round(tally.cpu_s + spent, 3)
        tally.slowest_s = max(tally.slowest_s, round(spent, 3))
        tally.peak_mb = max(tally.peak_mb, round(_peak_mb()))
        if what:
            tally.faults[k] = what[:200]


def by_kind(folders: Iterable[Path], kinds: Collection[str]) -> dict[str, list[bytes]]:
    """Contents of files by suffix, and what our writers make of them where there are none.

    Args:
        folders: Where the files are.
        kinds: Suffixes that are asked for; none for all.
    """
    seeds: dict[str, list[bytes]] = {}
    for path in sorted(path for folder in folders for path in folder.iterdir()):
        if path.is_file() and path.suffix and path.suffix not in (".md", ".py"):
            seeds.setdefault(path.suffix[1:].lower(), []).append(path.read_bytes())
    missing = {kind for kind in WRITERS if kind not in seeds and (kind in kinds or not kinds)}
    pieces = list(_readable(data for group in seeds.values() for data in group)) if missing else []
    seeds |= {kind: [WRITERS[kind](piece) for piece in pieces] for kind in sorted(missing)}
    return {kind: group for kind, group in seeds.items() if kind in kinds or not kinds}


def _readable(seeds: Iterable[bytes]) -> Iterator[Tablature]:
    for data in seeds:
        try:
            yield read(data)
        except TabError:
            continue


def run(seeds: dict[str, list[bytes]], inputs: int, seed: int, tallies: dict[str, Tally]) -> None:
    """Try again what was faulty, then go on to the number of inputs, all kinds in turn."""
    for kind, data in seeds.items():
        tally = tallies.setdefault(kind, Tally())
        faulty, tally.faults = sorted(tally.faults), {}
        tally.inputs -= len(faulty)
        fuzz(data, faulty, f"{seed} {kind}", tally)
    for end in tqdm(range(BLOCK, inputs + BLOCK, BLOCK), unit="block", disable=None, leave=False):
        for kind, data in seeds.items():
            block = range(tallies[kind].inputs, min(end, inputs))
            fuzz(data, block, f"{seed} {kind}", tallies[kind])
            _save(tallies)


def _saved() -> dict[str, Tally]:
    if not RESULTS.exists():
        return {}
    document = json.loads(RESULTS.read_text(encoding="utf-8"))
    tallies = {kind: Tally(**values) for kind, values in document["results"].items()}
    for tally in tallies.values():
        tally.faults = {int(k): what for k, what in tally.faults.items()}
    return tallies


def _save(tallies: dict[str, Tally]) -> None:
    document = {
        "command": "python benchmarks/fuzz_readers.py FOLDER... --inputs 50000",
        "results": {kind: asdict(tally) for kind, tally in tallies.items()},
    }
    with storage.replacing(RESULTS) as temporary:
        temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Print one line for each kind and each fault; the exit status is 1 if there is any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folders", type=Path, nargs="+", help="seeds, one file each")
    parser.add_argument("--inputs", type=int, default=1000, help="for each kind of file")
    parser.add_argument("--kinds", nargs="*", default=[], help="suffixes; by default all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--afresh", action="store_true", help="forget what was run")
    parser.add_argument("--keep", type=Path, help="folder for the inputs that show a fault")
    options = parser.parse_args()
    tallies = {} if options.afresh else _saved()
    seeds = by_kind(options.folders, options.kinds)
    run(seeds, options.inputs, options.seed, tallies)
    for kind in seeds:
        tally = tallies[kind]
        print(f"{kind}: {tally.inputs} inputs, {tally.read} read, {tally.refused} refused, "
              f"{len(tally.faults)} faults; {tally.cpu_s:.0f} s, slowest {tally.slowest_s:.2f} s, "
              f"peak {tally.peak_mb} MB")  # fmt: skip
        for k, what in tally.faults.items():
            print(f"  input {k}: {what}", file=sys.stderr)
            if options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                data = made(seeds[kind], f"{options.seed} {kind}", k)
                (options.keep / f"{kind}-{k}.{kind}").write_bytes(data)
    return int(any(tallies[kind].faults for kind in seeds))


if __name__ == "__main__":
    raise SystemExit(main())
