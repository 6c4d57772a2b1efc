"""A second decoder of replay bundles, from the description in bundle.py alone."""

import json
import math

import numpy as np


def decoded(bundle: bytes) -> tuple[dict, list[np.ndarray]]:
    """(the facts, each body's x, y and theta: float64 (3, states), in metres and radians)."""
    head, tracks = bundle.split(b"\n", 1)
    facts = json.loads(head)
    half = len(tracks) // 2
    words = [tracks[place] + 256 * tracks[half + place] for place in range(half)]
    steps = [word // 2 if word % 2 == 0 else -(word + 1) // 2 for word in words]
    units = [[facts["side"] / facts["grid"]], [facts["side"] / facts["grid"]], [2 * math.pi / facts["turn"]]]
    lengths = [facts["steps"] + 1] * len(facts["hunters"]) + [length for _, _, length in facts["targets"]]
    bodies, at = [], 0
    for length in lengths:
        columns = [np.cumsum(np.cumsum(steps[at + part * length : at + (part + 1) * length])) for part in range(3)]
        bodies.append(np.array(columns) * units)
        at += 3 * length
    assert at == len(steps)
    return facts, bodies
