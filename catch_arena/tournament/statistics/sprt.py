"""A sequential test of one share against another: it ends as soon as the blocks played so far say enough.

Wald's test (1945), generalised to outcomes whose distribution is not known beforehand (Li, Liu and Ying 2014): of all
distributions over the outcomes that were seen, the likeliest with each of the two means are compared. Chess engines are
developed with such tests over pairs of games (Fishtest, fastchess).
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from catch_arena.errors import ConfigError

Decision = Literal["H0", "H1"]

_IMAGINED: Final = 1e-3
"""Blocks of each extreme outcome, without which a mean could be out of reach."""
_HALVINGS: Final = 24
"""The likelihood is greatest at the tilt, so it is right to twice as many digits as the tilt is."""


@dataclass(slots=True)
class Sprt:
    """H0: the mean outcome of a block is `share0`; H1: it is `share1`. Both in (0, 1), the first being less."""

    share0: float
    share1: float
    alpha: float = 0.05
    """How often H1 may be accepted where H0 holds."""
    beta: float = 0.05
    """How often H0 may be accepted where H1 holds."""
    _seen: Counter[float] = field(default_factory=Counter, init=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.share0 < self.share1 < 1.0:
            raise ConfigError(
                f"shares must obey 0 < share0 < share1 < 1, got {self.share0:g} and {self.share1:g}: "
                "H1 says that the first agent is stronger than under H0"
            )
        for name in ("alpha", "beta"):
            if not 0.0 < getattr(self, name) < 0.5:
                raise ConfigError(f"{name} must lie in (0, 0.5), got {getattr(self, name):g}")

    def add(self, outcome: float) -> None:
        """One more block; its outcome lies in [0, 1]."""
        self._seen[outcome] += 1

    @property
    def bounds(self) -> tuple[float, float]:
        """At or below the first H0 is accepted, at or above the second H1."""
        return math.log(self.beta / (1.0 - self.alpha)), math.log((1.0 - self.beta) / self.alpha)

    @property
    def log_likelihood_ratio(self) -> float:
        """Of H1 against H0."""
        seen = [(0.0, _IMAGINED), (1.0, _IMAGINED), *self._seen.items()]
        tilt0, tilt1 = _tilt(seen, self.share0), _tilt(seen, self.share1)
        return sum(
            count * math.log((1.0 + tilt0 * (outcome - self.share0)) / (1.0 + tilt1 * (outcome - self.share1)))
            for outcome, count in seen
        )

    @property
    def decision(self) -> Decision | None:
        """None while more blocks are needed."""
        low, high = self.bounds
        ratio = self.log_likelihood_ratio
        return "H1" if ratio >= high else "H0" if ratio <= low else None


def _tilt(seen: Sequence[tuple[float, float]], mean: float) -> float:
    """Where p / (1 + tilt (outcome - mean)), p being how often an outcome was seen, is the likeliest distribution with
    this mean (empirical likelihood, Owen 1988).
    """
    low, high = -1.0 / (1.0 - mean), 1.0 / mean
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        if sum(count * (outcome - mean) / (1.0 + middle * (outcome - mean)) for outcome, count in seen) > 0.0:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0


def share_of_elo(points: float) -> float:
    """The share that an agent stronger by so many points gets: ten wins to a defeat for 400 points."""
    return 0.5 + 0.5 * math.tanh(points * math.log(10.0) / 800.0)


def elo_of_share(share: float) -> float:
    """The inverse; infinite for 0 and 1."""
    if share in {0.0, 1.0}:
        return math.copysign(math.inf, share - 0.5)
    return 400.0 * math.log10(share / (1.0 - share))
