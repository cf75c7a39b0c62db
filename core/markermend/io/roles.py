"""Tell measured markers from trajectories that a model computed."""

import re
from collections.abc import Iterable, Mapping, Sequence

from markermend.model import Role, default_role

TYPE_GROUPS = (
    "ANGLES",
    "FORCES",
    "MOMENTS",
    "POWERS",
    "SCALARS",
    "REACTIONS",
    "MODELED_MARKERS",
    "MODELLED_MARKERS",
    "BONES",
)
"""Parameters of the group POINT that list what is no measured marker, unless TYPE_GROUPS does."""

# Plug-in Gait, Oxford Foot Model and CGM write these; used where no parameter says it.
_OUTPUT = re.compile(
    r"""^(
        [LR]?[A-Z]\w*(Angles?|Forces?|Moments?|Powers?)(_CGM[\w.]*)?   # LKneeAngles, RHipPower
      | [LR](NormalisedGRF|GroundReaction(Force|Moment))(_CGM[\w.]*)?
      | CentreOfMass(Floor)?
      | [LR](HJC|KJC|AJC|SJC|EJC|WJC|FJC)(_CGM[\w.]*)?                # joint centres
    )$""",
    re.VERBOSE,
)


def roles_of(
    labels: Sequence[str], names: Sequence[str], listed: Iterable[str] = ()
) -> tuple[Role, ...]:
    """Give each point its role.

    Parameters
    ----------
    labels
        Unique labels.
    names
        The names as the file has them, before they were made unique.
    listed
        Names that the file itself lists as outputs of a model.

    Notes
    -----
    Besides the listed ones, outputs are recognised by the names that Vicon's models use, and bones
    by their four points with the same stem and the endings O, A, L, P (origin, anterior, lateral,
    proximal). Names with a subject are judged without it.
    """
    known = {_bare(name) for name in listed}
    bare = [_bare(name) for name in names]
    stems = {name[:-1] for name in bare if name.endswith("O")}
    present = set(bare)
    bones = {
        stem + end
        for stem in stems
        if len(stem) > 1 and all(stem + end in present for end in "OALP")
        for end in "OALP"
    }
    return tuple(
        "model" if name in known or name in bones or _OUTPUT.match(name) else default_role(label)
        for label, name in zip(labels, bare, strict=True)
    )


def listed_outputs(texts: Mapping[str, Sequence[str]]) -> list[str]:
    """Collect the names that a C3D file's group POINT lists as outputs of a model.

    Parameters
    ----------
    texts
        Text parameters by ``"POINT:NAME"``.
    """
    groups = {*TYPE_GROUPS, *(name.upper() for name in texts.get("POINT:TYPE_GROUPS", ())[::2])}
    found: list[str] = []
    for key, values in texts.items():
        group, _, name = key.partition(":")
        if group == "POINT" and name.rstrip("0123456789") in groups - {"LABELS", "DESCRIPTIONS"}:
            found += [value for value in values if value]
    return found


def _bare(name: str) -> str:
    return name.rsplit(":", 1)[-1].strip()
