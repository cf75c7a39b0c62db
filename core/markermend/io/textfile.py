"""Text files as they are: encoding, line ends and all, so that they can be given back."""

from dataclasses import dataclass

from markermend.errors import UnreadableTake

MOST_BYTES = 400_000_000
"""A larger text file is refused: it would need many times its size of memory."""

_MARKS = (
    (b"\xef\xbb\xbf", "utf-8"),
    (b"\xff\xfe", "utf-16-le"),
    (b"\xfe\xff", "utf-16-be"),
)


@dataclass(frozen=True)
class TextFile:
    """The lines of a text file, without the line feeds between them.

    A carriage return stays at the end of its line. Joined and encoded again the lines give the
    same bytes.
    """

    lines: tuple[str, ...]
    encoding: str
    mark: bytes
    end: str

    @classmethod
    def decode(cls, data: bytes, encoding: str = "") -> "TextFile":
        """Decode bytes: by their byte-order mark, else UTF-8, else Western European.

        Parameters
        ----------
        data
            The bytes of the file.
        encoding
            What they are known to be, where there is no mark.

        Raises
        ------
        UnreadableTake
            If the file is too large, or is no text.
        """
        if len(data) > MOST_BYTES:
            raise UnreadableTake(
                f"The text file has {len(data) / 1e6:.0f} MB, more than the {MOST_BYTES / 1e6:.0f} "
                "MB that are read; cut the recording into parts."
            )
        mark, encoding = next(
            ((mark, name) for mark, name in _MARKS if data.startswith(mark)),
            (b"", encoding or "utf-8"),
        )
        body = data[len(mark) :]
        try:
            text = body.decode(encoding)
        except UnicodeDecodeError:
            if encoding != "utf-8":
                raise UnreadableTake(f"The file is no valid {encoding.upper()} text.") from None
            encoding = "latin-1"
            text = body.decode(encoding)
        if "\0" in text[:65536]:
            raise UnreadableTake("The file is no text, it holds zero bytes.")
        end = "\n" if "\n" in text or "\r" not in text else "\r"
        return cls(tuple(text.split(end)), encoding, mark, end)

    def encode(self, lines: tuple[str, ...] | list[str]) -> bytes:
        """Encode other lines in the same way."""
        return self.mark + self.end.join(lines).encode(self.encoding)


def sniff(head: bytes) -> str:
    """Decode the beginning of a file as well as it goes, to recognise its format."""
    mark, encoding = next(
        ((mark, name) for mark, name in _MARKS if head.startswith(mark)), (b"", "utf-8")
    )
    return head[len(mark) :].decode(encoding, "replace")
