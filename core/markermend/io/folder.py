"""A folder of JSON files as one string of bytes, for formats of one file per frame.

The packed form lives in memory only: names and contents, in the order of the names.
"""

import struct
from pathlib import Path

from markermend.errors import UnreadableTake
from markermend.io.textfile import MOST_BYTES

_MARK = b"folder of files\0"
_MOST_FILES = 1_000_000


def is_packed(data: bytes | bytearray) -> bool:
    """Whether these bytes are a packed folder."""
    return data.startswith(_MARK)


def pack_folder(folder: Path) -> bytes:
    """Pack the JSON files of a folder.

    Raises
    ------
    UnreadableTake
        If they are too many or too large.
    """
    paths = sorted(p for p in folder.iterdir() if p.suffix.lower() == ".json" and p.is_file())
    if len(paths) > _MOST_FILES or sum(path.stat().st_size for path in paths) > MOST_BYTES:
        raise UnreadableTake(
            f"{folder.name} holds {len(paths)} files, more than {_MOST_FILES} or more than "
            f"{MOST_BYTES / 1e6:.0f} MB of them; cut the recording into parts."
        )
    return pack([(path.name, path.read_bytes()) for path in paths])


def pack(files: list[tuple[str, bytes]]) -> bytes:
    """Pack named contents."""
    parts = [_MARK]
    for name, content in files:
        encoded = name.encode("utf-8", "surrogateescape")
        parts += [struct.pack("<QQ", len(encoded), len(content)), encoded, content]
    return b"".join(parts)


def unpack(data: bytes | bytearray) -> list[tuple[str, bytes]]:
    """Give names and contents of a packed folder."""
    files, at = [], len(_MARK)
    while at < len(data):
        name, content = struct.unpack_from("<QQ", data, at)
        at += 16
        label = bytes(data[at : at + name]).decode("utf-8", "surrogateescape")
        files.append((label, bytes(data[at + name : at + name + content])))
        at += name + content
    return files
