"""Tables of the environments' pages, written from the code when the documentation is built."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from pathlib import Path

import phrases

from roboguitarist.cli_report import table
from roboguitarist.fingering import HANDS, Costs
from roboguitarist.fretting.guided import CORRECTIONS
from roboguitarist.fretting.guided import observation_blocks as guided_blocks
from roboguitarist.fretting.paper import ACTION_LIMITS, Actions, observation_blocks
from roboguitarist.fretting.posture import left_alone
from roboguitarist.fretting.task import TaskConfig


def write(folder: Path) -> None:
    """Write all tables as Markdown into `folder`, which is made if need be."""
    folder.mkdir(exist_ok=True)
    tables = {
        "settings": settings(),
        "observation": observation(),
        "action": action(),
        "corrections": corrections(),
        "guided": guided(),
        "costs": costs(),
    }
    for name, text in tables.items():
        (folder / f"{name}.md").write_text(text + "\n", encoding="utf-8")
    for name in phrases.PHRASES:
        (folder / f"phrase-{name}.txt").write_text(phrases.rendered(name), encoding="utf-8")


def meanings_of(kind: type) -> dict[str, str]:
    """What a docstring says of its attributes, by their names as they stand there."""
    text = (inspect.getdoc(kind) or "").partition("Attributes:\n")[2]
    entries = re.sub(r"\n {8,}", " ", text).splitlines()  # what is indented further goes on
    return dict(entry.strip().split(": ", 1) for entry in entries if entry.strip())


def costs() -> str:
    """Names and meanings of the fingering's costs, with their weights for either hand."""
    rows = [("term", "counts", "human", "robot")]
    for name, meaning in meanings_of(Costs).items():
        human, robot = (f"{getattr(HANDS[hand], name):.2f}" for hand in ("human", "robot"))
        rows.append((f"`{name}`", meaning, human, robot))
    return table(rows, text_columns=2)


def settings() -> str:
    """Name, default and meaning of every setting of the task."""
    meanings = meanings_of(TaskConfig)
    rows = [
        (f"`{field.name}`", f"`{field.default!r}`", meanings[field.name])
        for field in fields(TaskConfig)
    ]
    return table([("setting", "default", "meaning"), *rows], text_columns=3)


def observation() -> str:
    """Rows of the observation with the default settings, and with string goals as keys."""
    configs = TaskConfig(), TaskConfig(string_goal="one_hot")
    model, guitar = left_alone(configs[0].scene()), configs[0].scene().guitar
    n_actions = len(ACTION_LIMITS)
    usual, keys = (observation_blocks(config, model, guitar, n_actions) for config in configs)
    rows, begin = [], 0
    for block in usual:
        span = f"{begin} to {begin + block.size - 1}" if block.size > 1 else str(begin)
        rows.append((f"`{block.name}`", block.meaning, block.unit, span, str(block.size)))
        begin += block.size
    name, size = f"`{keys[-1].name}`, `one_hot` instead", str(keys[-1].size)
    rows.append((name, keys[-1].meaning, keys[-1].unit, "from the same place", size))
    return table([("row", "what", "unit", "where", "size"), *rows], text_columns=4)


def guided() -> str:
    """Rows of the guided task's observation."""
    joints = left_alone(TaskConfig().scene()).nq - 5
    blocks = guided_blocks(joints, len(CORRECTIONS))
    rows = [(f"`{block.name}`", block.meaning, block.unit, str(block.size)) for block in blocks]
    return table([("row", "what", "unit", "size"), *rows], text_columns=3)


def corrections() -> str:
    """Most by which a guided action moves each servo target."""
    rows = [
        (f"`{name}`", "m" if name.startswith("forearm") else "rad", f"{most:.3f}")
        for name, most in CORRECTIONS.items()
    ]
    return table([("servo", "unit", "most"), *rows], text_columns=2)


def action() -> str:
    """Servo targets at both ends of an action."""
    actions = Actions(left_alone(TaskConfig().scene()))
    rows = [
        (f"`{name}`", "m" if name.startswith("forearm") else "rad", f"{low:.2f}", f"{high:.2f}",
         f"{paper_low:.2f}", f"{paper_high:.2f}")
        for (name, (paper_low, paper_high)), low, high in zip(
            ACTION_LIMITS.items(), actions.low, actions.high, strict=True
        )
    ]  # fmt: skip
    header = ("servo", "unit", "at -1", "at 1", "limit low", "limit high")
    return table([header, *rows], text_columns=2)
