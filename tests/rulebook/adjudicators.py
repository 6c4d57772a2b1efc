"""Four adjudicators behind one face: the oracle, the engine, a row of a batch, and the parallel env.

A test of a clause asks for an `arena` (see conftest.py) and thereby runs on all of them.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from oracle.arena import PART_NAMES, Command, OracleArena

from catch_arena.config import ArenaConfig
from catch_arena.core import rows
from catch_arena.errors import EpisodeError
from catch_arena.layout import groups, observation_size, prey_observation_size
from catch_arena.verdicts import Ruling, Verdict

Action = Any
"""An int under target control, (a1, a2) under velocity control, ((a1, a2), rank) under full control."""


class HunterNumbers(NamedTuple):
    """A.8's numbers of one hunter."""

    x: float
    y: float
    theta: float
    v: float
    w: float
    distance_integral: float
    bearing_integral: float
    active: float
    score: float
    at_wall: float
    withdrawn: float


class TargetNumbers(NamedTuple):
    """A.8's numbers of one alive target; the last three are there where targets move."""

    number: float
    x: float
    y: float
    theta: float
    appeared: float
    v: float = 0.0
    w: float = 0.0
    at_wall: float = 0.0


class PreyNumbers(NamedTuple):
    """A.8's numbers of one prey."""

    number: float
    """Number of the target that it plays, 0 while it is out."""
    times_caught: float
    caught_at: float
    """-1 unless it is out."""


class Evidence(NamedTuple):
    """R5.6 with the target's number in place of its name."""

    verdict: Verdict
    number: int | None
    distance_um: int | None
    winner: int | None


def rows_by_name(names: Sequence[str], numbers: Sequence[float]) -> list[dict[str, float]]:
    """Numbers that lie one behind the other, as many to a row as there are names."""
    return [dict(zip(names, numbers[at : at + len(names)], strict=True)) for at in range(0, len(numbers), len(names))]


class Adjudicator:
    """An arena as rulebook tests use it. Everything about the state is read from A.8's numbers."""

    def __init__(self, config: ArenaConfig) -> None:
        self.config = config

    # what each adjudicator does in its own way

    def reset(self, seed: int) -> None: ...
    def play(self, actions: Sequence[Action], prey: Sequence[Command]) -> None: ...
    def withdraw(self, seat: int) -> None: ...
    def withdraw_prey(self, index: int) -> None: ...
    def place(self, hunters: Sequence[tuple[float, float, float]], targets: Sequence[tuple[float, float]] = ()) -> None:
        """Hunters at rest at these poses, and these targets instead of those that nobody plays."""

    def numbers(self) -> list[float]: ...
    def digest(self) -> bytes: ...
    def evidence(self) -> list[Evidence | None]: ...
    def observation(self, seat: int) -> list[float]: ...
    def mask(self, seat: int) -> list[int]: ...
    @property
    def rewards(self) -> list[float]: ...
    @property
    def parts(self) -> list[tuple[float, ...]]: ...
    @property
    def team_scores(self) -> list[int]: ...
    def prey_observation(self, index: int) -> list[float]: ...
    @property
    def prey_rewards(self) -> list[float]: ...
    @property
    def prey_parts(self) -> list[tuple[float, ...]]: ...
    @property
    def caught_by(self) -> list[int | None]: ...
    @property
    def terminated(self) -> bool: ...
    @property
    def truncated(self) -> bool: ...

    # what follows from it

    def step(self, *actions: Action, prey: Sequence[Command] = ()) -> None:
        """One step; prey that has no action stands still."""
        self.play(actions, [*prey, *[(0.0, 0.0)] * (self.config.prey - len(prey))])

    def hold(self, times: int = 1) -> None:
        """Nobody moves, and nobody asks (but under velocity control, where whoever is in reach does)."""
        for _ in range(times):
            self.step(*self.at_rest)

    def look(self) -> None:
        """Comes before `observation` and `mask` of what was placed or withdrawn; it may take a step of holding."""

    @property
    def at_rest(self) -> list[Action]:
        """An action for each seat that holds."""
        still = {"target": 0, "velocity": (0.0, 0.0), "full": ((0.0, 0.0), 0)}
        return [still[control] for control in self.config.controls]

    def hunter(self, seat: int = 0) -> HunterNumbers:
        at = 8 + 11 * seat
        return HunterNumbers(*self.numbers()[at : at + 11])

    @property
    def targets(self) -> list[TargetNumbers]:
        everything = self.numbers()
        numbers = everything[8 + 11 * self.config.hunters : len(everything) - 3 * self.config.prey]
        width = 8 if self.config.targets_move else 5
        return [TargetNumbers(*numbers[at : at + width]) for at in range(0, len(numbers), width)]

    @property
    def prey(self) -> list[PreyNumbers]:
        count = self.config.prey
        numbers = self.numbers()[-3 * count :] if count else []
        return [PreyNumbers(*numbers[at : at + 3]) for at in range(0, len(numbers), 3)]

    @property
    def alive(self) -> list[int]:
        return [int(target.number) for target in self.targets]

    @property
    def verdicts(self) -> list[Verdict | None]:
        return [None if found is None else found.verdict for found in self.evidence()]

    @property
    def scores(self) -> list[int]:
        return [int(self.hunter(seat).score) for seat in range(self.config.hunters)]

    def own(self, seat: int = 0) -> dict[str, float]:
        """Numbers that one hunter sees of itself, by column."""
        return self._rows(seat, 0)[0]

    def seen_targets(self, seat: int = 0) -> list[dict[str, float]]:
        """Numbers that it sees of the target of each rank."""
        return self._rows(seat, 1)

    def seen_rivals(self, seat: int = 0) -> list[dict[str, float]]:
        """Numbers that it sees of the rival of each rank."""
        return self._rows(seat, 2)

    def _rows(self, seat: int, kind: int) -> list[dict[str, float]]:
        group = groups(self.config)[kind]
        return rows_by_name(group.table._fields, self.observation(seat)[group.first : group.end])

    time = property(lambda self: self.numbers()[0])
    steps = property(lambda self: self.numbers()[1])
    spawned = property(lambda self: self.numbers()[2])
    used = property(lambda self: self.numbers()[3])
    firings = property(lambda self: self.numbers()[4])
    skipped_full = property(lambda self: self.numbers()[5])
    skipped_down = property(lambda self: self.numbers()[6])
    refused = property(lambda self: self.numbers()[7])


