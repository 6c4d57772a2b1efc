"""The sorting networks behind R7.1's order: right for every size, and no larger than they must be."""

import numpy as np
import pytest

from catch_arena.core.ranking import selection_network


def run(network, keys):
    keys = keys.copy()
    for low, high in network:
        keys[low], keys[high] = np.minimum(keys[low], keys[high]), np.maximum(keys[low], keys[high])
    return keys


@pytest.mark.parametrize("wires", [*range(1, 18), 31, 33, 63, 64])
def test_the_smallest_keys_come_first_in_order(wires):
    """The 0-1 principle for small sizes (every input of zeros and ones), random permutations for large ones."""
    rng = np.random.default_rng(wires)
    if wires <= 12:
        inputs = (np.arange(2**wires)[None, :] >> np.arange(wires)[:, None]) & 1
    else:
        inputs = np.argsort(rng.random((wires, 3000)), axis=0)
    for outputs in {1, min(8, wires), wires}:
        found = run(selection_network(wires, outputs), inputs)
        assert (found[:outputs] == np.sort(inputs, axis=0)[:outputs]).all()


def test_comparators_point_upwards():
    """The smaller key goes to the lower wire, which is what lets `order` pass over wires that are empty."""
    for wires in range(2, 65):
        for outputs in range(1, wires + 1):
            network = selection_network(wires, outputs)
            assert (network[:, 0] < network[:, 1]).all()
            assert network.max() < wires


def test_what_no_output_depends_on_is_left_out():
    """63 comparators sort 16 keys; fewer find the nearest 8, and 15 the nearest one; of 64, 292 find 8, and fewer 5."""
    assert len(selection_network(16, 16)) == 63
    assert len(selection_network(16, 8)) < 63
    assert len(selection_network(16, 1)) == 15
    assert len(selection_network(64, 8)) == 292
    assert len(selection_network(64, 5)) < 292
    assert len(selection_network(1, 1)) == 0
