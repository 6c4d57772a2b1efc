"""Squares in rows and columns, each with some lines above or below it, as large as a picture has room for."""

from typing import NamedTuple

from catch_arena.render.hud import Rect


class Grid(NamedTuple):
    """Where the cells lie."""

    columns: int
    rows: int
    side: int
    """Of a cell's square [pixels]."""
    extra: int
    """Below the square."""
    gap: int

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of all cells with a gap around each."""
        return (
            self.columns * (self.side + self.gap) + self.gap,
            self.rows * (self.side + self.extra + self.gap) + self.gap,
        )

    def cells(self, count: int, area: Rect) -> list[Rect]:
        """The cells, row by row, in the middle of an area; those of a last row that is not full in its middle too."""
        left, top = (area.left + (area.width - self.size[0]) // 2, area.top + (area.height - self.size[1]) // 2)
        across, down = self.side + self.gap, self.side + self.extra + self.gap
        found = []
        for place in range(count):
            row, column = divmod(place, self.columns)
            short = self.columns - min(self.columns, count - row * self.columns)
            x = left + self.gap + column * across + short * across // 2
            found.append(Rect(x, top + self.gap + row * down, self.side, self.side + self.extra))
        return found


def fitted_grid(count: int, size: tuple[int, int], extra: float, gap: float = 0.025) -> Grid:
    """The grid of so many cells whose squares are the largest; `extra` and `gap` are parts of a square's side."""
    width, height = size

    def grid(columns: int) -> Grid:
        rows = -(-count // columns)
        wide = width / (columns + (columns + 1) * gap)
        high = height / (rows * (1.0 + extra) + (rows + 1) * gap)
        side = int(min(wide, high))
        return Grid(columns, rows, side - side % 2, round(extra * side), max(2, round(gap * side)))

    return max(map(grid, range(1, count + 1)), key=lambda one: one.side)