class OracleAdjudicator(Adjudicator):
    """tests/oracle: the book in plain Python."""

    def __init__(self, config: ArenaConfig) -> None:
        super().__init__(config)
        self.oracle = OracleArena(config.to_dict())

    def reset(self, seed: int) -> None:
        self.oracle.reset(seed)

    def play(self, actions: Sequence[Action], prey: Sequence[Command]) -> None:
        self.oracle.step(actions, prey)

    def withdraw(self, seat: int) -> None:
        self.oracle.withdraw(seat)

    def withdraw_prey(self, index: int) -> None:
        self.oracle.withdraw_prey(index)

    def place(self, hunters: Any, targets: Any = ()) -> None:
        self.oracle.place(hunters, targets)

    def numbers(self) -> list[float]:
        return self.oracle.numbers()

    def digest(self) -> bytes:
        return self.oracle.digest()

    def evidence(self) -> list[Evidence | None]:
        return [None if found is None else Evidence(Verdict(found[0]), *found[1:]) for found in self.oracle.rulings]

    def observation(self, seat: int) -> list[float]:
        return self.oracle.observations()[seat]

    def mask(self, seat: int) -> list[int]:
        return self.oracle.masks()[seat] or []

    def prey_observation(self, index: int) -> list[float]:
        return self.oracle.prey_observations()[index]

    rewards = property(lambda self: self.oracle.rewards)
    parts = property(lambda self: self.oracle.parts)
    team_scores = property(lambda self: self.oracle.team_scores())
    prey_rewards = property(lambda self: self.oracle.prey_rewards)
    prey_parts = property(lambda self: self.oracle.prey_parts)
    caught_by = property(lambda self: self.oracle.caught_by)
    terminated = property(lambda self: self.oracle.terminated)
    truncated = property(lambda self: self.oracle.truncated)


def as_arrays(config: ArenaConfig, actions: Sequence[Action]) -> tuple[np.ndarray, np.ndarray]:
    """One arena's actions as the engine's choices (H,) and commands (H, 2)."""
    choices = np.zeros(config.hunters, np.int64)
    commands = np.zeros((config.hunters, 2), np.float32)
    for seat, (control, action) in enumerate(zip(config.controls, actions, strict=True)):
        if control == "target":
            choices[seat] = action
        elif control == "velocity":
            commands[seat] = action
        else:
            commands[seat], choices[seat] = action
    return choices, commands


def by_seat(rulings: Sequence[Ruling], config: ArenaConfig) -> list[Evidence | None]:
    """An arena's rulings as one entry a seat."""
    found: list[Evidence | None] = [None] * config.hunters
    for ruling in rulings:
        assert found[ruling.hunter] is None, "two rulings for one seat"
        number = None if ruling.target is None else int(str(ruling.target).removeprefix(config.name_prefix))
        found[ruling.hunter] = Evidence(ruling.verdict, number, ruling.distance_um, ruling.winner)
    return found


