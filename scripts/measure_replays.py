"""How large a replay of a minute is, by what its targets and its hunters do: the table in docs/replays.md."""

from io import BytesIO

import catch_arena
from catch_arena.envs.parallel import CatchArenaEnv

MOTIONS = ("still", "wander", "flee")
HUNTERS = {
    "nearest target": {},
    "random ranks": {},
    "random velocities": {"control": "velocity"},
    "random velocities and ranks": {"control": "full"},
}


def size_of(env: CatchArenaEnv, *, chasing: bool) -> int:
    """The bytes of a match's file."""
    env.record()
    env.reset(seed=1)
    for seat, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(seat)
    while env.agents:
        env.step({agent: 1 if chasing else env.action_space(agent).sample() for agent in env.agents})
    file = BytesIO()
    env.replay().save(file)
    return len(file.getvalue())


if __name__ == "__main__":
    print(f"| what the hunters do | {' | '.join(MOTIONS)} |")
    print(f"|---|{'---|' * len(MOTIONS)}")
    for does, settings in HUNTERS.items():
        sizes = [
            size_of(
                catch_arena.parallel_env("standard", target_motion=motion, **settings),
                chasing=does == "nearest target",
            )
            for motion in MOTIONS
        ]
        print(f"| {does} | {' | '.join(f'{size / 1000:.0f} kB' for size in sizes)} |")
