"""Operators compared: where reviews of one take agree, and by how many mm they differ."""

from markermend.comparing.adjudication import Case, adjudication, cases, taken_over
from markermend.comparing.compared import Agreement, PairAgreement, agreement
from markermend.comparing.table2 import TableRow, table2

__all__ = [
    "Agreement",
    "Case",
    "PairAgreement",
    "TableRow",
    "adjudication",
    "agreement",
    "cases",
    "table2",
    "taken_over",
]
