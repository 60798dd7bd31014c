"""Names of the environments in Gymnasium's registry; their code is imported when one is made."""

from __future__ import annotations

from roboguitarist import pieces

_ENV = "roboguitarist.fretting.env"


def ids() -> dict[str, str]:
    """Environment ids and the pieces that they play by default."""
    titles = {"".join(word.title() for word in name.split("-")): name for name in pieces.names()}
    return {f"RoboGuitarist/{t}-v0": name for t, name in {"Fretting": "twinkle", **titles}.items()}


def register() -> None:
    """Make the environments known to Gymnasium, if it is installed and does not know them."""
    try:
        import gymnasium  # noqa: PLC0415
    except ModuleNotFoundError:
        return
    for env_id, name in ids().items():
        if env_id not in gymnasium.registry:
            gymnasium.register(
                env_id,
                f"{_ENV}:FrettingEnv",
                vector_entry_point=f"{_ENV}:FrettingVectorEnv",
                kwargs={"score": name},
            )
