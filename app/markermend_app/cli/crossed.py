"""Tables of counts by two classes, for the terminal."""

from collections.abc import Iterator, Sequence


def crossed(
    rows: Sequence[str], columns: Sequence[str], counts: Sequence[Sequence[int]]
) -> Iterator[str]:
    """Give the lines of a table, without rows and columns in which nothing was counted."""
    across = [j for j in range(len(columns)) if any(row[j] for row in counts)]
    width = max(map(len, rows))
    yield " " * width + "".join(f"  {columns[j]:>7}" for j in across)
    for name, row in zip(rows, counts, strict=True):
        if any(row):
            cells = "".join(f"  {row[j] or '.':>7}" for j in across)
            yield f"{name:{width}}{cells}"
