import ast
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from roboguitarist import __version__

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "roboguitarist"
# The way of the data. What is to the left knows nothing of what is to the right.
ORDER = (
    "errors storage tablature pieces registration guitar fingering formats exercises "
    "engraving hands looks scene sensing ik_tasks kinematics plan servo plucking fretting policies "
    "performance transcription alignment metrics training sound ringing replay video export "
    "viewer live cli_report cli_play cli_export cli_train cli"
).split()


def component(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path):
    """Components that a module imports, at the top or inside a function, but not for types."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    skipped = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            parts = name.split(".")
            if parts[0] == "roboguitarist" and parts[1] != "__version__":
                yield parts[1]


def test_every_module_has_its_place():
    found = {component(path) for path in PACKAGE.rglob("*.py")} - {"__init__"}
    assert found == set(ORDER)


@pytest.mark.parametrize(
    "path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE))
)
def test_a_module_imports_only_what_is_to_its_left(path):
    own = component(path)
    # The package itself only makes the environments' names known.
    allowed = ORDER[: ORDER.index(own)] if own != "__init__" else ["registration"]
    assert set(imported(path)) <= {*allowed, own}


def test_version_is_stated_once_everywhere():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == __version__
    assert f"version: {__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## [{__version__}]" in (ROOT / "CHANGELOG.md").read_text()


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Wheel and source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, source


@pytest.fixture(scope="module")
def unpacked(built, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    with zipfile.ZipFile(built[0]) as wheel:
        wheel.extractall(folder)
    return folder


def run_bare(folder, code):
    """Run code with the wheel and the standard library alone."""
    code = f"import sys; sys.path.insert(0, {str(folder)!r})\n{code}"
    return subprocess.run(
        [sys.executable, "-I", "-S", "-W", "error", "-c", code],
        capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_import_is_quick_and_silent_and_needs_nothing(unpacked):
    done = run_bare(
        unpacked,
        "import time; start = time.perf_counter()\n"
        "import roboguitarist\n"
        "sys.exit(time.perf_counter() - start > 0.5)",
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_import_opens_no_file_but_code_and_no_connection(unpacked):
    done = run_bare(
        unpacked,
        "seen = []\n"
        "sys.addaudithook(lambda event, args: seen.append((event, args)))\n"
        "import roboguitarist\n"
        "opened = [str(args[0]) for event, args in list(seen) if event == 'open']\n"
        "assert all(name.endswith(('.py', '.pyc')) or '.pyc.' in name for name in opened), opened\n"
        "assert not [event for event, _ in seen if event.startswith(('socket', 'subprocess'))]\n",
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_wheel_holds_the_package_and_its_licence_only(built):
    with zipfile.ZipFile(built[0]) as wheel:
        names = wheel.namelist()
    info = f"roboguitarist-{__version__}.dist-info"
    assert {name.split("/")[0] for name in names} == {"roboguitarist", info}
    assert f"{info}/licenses/LICENSE" in names
    packed = {name for name in names if name.startswith("roboguitarist/")}
    sources = {
        f"roboguitarist/{path.relative_to(PACKAGE).as_posix()}"
        for path in PACKAGE.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert packed == sources


def test_every_folder_of_assets_says_its_licence(built):
    with zipfile.ZipFile(built[0]) as wheel:
        names = [Path(name) for name in wheel.namelist() if name.startswith("roboguitarist/")]
        folders = {path.parent for path in names if path.suffix not in (".py", ".md")}
        assert Path("roboguitarist/pieces") in folders
        for folder in folders:
            text = wheel.read((folder / "README.md").as_posix()).decode()
            assert "CC0" in text or "Apache-2.0" in text, folder


def test_the_wheel_works_without_the_repository(unpacked):
    code = (
        f"import sys; sys.path.insert(0, {str(unpacked)!r})\n"
        "import roboguitarist.cli\n"
        f"assert roboguitarist.__file__.startswith({str(unpacked)!r})\n"
        "sys.exit(roboguitarist.cli.main(['finger', 'twinkle']))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Twinkle")


def test_the_source_distribution_can_be_built_tested_and_cited(built):
    with tarfile.open(built[1]) as source:
        names = {name.partition("/")[2] for name in source.getnames()}
    for path in ("pyproject.toml", "LICENSE", "README.md", "CHANGELOG.md", "CITATION.cff",
                 "Makefile", "src/roboguitarist/cli.py", "tests/test_package.py",
                 "docs/conf.py", "examples/01_play_a_piece.py"):  # fmt: skip
        assert path in names
    assert not [name for name in names if name.startswith((".venv", "out/", "docs/_build"))]
