"""marks.csv: a line for each student, with points, reasons, dates, and the submissions to look at together."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from catch_arena.classroom.grading import Graded
from catch_arena.classroom.similarity import Pair
from catch_arena.classroom.submissions import Submission
from catch_arena.files import write_whole
from catch_arena.text import spreadsheet_cell, without_folders

MARKS: Final = "marks.csv"
EXCEL: Final = "marks_excel.csv"
"""Copy of marks.csv in the form that Excel reads in all languages: UTF-16, with tabs."""


def write_marks(
    folder: Path,
    graded: Mapping[str, Graded],
    submissions: Sequence[Submission],
    tests: Sequence[str],
    pairs: Sequence[Pair],
    deadline: datetime | None,
) -> None:
    """Write marks.csv and marks_excel.csv, with the submissions in the given order."""
    titles = [test if tests.index(test) == number else f"{test} ({number + 1})" for number, test in enumerate(tests)]
    heading = ["student", "points", "possible", *titles, "reason", "changed", "hours_late", "look_at", "digest"]
    rows = [heading]
    for submission in submissions:
        one = graded[submission.name]
        points = [f"{grade.points:g}" for grade in one.grades] or [""] * len(tests)
        failures = dict.fromkeys(grade.failures[0] for grade in one.grades if grade.failures)
        alike = (pair for pair in pairs if one.name in {pair.first, pair.second})
        look_at = (f"{pair.second if pair.first == one.name else pair.first}: {pair}" for pair in alike)
        reason = f"not graded: {one.fault}" if one.fault else without_folders("; ".join(failures))
        rows.append(
            [
                one.name,
                f"{one.points:g}" if one.grades else "",
                f"{one.possible:g}" if one.grades else "",
                *points,
                reason,
                f"{submission.changed:%Y-%m-%d %H:%M:%S}",
                hours_late(submission.changed, deadline),
                "; ".join(look_at),
                one.digest,
            ]
        )
    for name, delimiter, encoding in ((MARKS, ",", "utf-8"), (EXCEL, "\t", "utf-16")):
        text = io.StringIO()
        csv.writer(text, delimiter=delimiter, lineterminator="\n").writerows(map(spreadsheet_cell, row) for row in rows)
        write_whole(folder / name, text.getvalue().encode(encoding))


def hours_late(changed: datetime, deadline: datetime | None) -> str:
    """Return the number of hours after the deadline, rounded up to one decimal; empty without a deadline or in time."""
    if deadline is None or changed <= deadline:
        return ""
    return f"{math.ceil((changed - deadline).total_seconds() / 360) / 10:.1f}"
