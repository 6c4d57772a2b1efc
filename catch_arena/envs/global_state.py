"""R7.3: the global state of an arena, as numbers."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.world import World


def state_vector(world: World, config: ArenaConfig) -> NDArray[np.float32]:
    """R7.3: return a world as the numbers of `layout.state_columns`, in the order, units and bounds given there."""
    numbers = [max(0.0, (config.time_limit_ms - world.time_ms) / 1000.0)]
    for hunter in world.hunters:
        numbers += [hunter.x, hunter.y, np.cos(hunter.theta), np.sin(hunter.theta)]
        numbers += [hunter.linear_velocity, hunter.angular_velocity, hunter.score, hunter.withdrawn]
    for target in world.targets:
        numbers += [1.0, target.x, target.y, (world.time_ms - target.spawned_ms) / 1000.0]
        if config.targets_move:
            numbers += [np.cos(target.theta), np.sin(target.theta), target.linear_velocity]
    of_target = 7 if config.targets_move else 4
    numbers += [0.0] * of_target * (config.max_targets - len(world.targets))
    played = {target.prey: target for target in world.targets}
    for prey in world.prey:
        its = played.get(prey.name)
        if its is None:
            numbers += [0.0] * 7  # prey that is out
        else:
            numbers += [1.0, its.x, its.y, np.cos(its.theta), np.sin(its.theta)]
            numbers += [its.linear_velocity, its.angular_velocity]
        numbers += [prey.times_caught, prey.withdrawn]
    return np.array(numbers, dtype=np.float32)
