"""Templates and style of pages that play replays, and the policy that lets only their own scripts run."""

import base64
import hashlib
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import jinja2


def page_template(package: str, name: str, filters: Mapping[str, Any]) -> jinja2.Template:
    """Return a template of a package's folder `page`; texts in it are escaped.

    It may include the templates of this package, such as `head.html`, which needs `name`, `policy` and `style`.
    """
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(one, "page") for one in (package, "catch_arena.player")]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters
    return environment.get_template(name)


def page_file(package: str, name: str) -> str:
    """Return the text of a file in a package's folder `page`."""
    return (files(package) / "page" / name).read_text(encoding="utf-8")


def page_style(package: str, name: str) -> str:
    """Return the style of a page: the common one, then that of a file in a package's folder `page`."""
    return page_file("catch_arena.player", "page.css") + page_file(package, name)


def page_policy(*scripts: str, connects: bool = False) -> str:
    """Return the Content-Security-Policy of a page: these scripts run, by their digests, and nothing is loaded.

    Inline styles are allowed: the player and charts have some. A script is given alone or as the element `<script>`.
    If it `connects`, the page may load from the server that it comes from.
    """
    texts = (script.removeprefix("<script>").removesuffix("</script>") for script in scripts)
    digests = (base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts)
    parts = {
        "default-src": "'none'",
        "script-src": " ".join(f"'sha256-{digest}'" for digest in digests),
        "style-src": "'unsafe-inline'",
        "img-src": "data:",
        "connect-src": "'self'" if connects else "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in parts.items())
