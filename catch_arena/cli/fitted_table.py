"""Tables on terminals of any width."""

from collections.abc import Iterator
from typing import Any, Final

from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from catch_arena.cli.terminal import plain

_LEAST: Final = 12
"""So many columns of the terminal are enough for a cell that may be folded."""
_INDENT: Final = 2
_ANY: Final = 100_000


class FittedTable(Table):
    """A plain table of texts, shown as they stand; on a terminal that is too narrow for it, a list: each row's name,
    and below it the other cells with their headings. Nothing is cut off.

    Args:
        headings: of the columns.
        folded: the heading of the column whose cells may take several lines.
        named_by: how many of the first columns name a row; the others as for a Table.
    """

    def __init__(self, *headings: str, folded: str = "", named_by: int = 1, **options: Any) -> None:
        super().__init__(box=box.SIMPLE_HEAD, pad_edge=False, caption_justify="left", **options)
        for heading in headings:
            self.add_column(heading, no_wrap=heading != folded, overflow="fold")
        self._named_by = named_by

    def add_row(self, *cells: Any, **options: Any) -> None:
        """One more row."""
        super().add_row(*map(plain, cells), **options)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The table, or the list."""
        if self._needs(console, options) <= options.max_width:
            yield from super().__rich_console__(console, options)
        else:
            yield from self._listed(options.max_width)

    def _needs(self, console: Console, options: ConsoleOptions) -> int:
        """Columns of the terminal."""
        whole = self.__rich_measure__(console, options.update(width=_ANY)).maximum
        folded = [column for column in self.columns if not column.no_wrap]
        widths = [max(cell_len(str(cell)) for cell in (column.header, *column.cells)) for column in folded]
        return whole - sum(max(0, width - _LEAST) for width in widths)

    def _listed(self, width: int) -> Iterator[Text | Padding]:
        for row in zip(*(column.cells for column in self.columns), strict=True):
            yield Text("  ".join(map(str, row[: self._named_by])), style="bold")
            cells = zip(self.columns[self._named_by :], row[self._named_by :], strict=True)
            told = _filled([f"{column.header} {cell}" for column, cell in cells], width - _INDENT)
            yield Padding(Text(told), (0, 0, 0, _INDENT))
        if self.caption:
            yield Text(f"\n{self.caption}")


def _filled(parts: list[str], width: int) -> str:
    """The parts with commas between them, in lines that part none which fits a line."""
    lines = [""]
    for part in (*(f"{part}," for part in parts[:-1]), *parts[-1:]):
        longer = f"{lines[-1]} {part}".lstrip()
        if cell_len(longer) <= width or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(part)
    return "\n".join(lines)
