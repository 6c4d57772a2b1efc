"""Sphinx's configuration of the site: `make site` writes out/site/index.html.

Pages are plain Markdown, so that they read well in the repository and by `catch-arena docs`. Two directives add what
only a site can show: `replay` plays a match, and `commands` lists the command line.
"""

import re
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any

import typer.cli
from docutils import nodes
from sphinx.util.docutils import SphinxDirective
from typer.testing import CliRunner

import catch_arena
from catch_arena.cli import main
from catch_arena.player.bundle import bundle_text
from catch_arena.player.element import element_script
from catch_arena.replay import Replay

project = "Catch Arena"
author = "the Catch Arena authors"
copyright = author  # noqa: A001 - Sphinx's name
version = release = installed_version("catch-arena")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]

myst_heading_anchors = 4
myst_enable_extensions = ["attrs_block"]
default_role = "code"
smartquotes_action = "qe"  # no dashes, which would change the names of options
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
toc_object_entries_show_parents = "hide"
pygments_dark_style = "github-dark"
highlight_language = "text"

DOCS = Path(__file__).parent
html_theme = "furo"
html_title = "Catch Arena"
html_static_path = ["_static"]
html_css_files = ["site.css"]
REPOSITORY = "https://github.com/OWNER/catch-arena/"
html_theme_options = {"source_repository": REPOSITORY, "source_branch": "main", "source_directory": "docs/"}


class PlayedMatch(SphinxDirective):
    """Directive `replay`: a match that plays in the page, given by the arguments of `catch-arena match`."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        (words,) = self.content
        file = Path(self.env.doctreedir) / f"{re.sub(r'[^a-z0-9]+', '-', words)}.replay"
        if not file.exists():
            done = CliRunner().invoke(main, ["match", *words.split(), "-o", str(file)], catch_exceptions=False)
            if done.exit_code:
                raise self.error(done.output)
        script = "" if self.env.temp_data.get("replay") else element_script()  # one serves a whole page
        self.env.temp_data["replay"] = True
        html = f'{script}<catch-replay bundle="{bundle_text(Replay.load(file))}"></catch-replay>'
        return [nodes.raw("", html, format="html"), *self.parse_text_to_nodes(f"`catch-arena match {words}`")]


class CommandList(SphinxDirective):
    """Directive `commands`: every command of `catch-arena` with its options, from Typer."""

    def run(self) -> list[nodes.Node]:
        command = typer.main.get_command(main)
        text = typer.cli.get_docs_for_click(obj=command, ctx=typer.Context(command), name="catch-arena")
        sections = text[text.index("## ") :]
        return self.parse_text_to_nodes(sections, allow_section_headings=True)


def link_to_repository(_app: Any, page: str, source: list[str]) -> None:
    """Let links to files outside docs/ lead to the repository."""
    up = re.escape("../" * (page.count("/") + 1))
    source[0] = re.sub(rf"\]\({up}([^)]*)\)", rf"]({REPOSITORY}blob/main/\1)", source[0])


def link_clauses(_app: Any, page: str, source: list[str]) -> None:
    """Add to each clause of the rulebook the places in the code and the tests that cite it."""
    if page not in {"reference/rulebook", "reference/bit_exact"}:
        return
    cited: dict[str, dict[str, None]] = {}
    for folder in ("catch_arena/core", "tests/rulebook"):
        for path in sorted((DOCS.parent / folder).glob("*.py")):
            for clause in re.findall(r"\b[RA]\d*\.\d+", path.read_text(encoding="utf-8")):
                cited.setdefault(clause, {})[path.relative_to(DOCS.parent).as_posix()] = None

    def with_places(clause: re.Match[str]) -> str:
        places = [f'<a href="{REPOSITORY}blob/main/{path}">{path}</a>' for path in cited.get(clause[1], ())]
        if not places:
            return clause[0]
        files = "1 file" if len(places) == 1 else f"{len(places)} files"
        details = f"<summary>cited in {files}</summary>{', '.join(places)}"
        return f'{clause[0].rstrip()}\n\n<details class="cited">{details}</details>\n\n'

    source[0] = re.sub(r"^#+ ([RA]\d*\.\d+)\b.*\n(?:(?!#).*\n)*", with_places, source[0], flags=re.MULTILINE)


def adapt_docstring(_app: Any, kind: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Let the pages that a docstring names be links, and keep napoleon from reading `name: text` as a type."""
    if kind in {"attribute", "data", "property"}:
        lines[:1] = [re.sub(r"^([^`:]+): ", r"\1 – ", line) for line in lines[:1]]
    for number, line in enumerate(lines):
        lines[number] = re.sub(r"docs/([a-z0-9_/]+)\.md", r":doc:`docs/\1.md </\1>`", line)


def shorten_types(
    _app: Any, _kind: str, _name: str, _object: Any, _options: Any, arguments: str, result: str
) -> tuple[str, ...]:
    """Write NumPy's types as the sources do: `ArrayLike`, `NDArray[float32]`."""
    array_like = re.compile(r"[~\w.]*_Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]")
    array = re.compile(r"[~\w.]*ndarray\[[~\w.]*tuple\[[~\w.]*Any, \.\.\.\], [~\w.]*dtype\[([~\w.]*)\]\]")
    short = [text and array.sub(r"NDArray[\1]", array_like.sub("ArrayLike", text)) for text in (arguments, result)]
    return tuple(short)


def link_public_names(app: Any, env: Any, node: Any, content: Any) -> Any:
    """Let types in signatures lead to the names that `catch_arena` exports."""
    name = node["reftarget"].rpartition(".")[2]
    if name not in catch_arena.__all__:
        return None
    domain = env.domains["py"]
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"catch_arena.{name}", node, content)


def setup(app: Any) -> None:
    """Add the directives, the links, and the forms of types."""
    app.connect("autodoc-process-docstring", adapt_docstring, priority=400)  # before napoleon
    app.connect("autodoc-process-signature", shorten_types)
    app.connect("missing-reference", link_public_names)
    app.connect("source-read", link_clauses)
    app.add_directive("replay", PlayedMatch)
    app.add_directive("commands", CommandList)
    app.connect("source-read", link_to_repository)
