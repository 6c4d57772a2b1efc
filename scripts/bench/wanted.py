"""What the figures ought to be: the targets that stand beside them, and say so where they are missed."""

from typing import NamedTuple

START = "2e12ef73b11d242af423e27093d3771b37f2ebba"
"""The commit beside which the batch and the start were to become faster."""


class Wanted(NamedTuple):
    """A bound, and on which side of it a figure should lie."""

    bound: float
    at_most: bool = False

    def said(self, measured: float | None) -> str:
        """As «wanted 1,500: missed». Three digits count, as in the tables."""
        words = f"wanted {'at most ' if self.at_most else ''}{self.bound:,g}"
        if measured is None:
            return f"{words}: not measured"
        rounded = float(f"{measured:.3g}")
        met = rounded <= self.bound if self.at_most else rounded >= self.bound
        return f"{words}: {'met' if met else 'missed'}"


BESIDE_PEERS = {"mpe2 simple_tag_v3": Wanted(1500), "VMAS simple_tag": Wanted(40), "JaxMARL simple_tag": Wanted(9)}
"""How many times as fast our batches are to be as the best of each, in agent-steps."""
BESIDE_PUFFERLIB = {14: Wanted(0.7), 30: Wanted(1.15)}
"""By its number of goals: our batch of 1,024, in agent-steps."""
ONE_ARENA_BESIDE_MPE2 = {"target": Wanted(65), "velocity": Wanted(50), "full": Wanted(45)}
"""By our control, in env-steps."""
BESIDE_TARGET_CONTROL = {"velocity": Wanted(0.95), "full": Wanted(0.85)}
"""The batch, by its control."""
TWO_THREADS = Wanted(1.8)
"""Beside one."""
MANY_HUNTERS = Wanted(1.8, at_most=True)
"""The cost of an agent-step with 64 hunters beside that with 4."""
WARM_START = Wanted(0.8, at_most=True)
"""CPU-seconds to the first step of one arena."""
MEMORY = Wanted(4000, at_most=True)
"""Bytes an arena."""

BATCH, LARGE, COLD = "batch of 1,024", "batch of 16,384", "first step, cold"
"""What `--against` measures, by these names."""
BESIDE_START = {BATCH: Wanted(2.0), LARGE: Wanted(1.7), COLD: Wanted(1 / 0.4)}
"""How many times as fast as the commit START."""
