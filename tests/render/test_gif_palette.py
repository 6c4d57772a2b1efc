"""The colours of a GIF."""

import numpy as np

from catch_arena.render.gif_palette import ColorHistogram


def shown(histogram: ColorHistogram, codes: np.ndarray) -> np.ndarray:
    palette, places = histogram.palette()
    return palette[places[codes], 1:].astype(int)


def test_few_colours_are_kept_as_they_are():
    rng = np.random.default_rng(1)
    colors = rng.integers(0, 256, (60, 3))
    frame = np.zeros((64, 64, 4), dtype=np.uint8)
    frame[..., :3] = np.repeat(np.repeat(colors[rng.integers(0, 60, (16, 16))], 4, axis=0), 4, axis=1)
    histogram = ColorHistogram()
    codes = histogram.count(frame)
    assert np.abs(shown(histogram, codes) - frame[..., :3]).max() <= 2


def test_large_areas_are_exact_however_many_colours_there_are_besides():
    rng = np.random.default_rng(2)
    histogram = ColorHistogram()
    for _ in range(5):
        frame = np.zeros((100, 100, 4), dtype=np.uint8)
        frame[..., :3] = (69, 86, 255)
        frame[:20, :, :3] = rng.integers(0, 256, (20, 100, 3))
        codes = histogram.count(frame)
    seen = shown(histogram, codes)
    assert (seen[30:] == (69, 86, 255)).all()
    assert np.abs(seen[:20] - frame[:20, :, :3]).mean() < 24  # the others have near ones


def test_the_palette_leaves_a_place_for_what_shines_through():
    histogram = ColorHistogram()
    histogram.count(np.random.default_rng(3).integers(0, 256, (200, 200, 4)).astype(np.uint8))
    palette, places = histogram.palette()
    assert palette.shape == (256, 4)
    assert places.max() < 255
