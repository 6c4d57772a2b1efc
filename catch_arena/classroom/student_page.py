"""Page of a student, as one file that loads nothing: points with reasons, hints, the worst moment, the agent's log.

It names no other student, except opponents of the spec, and it has no seed.
"""

from datetime import datetime
from functools import cache
from typing import Final

import jinja2

from catch_arena.classroom.grading import Graded
from catch_arena.classroom.marks import hours_late
from catch_arena.config import RULESET
from catch_arena.player.moments import moment_scripts
from catch_arena.player.page_template import page_style, page_template
from catch_arena.text import without_folders

_PAGE: Final = "catch_arena.classroom"


def student_page(title: str, graded: Graded, changed: datetime, deadline: datetime | None) -> str:
    """Return the page of a student as HTML, with the title of the exercise."""
    return _template().render(
        title=title,
        graded=graded,
        changed=changed.strftime("%Y-%m-%d %H:%M"),
        late=hours_late(changed, deadline),
        ruleset=RULESET,
        style=page_style(_PAGE, "student.css"),
        **moment_scripts(plays=graded.moment is not None),
    )


@cache
def _template() -> jinja2.Template:
    filters = {"points": lambda value: f"{value:g}", "without_folders": without_folders}
    return page_template(_PAGE, "student.html", filters)
