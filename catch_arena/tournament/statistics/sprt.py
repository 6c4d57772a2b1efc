"""Sequential test of one share against another, which ends as soon as the played blocks suffice.

It is Wald's test (1945), generalised to outcomes of unknown distribution (Li, Liu and Ying 2014). For each of the two
means it takes the likeliest distribution over the observed outcomes with that mean, and compares these two. Chess
engines are developed with such tests over pairs of games (Fishtest, fastchess).
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from catch_arena.errors import ConfigError

Decision = Literal["H0", "H1"]

_IMAGINED: Final = 1e-3
"""Number of blocks that are added for each extreme outcome, so that a distribution with each mean exists."""
_ERROR: Final = 0.05
"""Allowed probability of accepting H1 if H0 holds, and of accepting H0 if H1 holds."""
_HALVINGS: Final = 24
"""Number of bisections for the tilt. The likelihood has its maximum there, so it gets twice as many correct digits."""


@dataclass(slots=True)
class Sprt:
    """Sequential test of H0, a mean outcome of `share0`, against H1, `share1`; 0 < share0 < share1 < 1."""

    share0: float
    share1: float
    _seen: Counter[float] = field(default_factory=Counter, init=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.share0 < self.share1 < 1.0:
            raise ConfigError(
                f"shares must obey 0 < share0 < share1 < 1, got {self.share0:g} and {self.share1:g}: "
                "H1 says that the first agent is stronger than under H0"
            )

    def add(self, outcome: float) -> None:
        """Add the outcome of a block, in [0, 1]."""
        self._seen[outcome] += 1

    @property
    def bounds(self) -> tuple[float, float]:
        """Bounds of the log-likelihood ratio: H0 is accepted at or below the first, H1 at or above the second."""
        return math.log(_ERROR / (1.0 - _ERROR)), math.log((1.0 - _ERROR) / _ERROR)

    @property
    def log_likelihood_ratio(self) -> float:
        """Log-likelihood ratio of H1 against H0."""
        seen = [(0.0, _IMAGINED), (1.0, _IMAGINED), *self._seen.items()]
        tilt0, tilt1 = _tilt(seen, self.share0), _tilt(seen, self.share1)
        return sum(
            count * math.log((1.0 + tilt0 * (outcome - self.share0)) / (1.0 + tilt1 * (outcome - self.share1)))
            for outcome, count in seen
        )

    @property
    def decision(self) -> Decision | None:
        """Accepted hypothesis; None while more blocks are needed."""
        low, high = self.bounds
        ratio = self.log_likelihood_ratio
        return "H1" if ratio >= high else "H0" if ratio <= low else None


def _tilt(seen: Sequence[tuple[float, float]], mean: float) -> float:
    """Return the tilt of the likeliest distribution with this mean (empirical likelihood, Owen 1988).

    The distribution is p / (1 + tilt (outcome - mean)), with p the observed frequency of an outcome.
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
    """Return the share of an agent that is stronger by `points`: 400 points are ten wins to one defeat."""
    return 0.5 + 0.5 * math.tanh(points * math.log(10.0) / 800.0)


def elo_of_share(share: float) -> float:
    """Return the points of a share, the inverse of `share_of_elo`; infinite for 0 and 1."""
    if share in {0.0, 1.0}:
        return math.copysign(math.inf, share - 0.5)
    return 400.0 * math.log10(share / (1.0 - share))
