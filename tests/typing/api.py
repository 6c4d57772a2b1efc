"""The public API as a type checker sees it. `make check` has pyright read this file; nobody runs it.

`assert_type` holds what users get, and a line with `pyright: ignore` what they must not write: one that pyright would
let pass is an error too.
"""

from typing import Any, assert_type

import numpy as np
from numpy.typing import NDArray

import catch_arena
from catch_arena import (
    SCENARIOS,
    ArenaConfig,
    ArenaService,
    BatchView,
    CatchArenaEnv,
    CatchArenaError,
    Engine,
    FaultRates,
    Gains,
    Limits,
    Policy,
    PreyBatchView,
    PreyLimits,
    PreyPolicy,
    PreyView,
    Replay,
    RewardWeights,
    Ruling,
    VectorArena,
    Verdict,
    View,
    World,
    arbitrate,
    columns,
    explain,
    explain_step,
    parallel_env,
    scenario,
    what_if,
)
from catch_arena.envs.aec import CatchArenaAecEnv
from catch_arena.envs.parallel import SavedEpisode
from catch_arena.errors import ActionError, ConfigError, EpisodeError
from catch_arena.layout import Column
from catch_arena.messages import CatchTurtleRequest, Pose, Turtle, TurtleArray, Twist
from catch_arena.policy import SeenBody, SeenHunter, SeenTarget
from catch_arena.testing import Failure, Report, run_conformance
from catch_arena.training import LearnerBatch
from catch_arena.world import HunterState, TargetState


def settings() -> None:
    config = scenario("standard", hunters=3)
    assert_type(config, ArenaConfig)
    assert_type(SCENARIOS["duel"], ArenaConfig)
    assert_type(config.replace(reach_m=0.5), ArenaConfig)
    assert_type(config.reach_m, float | tuple[float, ...])
    assert_type(config.hunters, int)
    assert_type(config.faults, FaultRates)
    assert_type(config.gains, Gains)
    assert_type(config.rewards, RewardWeights)
    assert_type(config.hunter_names, tuple[str, ...])
    ArenaConfig(policy="farthest")  # pyright: ignore[reportArgumentType]
    ArenaConfig(hunters="three")  # pyright: ignore[reportArgumentType]
    ArenaConfig(hunter=3)  # pyright: ignore[reportCallIssue]
    config.reach_m = 0.5  # pyright: ignore[reportAttributeAccessIssue]


def errors(error: ActionError | ConfigError | EpisodeError) -> None:
    base: CatchArenaError = error
    assert_type(str(base), str)


def one_arena() -> None:
    env = parallel_env("standard", hunters=2)
    observations, infos = env.reset(seed=7)
    assert_type(observations, dict[str, Any])
    assert_type(infos, dict[str, dict[str, Any]])
    assert_type(env.agents, list[str])
    observations, rewards, terminations, truncations, infos = env.step(dict.fromkeys(env.agents, 1))
    assert_type(rewards, dict[str, float])
    assert_type(terminations, dict[str, bool])
    assert_type(truncations, dict[str, bool])
    assert_type(env.config, ArenaConfig)
    assert_type(env.state(), NDArray[np.float32])
    assert_type(env.digest(), bytes)
    assert_type(env.render(), NDArray[np.uint8] | None)
    assert_type(env.clone(), CatchArenaEnv)
    assert_type(env.restore(env.save()), tuple[dict[str, Any], dict[str, dict[str, Any]]])
    turns = catch_arena.env("standard")
    assert_type(turns.clone(), CatchArenaAecEnv)
    assert_type(turns.save(), SavedEpisode)
    parallel_env(infos="masks")  # pyright: ignore[reportArgumentType]
    assert_type(env.replay(), Replay)
    env.step([1, 1])  # pyright: ignore[reportArgumentType]
    env.reset(seed="7")  # pyright: ignore[reportArgumentType]


def what_stands_there(world: World) -> None:
    assert_type(world.time_ms, int)
    assert_type(world.hunters, tuple[HunterState, ...])
    assert_type(world.targets, tuple[TargetState, ...])
    assert_type(world.rulings, tuple[Ruling, ...])
    assert_type(world.hunters[0].pose, Pose)
    assert_type(world.alive_turtles, TurtleArray)
    assert_type(world.alive_turtles.turtles, tuple[Turtle, ...])
    world.time_ms = 0  # pyright: ignore[reportAttributeAccessIssue]


def the_arbiter() -> None:
    rulings = arbitrate(hunters=[(1.0, 1.0)], targets={"a": (1.0, 1.1)}, requests=[(0, "a"), (0, None)])
    assert_type(rulings, list[Ruling])
    assert_type(rulings[0].verdict, Verdict)
    assert_type(rulings[0].verdict.clause, str)
    assert_type(rulings[0].verdict.reason, str)
    assert_type(rulings[0].distance_um, int | None)
    assert_type(rulings[0].winner, int | None)
    assert_type(rulings[0].success, bool)
    arbitrate(hunters=[(1.0,)], targets={}, requests=[])  # pyright: ignore[reportArgumentType]
    arbitrate([(1.0, 1.0)], {}, [])  # pyright: ignore[reportCallIssue]


