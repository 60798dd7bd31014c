"""What the command line says about input that cannot be used."""

from __future__ import annotations

import pytest


def complaint(capsys: pytest.CaptureFixture[str]) -> str:
    """The one line on stderr of a command that found its input unusable."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("roboguitarist: ")
    assert err.endswith("\n")
    assert len(err.splitlines()) == 1
    assert "Traceback" not in err
    return err
