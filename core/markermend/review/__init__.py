"""Reviews: what operators decide, how it is undone, and where it is kept.

`state` and `commands` are pure; `session` adds undo and redo on top of a `store`; `decisions` is
the file that goes with an export. Importing this package loads no database library.
"""

from markermend.review.commands import (
    COMMANDS,
    Accept,
    AddFinding,
    Adopt,
    Annotate,
    Choose,
    Command,
    Defer,
    Merge,
    MoveEdges,
    Reclassify,
    Reject,
    RemoveAdded,
    Reopen,
    Split,
    command_from_json,
)
from markermend.review.state import (
    VERDICTS,
    Counts,
    Decision,
    Judgement,
    Review,
    Verdict,
)

__all__ = [
    "COMMANDS",
    "VERDICTS",
    "Accept",
    "AddFinding",
    "Adopt",
    "Annotate",
    "Choose",
    "Command",
    "Counts",
    "Decision",
    "Defer",
    "Judgement",
    "Merge",
    "MoveEdges",
    "Reclassify",
    "Reject",
    "RemoveAdded",
    "Reopen",
    "Review",
    "Split",
    "Verdict",
    "command_from_json",
]
