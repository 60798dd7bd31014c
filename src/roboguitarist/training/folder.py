"""The folder of a run: its settings, what it plays, its curve, its checkpoint, its policies."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.policy import Policy
from roboguitarist.tablature import Tablature
from roboguitarist.training import checkpoint


class RunFolder:
    """Where a run keeps what it needs to go on, and what came out.

    Args:
        path: The folder.

    Attributes:
        settings: `config.json`, how the run was begun.
        curve: `curve.jsonl`, one JSON object a line for each evaluation.
        checkpoint: `checkpoint.pt`, the learner's whole state.
        best, last: `best.npz` and `last.npz`, policies for playing.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.settings, self.curve = self.path / "config.json", self.path / "curve.jsonl"
        self.checkpoint = self.path / "checkpoint.pt"
        self.best, self.last = self.path / "best.npz", self.path / "last.npz"

    def check_free(self) -> None:
        """Make sure that no run was begun here.

        Raises:
            RoboGuitaristError: If one was.
        """
        if self.settings.exists():
            raise RoboGuitaristError(
                f"{self.path} holds a run (--resume goes on with it, --out begins elsewhere)"
            )

    def begin(self, settings: Mapping[str, Any], tablatures: Mapping[str, Tablature]) -> None:
        """Write down how the run is begun.

        Raises:
            RoboGuitaristError: If one was begun here already, or the folder cannot be written.
        """
        self.check_free()
        pieces = {name: json.loads(tab.to_json()) for name, tab in tablatures.items()}
        _write(self.path / "tablatures.json", json.dumps(pieces))
        _write(self.settings, json.dumps(settings, indent=1))

    def read(self) -> tuple[dict[str, Any], dict[str, Tablature]]:
        """Settings and tablatures as `begin` wrote them.

        Raises:
            RoboGuitaristError: If no run was begun here.
        """
        try:
            settings = json.loads(self.settings.read_text(encoding="utf-8"))
            pieces = json.loads((self.path / "tablatures.json").read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise RoboGuitaristError(f"no run in {self.path} (begin without --resume)") from None
        except (OSError, ValueError) as error:
            raise RoboGuitaristError(f"{self.path}: unusable run ({error})") from error
        return settings, {
            name: Tablature.from_json(json.dumps(piece)) for name, piece in pieces.items()
        }

    def sweep(self) -> None:
        """Remove what a killed process left half-written."""
        for part in self.path.glob(".part-*"):
            part.unlink(missing_ok=True)

    def rows(self) -> list[dict[str, Any]]:
        """The curve so far; a last line that a killed process left incomplete is left out."""
        if not self.curve.exists():
            return []
        lines = self.curve.read_text(encoding="utf-8").splitlines(keepends=True)
        return [json.loads(line) for line in lines if line.endswith("\n")]

    def write_rows(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Replace the curve."""
        _write(self.curve, "".join(json.dumps(row) + "\n" for row in rows))

    def save(self, state: Mapping[str, Any], policy: Policy) -> None:
        """Write the checkpoint, then the policy as it is now.

        Raises:
            RoboGuitaristError: If the disk is full; what was there before stays.
        """
        checkpoint.save(self.checkpoint, state)
        policy.save(self.last)

    def state(self) -> dict[str, Any] | None:
        """The last checkpoint, None before the first."""
        return checkpoint.load(self.checkpoint) if self.checkpoint.exists() else None

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Keep other processes from training here, for as long as this one lives.

        Raises:
            RoboGuitaristError: If another one does.
        """
        if sys.platform == "win32":  # where files cannot be locked so
            yield
            return
        import fcntl  # noqa: PLC0415

        self.path.mkdir(parents=True, exist_ok=True)
        with (self.path / ".lock").open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise RoboGuitaristError(f"another process trains in {self.path}") from None
            yield


def _write(path: Path, text: str) -> None:
    with storage.replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