class EngineAdjudicator(Adjudicator):
    """One row of the engine; in a batch the other rows play matches of their own beside it."""

    def __init__(self, config: ArenaConfig, arenas: int = 1, row: int = 0) -> None:
        from catch_arena.engine import Engine

        super().__init__(config)
        self.engine = Engine(config, arenas)
        self.arenas = arenas
        self.row = row
        self.others = np.random.default_rng(37)

    def reset(self, seed: int) -> None:
        self.engine.reset([(seed + 1000 * (row - self.row)) % 2**64 for row in range(self.arenas)])

    def play(self, actions: Sequence[Action], prey: Sequence[Command]) -> None:
        hunters, agents = self.config.hunters, self.config.hunters + self.config.prey
        choices = self.others.integers(0, 2, (self.arenas, hunters))
        for seat, control in enumerate(self.config.controls):
            if control == "velocity":
                choices[:, seat] = 0
        commands = self.others.uniform(-1, 1, (self.arenas, agents, 2)).astype(np.float32)
        choices[self.row], commands[self.row, :hunters] = as_arrays(self.config, actions)
        commands[self.row, hunters:] = np.reshape(prey, (-1, 2))
        self.engine.step(choices, commands)

    def withdraw(self, seat: int) -> None:
        self.engine.withdraw(self.row, seat)

    def withdraw_prey(self, index: int) -> None:
        self.engine.withdraw(self.row, self.config.hunters + index)

    def place(self, hunters: Any, targets: Any = ()) -> None:
        self.engine.place(self.row, hunters=hunters, targets=targets)

    def numbers(self) -> list[float]:
        return [float(number) for number in self.engine.state(self.row)]

    def digest(self) -> bytes:
        return bytes(self.engine.digest(self.row))

    def evidence(self) -> list[Evidence | None]:
        return by_seat(self.engine.world(self.row).rulings, self.config)

    def observation(self, seat: int) -> list[float]:
        return [float(number) for number in self.engine.observations[self.row, seat, : observation_size(self.config)]]

    def mask(self, seat: int) -> list[int]:
        if self.config.controls[seat] == "velocity":
            return []
        return [int(bit) for bit in self.engine.masks[self.row, seat]]

    def prey_observation(self, index: int) -> list[float]:
        own = self.engine.observations[self.row, self.config.hunters + index, : prey_observation_size(self.config)]
        return [float(number) for number in own]

    rewards = property(lambda self: self.engine.rewards[self.row, : self.config.hunters].tolist())
    parts = property(lambda self: [tuple(float(part) for part in row) for row in self.engine.parts[self.row]])
    team_scores = property(lambda self: list(self.engine.world(self.row).team_scores))
    prey_rewards = property(lambda self: self.engine.rewards[self.row, self.config.hunters :].tolist())
    prey_parts = property(lambda self: [tuple(map(float, row)) for row in self.engine.prey_parts[self.row]])
    caught_by = property(lambda self: [prey.caught_by for prey in self.engine.world(self.row).prey])
    terminated = property(lambda self: bool(self.engine.ends[self.row] == rows.TERMINATED))
    truncated = property(lambda self: bool(self.engine.ends[self.row] == rows.TRUNCATED))


