# MuJoCo's compiled modules come without types; this says that they may hold anything.
from typing import Any

def __getattr__(name: str) -> Any: ...
