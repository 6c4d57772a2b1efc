"""Formatting of lengths (in micrometres, as the arbiter measures them) and of times (in milliseconds) as text."""


def metres(length_um: int | None) -> str:
    """Return a length in metres to the micrometre; "?" for None."""
    return "?" if length_um is None else f"{length_um / 1e6:.6f} m"


def seconds(time_ms: int) -> str:
    """Return a time in seconds, with one decimal if that is exact, else with three."""
    return f"{time_ms / 1000:.1f} s" if time_ms % 100 == 0 else f"{time_ms / 1000:.3f} s"


def millimetres(length_um: int) -> str:
    """Return a short length in millimetres, with at least two digits."""
    decimals = 3 if length_um < 100 else 2 if length_um < 995 else 1 if length_um < 9950 else 0
    return f"{length_um / 1000:.{decimals}f} mm"
