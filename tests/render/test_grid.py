"""The cells of a mosaic lie inside the picture and apart."""

import pytest

from catch_arena.render.mosaic import fit_grid

SIZES = [(1280, 720), (320, 320), (720, 1280), (1280, 1280)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("count", [1, 2, 3, 5, 9, 17, 64])
def test_cells_lie_inside_and_apart(count, size):
    grid = fit_grid(count, size, 0.2)
    cells = grid.cells(count)
    assert len(cells) == count
    for place, one in enumerate(cells):
        assert one.left >= 0
        assert one.top >= 0
        assert one.left + one.width <= size[0]
        assert one.top + one.height <= size[1]
        for other in cells[:place]:
            beside = one.left >= other.left + other.width or other.left >= one.left + one.width
            assert beside or one.top >= other.top + other.height or other.top >= one.top + one.height
