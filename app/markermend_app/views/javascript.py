"""Small modules of JavaScript, joined into the one that a component of Panel consists of.

A component's code reaches the browser as text, without an address, so that its modules cannot
import each other there. Here they are joined in the order in which they need each other.
"""

import re
from pathlib import Path

IMPORT = re.compile(r'^import \{[^}]*\} from "\./([\w.]+)";\n', re.MULTILINE)


def joined(entry: Path) -> str:
    """Give the module `entry` and all that it imports from beside it, as one module."""
    texts: dict[Path, str] = {}
    _collect(entry, texts)
    return "\n".join(texts.values())


def _collect(path: Path, texts: dict[Path, str]) -> None:
    text = path.read_text(encoding="utf-8")
    for name in IMPORT.findall(text):
        beside = path.with_name(name)
        if beside not in texts:
            _collect(beside, texts)
    texts[path] = IMPORT.sub("", text)
