"""How large a replay of a minute is, by what its targets and its hunters do: the table in docs/replays.md."""

from io import BytesIO

import catch_arena
from catch_arena.envs.parallel import CatchArenaEnv

ARENAS = {
    "still": ("standard", {}),
    "wander": ("standard", {"target_motion": "wander"}),
    "flee": ("standard", {"target_motion": "flee"}),
    "`tag`": ("tag", {}),
    "`herd`": ("herd", {}),
}
"""Prey drives at random."""
HUNTERS = {
    "nearest target": {"control": "target"},
    "random ranks": {"control": "target"},
    "random velocities": {"control": "velocity"},
    "random velocities and ranks": {"control": "full"},
}


def size_of(env: CatchArenaEnv, *, chasing: bool) -> int:
    """The bytes of a match's file."""
    env.record()
    env.reset(seed=1)
    for place, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(place)
    hunters = env.config.hunter_names if chasing else ()
    while env.agents:
        env.step({agent: 1 if agent in hunters else env.action_space(agent).sample() for agent in env.agents})
    file = BytesIO()
    env.replay().save(file)
    return len(file.getvalue())


if __name__ == "__main__":
    print(f"| what the hunters do | {' | '.join(ARENAS)} |")
    print(f"|---|{'---|' * len(ARENAS)}")
    for does, settings in HUNTERS.items():
        sizes = [
            size_of(
                catch_arena.parallel_env(scenario, **overrides, **settings),
                chasing=does == "nearest target",
            )
            for scenario, overrides in ARENAS.values()
        ]
        print(f"| {does} | {' | '.join(f'{size / 1000:.0f} kB' for size in sizes)} |")
