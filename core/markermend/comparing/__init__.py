"""Operators compared: where reviews of one take agree, and by how many mm they differ."""

from markermend.comparing.adjudication import adjudication
from markermend.comparing.compared import Agreement, PairAgreement, agreement
from markermend.comparing.table2 import TableRow, table2

__all__ = ["Agreement", "PairAgreement", "TableRow", "adjudication", "agreement", "table2"]
