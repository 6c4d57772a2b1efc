"""The shipped agents, in a checkout: they stand at the top of the repository. A wheel carries agents/ in this place."""

from pathlib import Path

__path__ = [str(Path(__file__).parents[2] / "agents")]
