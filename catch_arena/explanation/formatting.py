"""Lengths in words: measured in whole micrometres, as the arbiter measures them."""


def metres(length_um: int | None) -> str:
    """To the micrometre; «?» where nothing was measured."""
    return "?" if length_um is None else f"{length_um / 1e6:.6f} m"


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