class EnvAdjudicator(Adjudicator):
    """The PettingZoo parallel env by its public methods alone: what it hands out in its dictionaries.

    An env shows its state as a digest. The numbers are read from an oracle that plays along, and only while the env's
    digest (A.8) says that they are its own.
    """

    def __init__(self, config: ArenaConfig) -> None:
        from catch_arena.envs.parallel import parallel_env

        super().__init__(config)
        self.make = parallel_env
        self.env = parallel_env(config)
        self.oracle = OracleArena(config.to_dict())

    def reset(self, seed: int) -> None:
        self.seed = seed
        self.oracle.reset(seed)
        self._begin(self.config)

    def _begin(self, config: ArenaConfig) -> None:
        if self.env.config != config:
            self.env = self.make(config)
        observations, infos = self.env.reset(seed=self.seed)
        agents = self.env.agents
        self.results: Any = (
            observations,
            dict.fromkeys(agents, 0.0),
            dict.fromkeys(agents, False),
            dict.fromkeys(agents, False),
            infos,
        )
        self.is_shown = True

    def play(self, actions: Sequence[Action], prey: Sequence[Command]) -> None:
        self._step_env(actions, prey)
        self.oracle.step(actions, prey)

    def _step_env(self, actions: Sequence[Action], prey: Sequence[Command]) -> None:
        if not self.env.agents:  # the env would take no actions, and play nothing
            raise EpisodeError("this episode is over")
        given = {}
        for agent in self.env.agents:
            if agent in self.config.prey_names:
                given[agent] = np.array(prey[self.config.prey_names.index(agent)], np.float32)
                continue
            seat = int(agent.removeprefix("hunter_"))
            control, action = self.config.controls[seat], actions[seat]
            if control == "velocity":
                action = np.array(action, np.float32)
            elif control == "full":
                action = {"cmd_vel": np.array(action[0], np.float32), "catch": action[1]}
            given[agent] = action
        self.results = self.env.step(given)
        self.is_shown = True

    def withdraw(self, seat: int) -> None:
        self.env.withdraw(f"hunter_{seat}")
        self.oracle.withdraw(seat)
        self.is_shown = False

    def withdraw_prey(self, index: int) -> None:
        self.env.withdraw(f"prey_{index}")
        self.oracle.withdraw_prey(index)
        self.is_shown = False

    def place(self, hunters: Any, targets: Any = ()) -> None:
        """An env cannot move its hunters: another one begins with them there, and holds for as many steps as were
        played. Where more than motion happened before, that is another state, and fails.
        """
        self.oracle.place(hunters, targets)
        self._begin(self.config.replace(hunter_poses=tuple(hunters)))
        for _ in range(self.oracle.steps):
            self._step_env(self.at_rest, [(0.0, 0.0)] * self.config.prey)
        for x, y in targets:
            self.env._engine.spawn(0, x, y, 0.0)
            self.is_shown = False
        self._require_the_oracles_state()

    def look(self) -> None:
        """Take a step of holding if the env has not observed this state."""
        if not self.is_shown:
            self.hold()

    def _require_the_oracles_state(self) -> None:
        assert self.env.digest() == self.oracle.digest(), "the env's state is not what the oracle's numbers say"

    def numbers(self) -> list[float]:
        self._require_the_oracles_state()
        return self.oracle.numbers()

    def digest(self) -> bytes:
        return self.env.digest()

    def evidence(self) -> list[Evidence | None]:
        found: list[Evidence | None] = []
        for seat in range(self.config.hunters):
            info = self.results[4].get(f"hunter_{seat}", {"verdict": 0})
            if info["verdict"] == 0:
                found.append(None)
                continue
            given = (None if info[name] == -1 else info[name] for name in ("target", "distance_um", "winner"))
            found.append(Evidence(Verdict(info["verdict"]), *given))
        return found

    def observation(self, seat: int) -> list[float]:
        assert self.is_shown, "look first"
        return [float(number) for number in self.results[0][f"hunter_{seat}"]]

    def mask(self, seat: int) -> list[int]:
        if self.config.controls[seat] == "velocity":
            return []
        assert self.is_shown, "look first"
        mask = self.results[4][f"hunter_{seat}"]["action_mask"]
        return [int(bit) for bit in mask]

    def prey_observation(self, index: int) -> list[float]:
        assert self.is_shown, "look first"
        return [float(number) for number in self.results[0][f"prey_{index}"]]

    def _of_prey(self, results: Any, default: Any) -> list[Any]:
        return [results.get(name, default) for name in self.config.prey_names]

    def _of_seats(self, results: Any, default: Any) -> list[Any]:
        return [results.get(f"hunter_{seat}", default) for seat in range(self.config.hunters)]

    rewards = property(lambda self: self._of_seats(self.results[1], 0.0))
    parts = property(
        lambda self: [
            tuple(info["reward_parts"].tolist()) if info else (0.0,) * len(PART_NAMES)
            for info in self._of_seats(self.results[4], None)
        ]
    )
    team_scores = property(lambda self: list(self.env.world().team_scores))
    prey_rewards = property(lambda self: self._of_prey(self.results[1], 0.0))
    prey_parts = property(
        lambda self: [
            tuple(info["reward_parts"].tolist()) if info else (0.0,) * 3
            for info in self._of_prey(self.results[4], None)
        ]
    )
    caught_by = property(
        lambda self: [
            None if info["caught_by"] == -1 else info["caught_by"]
            for info in self._of_prey(self.results[4], {"caught_by": -1})
        ]
    )
    terminated = property(lambda self: all(self._of_seats(self.results[2], True)))
    truncated = property(lambda self: any(self._of_seats(self.results[3], False)))


ADJUDICATORS = ("oracle", "engine", "batch", "parallel env")


def adjudicator(kind: str, config: ArenaConfig) -> Adjudicator:
    """The adjudicator of that name."""
    if kind == "oracle":
        return OracleAdjudicator(config)
    if kind == "engine":
        return EngineAdjudicator(config)
    if kind == "batch":
        return EngineAdjudicator(config, arenas=40, row=37)
    return EnvAdjudicator(config)


def ticks_turned(before: float, after: float, turn_rate: float) -> int:
    """Number of ticks that a turn at that rate took; the rate is so low that no wrap is crossed."""
    ticks = (after - before) / (turn_rate * 0.016)
    assert math.isclose(ticks, round(ticks), abs_tol=1e-6)
    return round(ticks)