def many_arenas() -> None:
    arena = VectorArena("duel", num_envs=4)
    observations, infos = arena.reset(seed=1)
    assert_type(observations, NDArray[np.float32])
    assert_type(infos, dict[str, Any])
    observations, rewards, terminations, truncations, infos = arena.step(np.ones((4, 2), dtype=np.int64))
    assert_type(observations, NDArray[np.float32])
    assert_type(rewards, NDArray[np.float32])
    assert_type(terminations, NDArray[np.bool_])
    assert_type(truncations, NDArray[np.bool_])
    assert_type(arena.seeds(), NDArray[np.uint64])
    assert_type(arena.world(0), World)
    assert_type(arena.rulings(0), tuple[Ruling, ...])
    assert_type(arena.clone(), VectorArena)
    assert_type(columns(arena.config), tuple[Column, ...])
    arena.num_envs = 5  # pyright: ignore[reportAttributeAccessIssue]


def learners() -> None:
    batch = LearnerBatch("duel", num_envs=4, opponents=["nearest"])
    assert_type(batch.clone(), LearnerBatch)
    assert_type(batch.restore(batch.save()), tuple[NDArray[np.float32], NDArray[np.bool_]])
    assert_type(batch.step(np.ones(4, dtype=np.int64)).rewards, NDArray[np.float32])


def the_engine() -> None:
    engine = Engine(scenario("duel"), 2)
    assert_type(engine.digest(1), bytes)
    assert_type(engine.ends, NDArray[np.int8])
    assert_type(engine.world(0), World)


class Nearest:
    """An agent, without a base class."""

    def reset(self, seed: int) -> None:
        """Remember nothing."""

    def act(self, view: View) -> int:
        assert_type(view.targets, tuple[SeenTarget, ...])
        assert_type(view.rivals, tuple[SeenHunter, ...])
        assert_type(view.limits, Limits)
        assert_type(view.x, float)
        return view.targets[0].rank if view.targets else 0


class Blind:
    """No agent: it cannot act."""

    def reset(self, seed: int) -> None: ...


def agents(policy: Policy) -> None:
    assert_type(policy.act(View([0.0], [1], Limits.of(ArenaConfig()))), Any)
    agents(Nearest())
    agents(Blind())  # pyright: ignore[reportArgumentType]


class Runaway:
    """Prey, without a base class."""

    def reset(self, seed: int) -> None:
        """Remember nothing."""

    def act(self, view: PreyView) -> tuple[float, float]:
        assert_type(view.hunters, tuple[SeenBody, ...])
        assert_type(view.limits, PreyLimits)
        assert_type(view.limits.hunters, int)
        return 1.0, 0.0


class All(Nearest):
    """An agent that acts on a batch too."""

    def act_batch(self, view: BatchView) -> NDArray[np.int64]:
        assert_type(view.limits, Limits)
        assert_type(view.masks, NDArray[np.int8])
        return np.ones(len(view.masks), np.int64)


class AllPrey(Runaway):
    """Prey that acts on a batch too."""

    def act_batch(self, view: PreyBatchView) -> NDArray[np.float32]:
        assert_type(view.limits, PreyLimits)
        assert_type(view.observations, NDArray[np.float32])
        return np.zeros((len(view.observations), 2), np.float32)


def prey(agent: PreyPolicy) -> None:
    assert_type(agent.act(PreyView([0.0], PreyLimits.of(scenario("tag")))), Any)
    prey(Runaway())
    prey(Blind())  # pyright: ignore[reportArgumentType]


def by_names() -> None:
    service = ArenaService("standard", hunters=2)
    rulings = service.step({"hunter_0": Twist(1.0, 0.0)}, [("hunter_0", CatchTurtleRequest("target_turtle_1"))])
    assert_type(rulings, list[Ruling])
    assert_type(service.pose("hunter_0"), Pose)
    assert_type(service.world, World)


def recordings(replay: Replay) -> None:
    assert_type(Replay.load("first.replay"), Replay)
    assert_type(replay.steps, int)
    assert_type(explain(replay).lines(), list[str])
    assert_type(explain_step(replay, 3).lines(), list[str])
    answer = what_if(replay, explain(replay).contests[0])
    assert_type(answer.sentence, str)
    assert_type(answer.alternative, Replay | None)
    for world in replay.worlds():
        assert_type(world, World)


def conformance() -> None:
    report = run_conformance(catch_arena.arbitrate, only=["ties"])
    assert_type(report, Report)
    assert_type(report.passed, bool)
    assert_type(report.failures, tuple[Failure, ...])
    run_conformance(arena=object())  # pyright: ignore[reportArgumentType]
