"""Lengths and times in words: lengths in whole micrometres, as the arbiter measures them, and times in milliseconds."""


def metres(length_um: int | None) -> str:
    """To the micrometre; «?» where nothing was measured."""
    return "?" if length_um is None else f"{length_um / 1e6:.6f} m"


def seconds(time_ms: int) -> str:
    """To the tenth, or to the millisecond where that is needed."""
    return f"{time_ms / 1000:.1f} s" if time_ms % 100 == 0 else f"{time_ms / 1000:.3f} s"


def exact_length(length_um: float) -> str:
    """A difference: in millimetres to the micrometre, or in metres."""
    return f"{length_um / 1e3:.3f} mm" if abs(length_um) < 1e6 else f"{length_um / 1e6:.6f} m"


def short_length(length_um: int) -> str:
    """Two digits of a short length, in the unit that fits."""
    if length_um < 1000:
        return f"{length_um} µm"
    if length_um < 9950:
        return f"{length_um / 1000:.1f} mm"
    return f"{length_um / 1000:.0f} mm" if length_um < 99_500 else f"{length_um / 10_000:.0f} cm"
