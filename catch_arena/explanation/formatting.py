"""Formatting of lengths (in micrometres, as the arbiter measures them) and of times (in milliseconds) as text."""


def metres(length_um: int | None) -> str:
    """Return a length in metres to the micrometre; "?" for None."""
    return "?" if length_um is None else f"{length_um / 1e6:.6f} m"


def seconds(time_ms: int) -> str:
    """Return a time in seconds, with one decimal if that is exact, else with three."""
    return f"{time_ms / 1000:.1f} s" if time_ms % 100 == 0 else f"{time_ms / 1000:.3f} s"


def exact_length(length_um: float) -> str:
    """Return a length in millimetres if it is below 1 m, else in metres, to the micrometre."""
    return f"{length_um / 1e3:.3f} mm" if abs(length_um) < 1e6 else f"{length_um / 1e6:.6f} m"


def short_length(length_um: int) -> str:
    """Return a short length with about two digits, in micrometres, millimetres or centimetres."""
    if length_um < 1000:
        return f"{length_um} µm"
    if length_um < 9950:
        return f"{length_um / 1000:.1f} mm"
    return f"{length_um / 1000:.0f} mm" if length_um < 99_500 else f"{length_um / 10_000:.0f} cm"
