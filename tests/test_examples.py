import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
OUTPUT = {
    "01_play_a_piece.py": r"Twinkle, Twinkle, Little Star: 42 notes, \d+ s\nnote F1 0\.\d+|1\.0+",
    "02_fingering.py": r"C Am Dm E7\n(.|\n)*E  \|-0",
    "03_compare_hands.py": r"linkage: \d of 6 notes right\n(.|\n)*tendon: \d of 6 notes right",
}


def run(code, folder):
    done = subprocess.run(
        [sys.executable, "-W", "error::DeprecationWarning:__main__", *code],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_example_is_run():
    assert [path.name for path in EXAMPLES] == sorted(OUTPUT)
    assert [int(path.name[:2]) for path in EXAMPLES] == list(range(1, len(EXAMPLES) + 1))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_prints_what_it_promises(path, tmp_path):
    assert re.search(OUTPUT[path.name], run([str(path)], tmp_path))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_code_on_a_page_runs(page, tmp_path):
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.S | re.M)
    if blocks:
        run(["-c", "\n".join(blocks)], tmp_path)
