"""Feed mutated score files to the readers: nothing may hang, grow or fail but with our error.

Every file of the folder is a seed. A mutation flips bits, writes over, cuts out, doubles or swaps
stretches of bytes, puts in odd numbers, or joins two seeds of a kind; archives are mutated as
they are and inside. Each input must be read or refused with a `TabError` of one line within
`--seconds` of processor time and `--megabytes` of memory.

    python benchmarks/fuzz_readers.py FOLDER --inputs 50000 --kinds gp5 musicxml
"""

from __future__ import annotations

import argparse
import io
import random
import re
import resource
import signal
import sys
import time
import zipfile
from collections.abc import Iterable
from pathlib import Path
from types import FrameType

from tqdm import tqdm

from roboguitarist.errors import TabError
from roboguitarist.formats import detection
from roboguitarist.formats.parts import choose
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Tablature

ODD = (b"0", b"-1", b"99", b"999999999", b"1e999", b"nan", b"", b"\xff\xff\xff\xff", b"\0\0\0\0")
NUMBERS = re.compile(rb"\d+")
MAX_STRETCH = 64


class TooLongError(Exception):
    """An input took longer than it may."""


def mutated(data: bytes, other: bytes, rng: random.Random) -> bytes:
    """The data with one to four things changed; `other` is a seed of the same kind."""
    for _ in range(rng.randint(1, 4)):
        data = _mutated_once(data, other, rng)
    return data


def _mutated_once(data: bytes, other: bytes, rng: random.Random) -> bytes:
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
    way = rng.choice([*new, "cut", "number", "inside"])
    if way == "cut":
        return data[:start]
    if way == "inside" and data.startswith(b"PK"):
        return _inside_archive(data, rng)
    if way in ("number", "inside"):
        return _with_odd_number(data, rng)
    return data[:start] + new[way]() + data[start + 1 if way == "flip" else end :]


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
            archive.writestr(name, _mutated_once(content, content, rng) if inside else content)
    return buffer.getvalue()


def read(data: bytes) -> Tablature:
    """What `formats.load` does with the bytes of a file."""
    if data.lstrip()[:1] in (b"{", b"["):
        return Tablature.from_json(data.decode(errors="replace"))
    score = detection.read(data, ".txt")
    part, warnings = choose(score, None)
    return unroll(score, part, warnings)


def fault(data: bytes, seconds: float) -> str:
    """What is wrong with how an input was taken; empty if nothing is."""
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        read(data)
    except TabError as error:
        return "" if len(str(error).splitlines()) == 1 else f"a message of many lines: {error}"
    except TooLongError:
        return f"more than {seconds} s"
    except Exception as error:  # this is what is looked for
        return f"{type(error).__name__}: {error}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return ""


def fuzz(
    seeds: list[bytes], inputs: int, rng: random.Random, seconds: float = 5.0, name: str = ""
) -> list[tuple[str, bytes]]:
    """Faults and the inputs that showed them, one of each fault."""
    signal.signal(signal.SIGVTALRM, _stop)
    found: dict[str, bytes] = {}
    for _ in tqdm(range(inputs), desc=name, disable=None, leave=False):
        data = mutated(rng.choice(seeds), rng.choice(seeds), rng)
        what = fault(data, seconds)
        if what:
            found.setdefault(what, data)
    return list(found.items())


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise TooLongError


def by_kind(paths: Iterable[Path]) -> dict[str, list[bytes]]:
    """Contents of files by suffix."""
    kinds: dict[str, list[bytes]] = {}
    for path in sorted(paths):
        if path.is_file() and path.suffix and path.suffix != ".md":
            kinds.setdefault(path.suffix[1:].lower(), []).append(path.read_bytes())
    return kinds


def main() -> int:
    """Print one line for each kind and each fault; the exit status is 1 if there is any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path, help="seeds, one file each")
    parser.add_argument("--inputs", type=int, default=1000, help="for each kind of file")
    parser.add_argument("--kinds", nargs="*", default=[], help="suffixes; by default all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--megabytes", type=int, default=1000)
    parser.add_argument("--keep", type=Path, help="folder for the inputs that show a fault")
    options = parser.parse_args()
    limit = options.megabytes * 10**6
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    total = 0
    for kind, seeds in by_kind(options.folder.iterdir()).items():
        if options.kinds and kind not in options.kinds:
            continue
        rng = random.Random(f"{options.seed} {kind}")
        start = time.process_time()
        faults = fuzz(seeds, options.inputs, rng, options.seconds, kind)
        spent = time.process_time() - start
        print(f"{kind}: {options.inputs} inputs, {len(faults)} faults, {spent:.0f} s", flush=True)
        for k, (what, data) in enumerate(faults):
            print(f"  {what[:200]}", file=sys.stderr)
            if options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                (options.keep / f"{kind}-{k}.{kind}").write_bytes(data)
        total += len(faults)
    return int(total > 0)


if __name__ == "__main__":
    raise SystemExit(main())
