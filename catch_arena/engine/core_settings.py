"""A config as the numbers that the core reads: scalars, each in the unit that its name ends in, the limits of every
seat, and the shapes of the memory.
"""

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig
from catch_arena.core import rows
from catch_arena.core.arbiter import POLICIES
from catch_arena.core.math import PI, sincos
from catch_arena.core.state import MOTIONS, SeatLimits, Settings, regions_of
from catch_arena.core.transfers import STREAMED
from catch_arena.core.vectors import LANES, WIDE
from catch_arena.core.visibility import ALL_ROUND
from catch_arena.errors import require_type
from catch_arena.layout import observation_size, prey_observation_size


def settings_of(config: ArenaConfig, *, any_control: bool = False) -> Settings:
    """Return the scalars of a config, as the core reads them. A field has the value of that name in the config, if it
    is not converted here; None becomes infinity.
    """
    require_type("config", config, ArenaConfig, "scenario(name)")
    weights = dataclasses.asdict(config.rewards) | dataclasses.asdict(config.prey_rewards)
    high = config.side_m - (TURTLESIM_SIDE_M - 10.5)  # R3.2
    converted = {
        **dataclasses.asdict(config.gains),
        **{f"{fault}_rate": rate for fault, rate in dataclasses.asdict(config.faults).items()},
        **{f"{part}_weight": weight for part, weight in weights.items()},
        "policy": POLICIES[config.policy],
        "partners_needed": config.hunters_per_catch - 1,
        "any_control": any_control,
        "spawned_in_full": _spawned_in_full(config),
        "period_ms": config.control_period_ms,
        "period_s": config.control_period_ms / 1000.0,
        "spawn_period_ms": config.spawn_period_ms if config.spawning else math.inf,
        "spawn_low_m": 0.5,
        "spawn_high_m": high,
        "spawn_last_m": math.nextafter(high, 0.0),
        "start_radius_m": 0.3 * config.side_m if config.start_radius_m is None else config.start_radius_m,
        "slot_size": LANES * (rows.MOVING_SLOT_ROWS if config.targets_move else rows.STILL_SLOT_ROWS),
        "target_motion": MOTIONS[config.target_motion],
        "prey_min_speed_mps": -config.target_speed_mps if config.reverse else 0.0,
        "view_cosine": ALL_ROUND if config.view_angle_deg == 360.0 else sincos(config.view_angle_deg * PI / 360.0)[1],
        "has_teams": config.teams is not None,
        "team_share": 0.0 if config.teams is None else config.team_share,
    }
    numbers: dict[str, Any] = {}
    for name, kind in Settings.__annotations__.items():
        value = converted[name] if name in converted else getattr(config, name)
        numbers[name] = math.inf if value is None else kind(value)
    return Settings(**numbers)


def _spawned_in_full(config: ArenaConfig) -> float:
    """R1.5, R12.6: return the number of spawned targets after which no more appear; infinity without a limit."""
    if config.prey and config.prey_returns_s is not None:
        return math.inf
    if not config.spawning:
        return 0.0
    return math.inf if config.target_budget is None else config.target_budget


def limits_by_seat(config: ArenaConfig) -> NDArray[np.float64]:
    """R2.5, R2.7: return the limits of every seat, as the core reads them: (H, 4)."""
    limits = [getattr(config, kind.__metadata__[0]) for kind in SeatLimits.__annotations__.values()]
    return np.array(limits, dtype=np.float64).T


def sizes_of(
    config: ArenaConfig, settings: Settings, arenas: int, threads: int, *, with_infos: bool, auto_reset: bool
) -> dict[str, int]:
    """Return the sizes that the shapes in `memory.Sections` name."""
    hunters, prey, teams = config.hunters, config.prey, len(config.teams or ())
    columns = max(observation_size(config), prey_observation_size(config) if prey else 0)
    staging = len(WIDE) * (hunters + prey) * columns + STREAMED  # `put_rows` writes numbers after the end
    return {
        "threads": threads,
        "arenas": arenas,
        "arenas_with_parts": arenas if with_infos else 0,
        "arenas_with_active": arenas if config.dropout_rate > 0.0 or prey else 0,
        "arenas_with_records": arenas if auto_reset else 0,
        "chunks": -(-arenas // LANES),
        "chunk": regions_of(settings).end,
        "hunters": hunters,
        "prey": prey,
        "agents": hunters + prey,
        "teams": teams,
        "start_poses": 0 if config.hunter_poses is None else hunters,
        "target_ranks": config.targets_seen * LANES,
        "rival_ranks": config.hunters_seen * LANES,
        "choices": config.targets_seen + 1,
        "columns": columns,
        "staging": -(-staging // LANES) * LANES,  # whole cache lines: no two threads write to the same
        "team_rows": 2 * hunters * LANES if teams else 0,
        "figures": rows.FINAL_TEAM_SCORE + (1 if teams else 0),
    }
