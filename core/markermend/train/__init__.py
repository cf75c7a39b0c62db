"""Practice with known truth: exercises, their grading, and what becomes of it over time.

`archive` keeps all of it in the store of reviews and alone loads a database library.
"""

from markermend.train.exercise import Answer, Exercise, exercise_from_review, make_exercise
from markermend.train.grading import grade
from markermend.train.group import Standing, group_table, standing
from markermend.train.learning import Curve, Next, Result, Share, curves, next_exercise, share
from markermend.train.levels import LEVELS, Level
from markermend.train.marks import COLUMNS, ROWS, Grade, KindScore, Mark, Repaired
from markermend.train.report import report
from markermend.train.request import Request, prepare
from markermend.train.worth import FAST

__all__ = [
    "COLUMNS",
    "FAST",
    "LEVELS",
    "ROWS",
    "Answer",
    "Curve",
    "Exercise",
    "Grade",
    "KindScore",
    "Level",
    "Mark",
    "Next",
    "Repaired",
    "Request",
    "Result",
    "Share",
    "Standing",
    "curves",
    "exercise_from_review",
    "grade",
    "group_table",
    "make_exercise",
    "next_exercise",
    "prepare",
    "report",
    "share",
    "standing",
]
