import sys
from importlib.util import find_spec
from pathlib import Path

from roboguitarist import __version__

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
import tables  # noqa: E402

tables.write(HERE / "_generated")

project = "RoboGuitarist"
author = copyright = "The RoboGuitarist developers"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
# The extra `train` is large, and its docstrings can be read without it.
autodoc_mock_imports = [name for name in ("torch",) if find_spec(name) is None]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "_generated"]
autodoc_typehints = "description"
autodoc_member_order = "bysource"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
html_theme = "furo"
html_title = f"{project} {version}"
