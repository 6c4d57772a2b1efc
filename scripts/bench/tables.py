"""Tables in Markdown, and how numbers stand in them."""

from collections.abc import Sequence


def rate(value: float) -> str:
    """Three digits say all that a run can know."""
    return f"{float(f'{value:.3g}'):,.0f}"


def number(value: float) -> str:
    """Three digits of it."""
    return f"{float(f'{value:.3g}'):,g}"


def times(value: float) -> str:
    """As «11.8x»."""
    return f"{number(value)}x"


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Columns of even width, so that it reads on a screen too; all but the first are set to the right."""
    lines = [[str(cell) for cell in row] for row in (head, *rows)]
    widths = [max(3, *(len(line[column]) for line in lines)) for column in range(len(head))]  # Markdown asks for three
    text = [
        "| "
        + " | ".join((cell.rjust if column else cell.ljust)(widths[column]) for column, cell in enumerate(line))
        + " |"
        for line in lines
    ]
    text.insert(
        1, "| " + " | ".join("-" * (width - 1) + (":" if column else "-") for column, width in enumerate(widths)) + " |"
    )
    return "\n".join(text)
