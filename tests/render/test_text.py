"""Names with any characters are measured and drawn without error."""

import pytest

from catch_arena.render import text


def test_long_and_odd_names_end_in_an_ellipsis_or_in_spaces():
    shown = text.truncated("a" * 5000, 20, 500, 150.0)
    assert shown.endswith(text.ELLIPSIS)
    assert text.text_width(shown, 20, 500) <= 150
    assert text.truncated("two\nlines\tand\x00more", 20, 500, 1e9) == "two lines and more"
    assert text.truncated("anything", 20, 500, 3.0) == ""


def test_what_is_written_from_right_to_left_is_turned_round_and_the_rest_is_not():
    assert text.as_drawn("abc \u05d0\u05d1\u05d2 def") == "abc \u05d2\u05d1\u05d0 def"
    assert text.as_drawn("\u05d0\u05d1 \u05d2\u05d3") == "\u05d3\u05d2 \u05d1\u05d0"  # a phrase is one run


def test_decomposed_letters_are_drawn_as_composed_ones():
    assert text.as_drawn("n\u0303e\u0301") == "\u00f1\u00e9"
    assert text.text_width("n\u0303e\u0301", 20, 500) == text.text_width("\u00f1\u00e9", 20, 500)


def test_marks_that_nobody_sees_are_left_out():
    """Among them those that would turn the rest of a line round."""
    assert text.as_drawn("a\u202eb\u200dc\ufeff") == "abc"


@pytest.mark.parametrize("name", ["日本語", "\U0001f422\U0001f3c6", "\ue000", "\ud800", "e\u0301\u0302\u0303", "﷽", ""])
def test_any_name_can_be_measured_and_drawn(name):
    shown = text.truncated(name, 20, 500, 300.0)
    assert text.coverage(shown, 20, 500).shape == (31, text.text_width(shown, 20, 500) + 40)
