"""Reading of an arena's memory for people: its World, and the rulings of its last step."""

from catch_arena.config import ArenaConfig
from catch_arena.core import rows
from catch_arena.core.vectors import LANES
from catch_arena.engine.chunk_views import HUNTER_DIGEST, RULING, ChunkViews, row_of
from catch_arena.verdicts import NO_REQUEST, Ruling, Verdict
from catch_arena.world import HunterState, PreyState, TargetState, World


def read_world(config: ArenaConfig, views: ChunkViews, arena: int) -> World:
    """Return one arena as a World, with names."""
    chunk, lane = divmod(arena, LANES)
    own = views.fields[chunk, : rows.ARENA_ROWS, lane].tolist()
    alive = int(own[row_of(rows.ALIVE)])
    prey, players = _prey_states(config, views, arena) if config.prey else ((), {})
    hunters = views.hunter_rows(arena)[:, HUNTER_DIGEST].tolist()
    targets = views.targets[chunk, :alive, views.target_digest, lane].T.tolist()
    return World(
        time_ms=int(own[row_of(rows.TIME)]),
        step=int(own[row_of(rows.STEP)]),
        side_m=config.side_m,
        hunters=tuple(
            HunterState(
                name=name,
                x=x,
                y=y,
                theta=theta,
                linear_velocity=speed,
                angular_velocity=turn_rate,
                score=int(score),
                active_target=config.target_name(int(active)) if active else None,
                at_wall=at_wall > 0,
                withdrawn=withdrawn > 0,
                team=team,
            )
            for name, team, (x, y, theta, speed, turn_rate, _, _, active, score, at_wall, withdrawn) in zip(
                config.hunter_names, config.team_by_seat, hunters, strict=True
            )
        ),
        targets=tuple(
            TargetState(
                name=config.target_name(int(number)),
                number=int(number),
                x=x,
                y=y,
                theta=theta,
                spawned_ms=int(appeared),
                linear_velocity=motion[0] if motion else 0.0,
                angular_velocity=motion[1] if motion else 0.0,
                at_wall=bool(motion and motion[2]),
                prey=players.get(slot),
            )
            for slot, (number, x, y, theta, appeared, *motion) in enumerate(targets)
        ),
        rulings=read_rulings(config, views, arena),
        spawned=int(own[row_of(rows.SPAWNED)]),
        prey=prey,
    )


def read_rulings(config: ArenaConfig, views: ChunkViews, arena: int) -> tuple[Ruling, ...]:
    """R5.6: return the verdicts of one arena's last step with their evidence, by seat."""
    found = []
    steps = int(views.fields[arena // LANES, row_of(rows.STEP), arena % LANES])
    for seat, (number, verdict, distance, winner) in enumerate(views.hunter_rows(arena)[:, RULING].tolist()):
        if verdict == NO_REQUEST:
            continue
        step = steps if verdict == Verdict.MATCH_OVER else steps - 1
        target = config.target_name(int(number)) if number else None
        found.append(Ruling.of_numbers(verdict, seat, target, distance, winner, step))
    return tuple(found)


def _prey_states(config: ArenaConfig, views: ChunkViews, arena: int) -> tuple[tuple[PreyState, ...], dict[int, str]]:
    """R12.1: return the states of one arena's prey, and the name of the prey that plays the target in a slot."""
    states, players = [], {}
    numbers = views.prey_numbers(arena).tolist()
    for name, number, me in zip(config.prey_names, numbers, views.prey_rows(arena).tolist(), strict=True):
        states.append(
            PreyState(
                name=name,
                target=config.target_name(int(number)) if number else None,
                times_caught=int(me[row_of(rows.TIMES_CAUGHT)]),
                caught_ms=None if number else int(me[row_of(rows.CAUGHT_AT)]),
                caught_by=None if me[row_of(rows.CAUGHT_BY)] < 0 else int(me[row_of(rows.CAUGHT_BY)]),
                withdrawn=me[row_of(rows.PREY_WITHDRAWN)] > 0,
            )
        )
        players[int(me[row_of(rows.PREY_SLOT)])] = name
    return tuple(states), players
