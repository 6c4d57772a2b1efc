"""Page of a student, as one file that loads nothing: points with reasons, hints, the worst moment, the agent's log.

It names no other student, except opponents of the spec, and it has no seed.
"""

import base64
import hashlib
from datetime import datetime
from functools import cache
from typing import Final

import jinja2

from catch_arena.classroom.grading import Graded
from catch_arena.classroom.marks import hours_late
from catch_arena.config import RULESET
from catch_arena.player import element_script, page_file
from catch_arena.text import without_folders

_PAGE: Final = "catch_arena.classroom"


def student_page(title: str, graded: Graded, changed: datetime, deadline: datetime | None) -> str:
    """Return the page of a student as HTML.

    Args:
        title: title of the exercise.
        graded: grades of the student.
        changed: time of the last change of the submission.
        deadline: last moment at which a submission is in time; None for no deadline.
    """
    element, script = (element_script() if graded.moment else ""), page_file(_PAGE, "student.js")
    return _template().render(
        title=title,
        graded=graded,
        changed=changed.strftime("%Y-%m-%d %H:%M"),
        late=hours_late(changed, deadline),
        ruleset=RULESET,
        policy=_policy(element.removeprefix("<script>").removesuffix("</script>"), script),
        element=element,
        style=page_file(_PAGE, "student.css"),
        script=script,
    )


@cache
def _policy(*scripts: str) -> str:
    """Return the Content-Security-Policy: these scripts run, and nothing is loaded; the player has its own styles."""
    digests = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests)
    others = "style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"
    return f"default-src 'none'; script-src {allowed}; {others}"


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(_PAGE, "page"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"points": lambda value: f"{value:g}", "without_folders": without_folders}
    return environment.get_template("student.html")
