"""The arena as a PettingZoo parallel environment: the batch engine with one arena, names for seats, and checks of
what callers give.
"""

import copy
from bisect import insort
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import Any, Final, Literal, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from catch_arena.config import RULESET, ArenaConfig, Control, require_choice, require_options
from catch_arena.core import state
from catch_arena.engine import Engine
from catch_arena.engine.block_views import row_of
from catch_arena.engine.episode_seeds import episode_seed
from catch_arena.envs.global_state import state_vector
from catch_arena.envs.saved import require_memory
from catch_arena.envs.spaces import (
    action_space,
    checked_action,
    checked_choice,
    checked_command,
    checked_full,
    observation_space,
    prey_observation_space,
    require_pose,
    state_space,
    velocity_space,
)
from catch_arena.equality import equal_fields
from catch_arena.errors import ActionError, ConfigError, EpisodeError, require_type, suggest
from catch_arena.plain import as_python, whole_number
from catch_arena.replay import Replay, checked_names, checked_text
from catch_arena.scenarios import scenario as arena_config
from catch_arena.text import in_short
from catch_arena.verdicts import NO_REQUEST
from catch_arena.world import World

Infos = Literal["full", "mask", "none"]
"""R7.2: what an env tells in its infos."""
RENDER_MODES: Final = ("rgb_array", "human")
RENDER_SIZE: Final = (500, 500)
"""Of the frames that `render` gives: turtlesim's window."""

_UNCHANGING: Final = frozenset(
    ("config", "_controls", "_observation_spaces", "_record_as", "_places", "_seats", "_prey")
)
"""What an env and its copies share, or see anew: to copy it would take longer than all the rest."""
_BOUND: Final = ("_choice_items", "_command_items")
"""Memoryviews, which `_bind_actions` makes again."""
_CAUGHT_BY = row_of(state.CAUGHT_BY)
_NO_ANSWER: Final = {
    "verdict": NO_REQUEST,
    "target": -1,
    "distance_um": -1,
    "winner": -1,
    "TimeLimit.truncated": False,
}


@dataclass(frozen=True, slots=True, eq=False)
class SavedEpisode:
    """What `CatchArenaEnv.save` gives: as many can be kept, and pickled, as one likes.

    Two are equal if an env goes on from both in the same way: equal in every bit.
    """

    __eq__ = equal_fields
    __hash__ = None  # type: ignore[assignment]

    config: str
    """The digest of the arena's config."""
    seed: int | None
    memory: NDArray[np.uint8]
    """The arena and what it told last, as the engine keeps them."""
    agents: tuple[str, ...]
    over: bool
    leaving: frozenset[str]
    np_random: Any
    """The state of the generator, None where nothing has drawn from it."""
    replay: Replay | None
    possible_agents: tuple[str, ...]


def parallel_env(
    scenario: str | ArenaConfig = "standard",
    render_mode: str | None = None,
    *,
    infos: Infos = "full",
    agent_names: str | Sequence[str] | None = None,
    **overrides: object,
) -> "CatchArenaEnv":
    """The arena as a PettingZoo parallel environment.

    Args:
        scenario: a name or a config.
        render_mode: None, "rgb_array" or "human".
        infos: "full", "mask" (the mask alone) or "none": see CatchArenaEnv.
        agent_names: what this env calls its agents: a pattern such as "agent_{seat}" or "agent_{seat:02d}", in which
            prey's seats follow the hunters', or a list with one name for each. The world, replays and digests do not
            depend on it.
        overrides: fields of ArenaConfig.

    Raises:
        ConfigError: that names the setting, the requirement and the value.
    """
    return CatchArenaEnv(arena_config(scenario, **overrides), render_mode, infos, agent_names)


class CatchArenaEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]  # PettingZoo is not typed everywhere
    """Hunters chase targets; the arbiter decides (docs/rulebook.md).

    Agents are `hunter_0`, `hunter_1`, ..., and then `prey_0`, ... where there is prey, unless `agent_names` gives other
    names. Observations are float32 vectors (docs/observation.md). Under target control an action is 0 (hold) or a
    target's rank in view; under velocity control two numbers in [-1, 1]; under full control {"cmd_vel": two such
    numbers, "catch": a rank or 0}. A whole number is whatever `operator.index` takes, or an array or tensor with one
    such element; finite velocities out of bounds are clipped. `infos[agent]` holds numbers and arrays, of one type in
    every step:

    - `action_mask`: R7.2's mask, int8 (K + 1), as `action_space(agent).sample` takes it; not under velocity control.
      With `mask_in_observation=True` it is in the observation too, under target control;
    - `verdict`: the answer to the agent's catch request in this step, a number of `Verdict`, 0 without a request;
    - `target`, `distance_um`, `winner`: the number of the target that was requested, its distance, and the seat that
      won; each -1 for none;
    - `reward_parts`: R6.2's parts, unweighted, float64 (7), in the order of `RewardWeights`;
    - `active`, where hunters drop out and stay (`dropouts="fixed"`): whether it has not (R1.7);
    - `team_score`, where there are teams: the sum of its hunters' scores (R11.1);
    - `TimeLimit.truncated`: whether the agent is truncated in this step; by it stable-baselines3 knows that the value
      of the last observation still counts. A reset without a seed repeats it, since SuperSuit writes the infos of the
      next reset over those of the last step.

    With `infos="mask"` an info holds `action_mask` alone; under velocity control, and for prey, nothing. With
    `infos="none"` it is empty.

    With `dropouts="leave"` a hunter that drops out is terminated in that step, and no longer among `agents`.

    Prey's actions are two numbers in [-1, 1], and its infos hold `active`, whether it is not out; `caught_by`, the seat
    that caught it in this step, -1 for none; and `reward_parts`, R12.5's, float64 (3), in the order of
    `PreyRewardWeights`. With `prey_returns_s=None` prey that is caught is
    terminated in that step; else it stays, and its actions are ignored until it returns (R12.3).

    Errors are ActionError, EpisodeError and ConfigError; a call that raises leaves the arena as it was.
    """

    metadata: dict[str, Any] = {"name": RULESET, "render_modes": list(RENDER_MODES), "is_parallelizable": True}  # noqa: RUF012 - PettingZoo's own form

    def __init__(
        self,
        config: ArenaConfig,
        render_mode: str | None = None,
        infos: Infos = "full",
        agent_names: str | Sequence[str] | None = None,
    ) -> None:
        require_type("config", config, ArenaConfig, "scenario(name)")
        require_choice("infos", infos, get_args(Infos))
        require_choice("render_mode", render_mode, (None, *RENDER_MODES))
        if render_mode is not None:
            import catch_arena.render.optional_imports  # noqa: F401 - where they are missing, it is said now
        self.config = config
        self.render_mode = render_mode
        self._infos_level = infos
        self.metadata = {**type(self).metadata, "render_fps": max(1, round(1000 / config.control_period_ms))}
        self.possible_agents = _checked_agent_names(agent_names, [*config.hunter_names, *config.prey_names])
        self.agents: list[str] = []
        self._nobody: dict[str, bool] = {}
        """False for each of `agents`: copied, since a dict made anew takes five times as long."""
        self._hunters_here: list[tuple[str, int]] = []
        self._prey_here: list[tuple[str, int]] = []
        """The hunters among `agents`, with their seats, and the prey among them, with its indices."""
        self.max_cycles = config.max_steps
        self._seats = {name: seat for seat, name in enumerate(self.possible_agents[: config.hunters])}
        self._prey = {name: index for index, name in enumerate(self.possible_agents[config.hunters :])}
        drives_itself: tuple[Control] = ("velocity",)
        controls = config.controls + drives_itself * config.prey
        self._places = dict(zip(self.possible_agents, enumerate(controls), strict=True))
        """Each agent's index and control; prey drives itself."""
        self._observation_spaces: dict[str, spaces.Space[Any]] = {}
        self._action_spaces: dict[str, spaces.Space[Any]] = {}
        self._engine = Engine(config)
        self._choices = np.zeros((1, config.hunters), dtype=np.int64)
        self._commands = np.zeros((1, len(self.possible_agents), 2), dtype=np.float32)
        self._bind_actions()
        self._controls = config.controls
        self._ranks = config.targets_seen
        self._all_target_control = set(config.controls) == {"target"} and not config.prey
        self._seed: int | None = None
        self._np_random: np.random.Generator | None = None
        self._over = True
        self._dropouts_leave = config.dropout_rate > 0.0 and config.dropouts == "leave"
        self._dropouts_stay = config.dropout_rate > 0.0 and config.dropouts == "fixed"
        self._prey_leaves = config.prey > 0 and config.prey_returns_s is None
        self._team_by_seat = config.team_by_seat
        self._mask_in_observation = config.mask_in_observation
        self._leaving: set[str] = set()
        """Who leaves with the end of the next step, and who has left."""
        self._record_as: tuple[tuple[str, ...], str] | None = None
        self._replay: Replay | None = None
        self._painter: Any = None
        self._window: Any = None

    def _bind_actions(self) -> None:
        """Note views of the arrays in which the engine gets actions."""
        hunters = self.config.hunters
        self._hunter_commands = self._commands[:, :hunters]
        self._prey_commands = self._commands[:, hunters:] if self._prey else None
        # items of a memoryview are written in half the time of an array's
        self._choice_items: Any = self._choices[0].data
        self._command_items: Any = self._commands.reshape(-1).data

    def __deepcopy__(self, memo: dict[int, Any]) -> "CatchArenaEnv":
        twin = object.__new__(type(self))
        state = self.__getstate__()
        twin.__dict__ = {
            name: value if name in _UNCHANGING else copy.deepcopy(value, memo) for name, value in state.items()
        }
        twin._observation_spaces = {}  # made anew when they are asked for: nobody draws from them
        twin._bind_actions()
        return twin

    def __getstate__(self) -> dict[str, Any]:
        """All but the window, what is painted in it, and memoryviews, which belong to one env and one process."""
        return {**self.__dict__, "_painter": None, "_window": None, **dict.fromkeys(_BOUND)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """What was copied or unpickled looks at its own engine."""
        self.__dict__.update(state)
        self._bind_actions()

    def __str__(self) -> str:
        return str(self.metadata["name"])

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """R7.1, R12.4: what that agent sees; the same object in every call."""
        return self._space(observation_space, prey_observation_space, self._observation_spaces, agent)

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """R4.1, R4.4, R12.2: what that agent may do; the same object in every call."""
        return self._space(action_space, lambda _config: velocity_space(), self._action_spaces, agent)

    @property
    def observation_spaces(self) -> dict[str, spaces.Space[Any]]:
        """The observation space of each of `possible_agents`."""
        return {agent: self.observation_space(agent) for agent in self.possible_agents}

    @property
    def action_spaces(self) -> dict[str, spaces.Space[Any]]:
        """The action space of each of `possible_agents`."""
        return {agent: self.action_space(agent) for agent in self.possible_agents}

    @cached_property
    def state_space(self) -> spaces.Box:
        """R7.3: the global view."""
        return state_space(self.config)

    @property
    def np_random(self) -> np.random.Generator:
        """For wrappers that draw at random, such as SuperSuit's frame_skip_v0: it follows from the episode's seed, and
        no rule reads it.
        """
        if self._np_random is None:
            self._np_random = np.random.default_rng(self._seed)
        return self._np_random

    def _space(
        self,
        make: Callable[[ArenaConfig, Control], spaces.Space[Any]],
        make_of_prey: Callable[[ArenaConfig], spaces.Space[Any]],
        made: dict[str, spaces.Space[Any]],
        agent: str,
    ) -> spaces.Space[Any]:
        """Made when it is asked for: a match asks for none, and they would take most of what an env takes."""
        if self._known(agent) not in made:
            seat = self._seats.get(agent)
            made[agent] = make_of_prey(self.config) if seat is None else make(self.config, self._controls[seat])
        return made[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Args:
            seed: a whole number in [0, 2^64); without one the first episode's is the operating system's, and each
                further one follows from the one before (A.5), so that a run is repeated by its first seed.
            options: a dict or None; not used.

        Returns:
            observations and infos by agent.

        Raises:
            ConfigError: for a seed that is no such number, and options that are no dict.
        """
        require_options(options)
        follows = seed is None and self._engine.ends.item() == state.TRUNCATED
        cut = [agent for agent in self.possible_agents if agent not in self._leaving] if follows else ()
        self._seed = episode_seed(seed, self._seed)
        self._np_random = None
        self._engine.reset([self._seed])
        self._set_agents(self.possible_agents[:])
        self._over = False
        self._leaving.clear()
        self._replay = None
        if self._record_as is not None:
            names, title = self._record_as
            self._replay = Replay(self.config, self._seed, names, title)
            self._replay.note(self._engine)
        if self.render_mode == "human":
            self.render()
        return self._observations(), self._infos(cut)

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """R1.4: one control period; an action for each of `agents`. Actions of agents that have left are ignored.

        Returns:
            observations, rewards, terminations, truncations and infos by agent; after the end, where nobody is left to
            act, five empty dictionaries for no actions.

        Raises:
            ActionError: for an action that is missing or not legal, and an unknown agent.
            EpisodeError: before the first reset, or for actions after the end.
        """
        if self._over:
            if self._seed is not None and not actions:  # as PettingZoo's own envs; SuperSuit's wrappers do it
                return {}, {}, {}, {}, {}
            raise EpisodeError(
                "step must follow a reset: "
                + ("no episode has begun" if self._seed is None else "this episode is over")
            )
        self._apply_actions(actions)
        engine = self._engine
        engine.step(self._choices, self._hunter_commands, self._prey_commands)
        if self._replay is not None:
            prey_commands = None if self._prey_commands is None else self._prey_commands[0]
            self._replay.append(self._choices[0], self._hunter_commands[0], engine, prey_commands)
        agents = self.agents
        ended = engine.ends.item()
        terminations, truncations = self._nobody.copy(), self._nobody.copy()
        if ended:
            (terminations if ended == state.TERMINATED else truncations).update(dict.fromkeys(agents, True))
        earned = engine.rewards[0].tolist()
        if self._prey:
            earned += engine.prey_rewards[0].tolist()
        rewards = dict(zip(self.possible_agents, earned))  # noqa: B905 - half as long again, in each step
        if len(agents) < len(self.possible_agents):
            rewards = {agent: rewards[agent] for agent in agents}
        if self._dropouts_leave:
            active = engine.active[0].tolist()
            self._leaving.update(agent for agent, seat in self._seats.items() if not active[seat])
        if self._prey_leaves:
            in_play = engine.prey_active[0].tolist()
            self._leaving.update(agent for agent, index in self._prey.items() if not in_play[index])
        if self._leaving:
            for agent in self._leaving & terminations.keys():
                terminations[agent], truncations[agent] = True, False
        cut = [agent for agent in agents if truncations[agent]] if ended else ()
        observations, infos = self._observations(), self._infos(cut)
        if ended:
            self._over = True
            self._set_agents([])
        elif self._leaving:
            self._set_agents([agent for agent in agents if agent not in self._leaving])
            self._over = not self.agents
        if self.render_mode == "human":
            self.render()
        return observations, rewards, terminations, truncations, infos

    def _set_agents(self, agents: list[str]) -> None:
        self.agents = agents
        self._nobody = dict.fromkeys(agents, False)
        self._hunters_here = [(agent, self._seats[agent]) for agent in agents if agent in self._seats]
        self._prey_here = [(agent, self._prey[agent]) for agent in agents if agent in self._prey]

    def withdraw(self, agent: str) -> None:
        """R1.6, R12.5: the agent takes no further part.

        It is among `agents` for one more step, in which none of its requests is granted; that step ends with its
        termination and its last observation. Prey stands still, and can be caught.
        """
        self._known(agent)
        if self._over or agent not in self.agents:
            raise EpisodeError(f"{agent} must be in play to be withdrawn")
        if agent in self._leaving:
            return
        if agent in self._prey:
            self._engine.withdraw_prey(0, self._prey[agent])
        else:
            self._engine.withdraw(0, self._seats[agent])
        self._leaving.add(agent)
        if self._replay is not None:
            insort(self._replay.withdrawals, (self._replay.steps, self._places[agent][0]))  # agents fail in any order

    def spawn(self, x: float, y: float, theta: float = 0.0) -> str:
        """R8.1: a target outside the timer; its name, or "" where the arena is full. A recorded episode takes none."""
        self._require_changeable("spawn")
        require_pose(self.config, x, y, theta)
        number = self._engine.spawn(0, x, y, theta)
        return self.config.target_name(number) if number else ""

    def kill(self, name: str) -> bool:
        """R8.1: an alive target leaves uncaught; false without one of that name, and for one that prey plays, which is
        never killed. A recorded episode takes none.
        """
        self._require_changeable("kill")
        numbers = {target.name: target.number for target in self._engine.world().targets}
        return isinstance(name, str) and name in numbers and self._engine.kill(0, numbers[name])

    def _require_changeable(self, what: str) -> None:
        self._require_episode(what)
        if self._over or self._replay is not None:
            why = "this episode is over" if self._over else "a replay could not play it again"
            raise EpisodeError(f"{what} must fall into an episode that is under way and not recorded: {why}")

    def world(self) -> World:
        """The arena in the world frame, for people, rendering and tests."""
        self._require_episode("world")
        return self._engine.world()

    def rank_of(self, seat: int, name: str) -> int:
        """R7.1: the rank at which a seat sees the target of that name, 0 where it does not.

        Raises:
            ActionError: for a seat that no hunter has.
        """
        self._require_episode("rank_of")
        number = whole_number(seat)
        if number is None or not 0 <= number < self.config.hunters:
            raise ActionError(f"seat must be a whole number from 0 to {self.config.hunters - 1}, got {in_short(seat)}")
        return self._engine.rank_of(0, number, name)

    def hunter_observations(self) -> NDArray[np.float32]:
        """What all hunters observe now (R7.1), by seat, whether they act or have left: (H, D), a copy."""
        self._require_episode("hunter_observations")
        observations: NDArray[np.float32] = self._engine.observations[0].copy()
        return observations

    def state(self) -> NDArray[np.float32]:
        """R7.3: the global view as one float32 vector, in the order of `layout.state_columns`."""
        self._require_episode("state")
        return state_vector(self._engine.world(), self.config)

    def digest(self) -> bytes:
        """A.8: eight bytes that stand for the state."""
        self._require_episode("digest")
        return self._engine.digest()

    def record(self, names: Sequence[str] | None = None, title: str = "") -> None:
        """Keep every episode from the next reset on; `names` are those of `possible_agents`, in their order.

        Raises:
            ConfigError: for a name or a title that is not at most 200 printable characters.
        """
        import catch_arena.player  # noqa: F401 - notebooks show the replay by it

        agents = self.config.hunter_names + self.config.prey_names
        called = checked_names(agents if names is None else names, self.config)
        checked_text("name_prefix", self.config.name_prefix)
        self._record_as = (called, checked_text("title", title))

    def replay(self) -> Replay:
        """The episode so far, where `record` was called before its reset."""
        if self._replay is None:
            raise EpisodeError("replay must follow a record and a reset: nothing was recorded")
        return self._replay

    def save(self) -> SavedEpisode:
        """R10.2: the episode as it stands; `restore` takes it back, here or in an env of an equal config, at any time
        and as often as one likes.

        Raises:
            EpisodeError: before the first reset.
        """
        self._require_episode("save")
        return SavedEpisode(
            config=self._config_digest,
            seed=self._seed,
            memory=self._engine.save_row(0),
            agents=tuple(self.agents),
            over=self._over,
            leaving=frozenset(self._leaving),
            np_random=None if self._np_random is None else self._np_random.bit_generator.state,
            replay=None if self._replay is None else self._replay.copy(),
            possible_agents=tuple(self.possible_agents),
        )

    def restore(self, saved: SavedEpisode) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Go on from a saved episode, bit for bit.

        Returns:
            observations and infos of `agents`, as they were; after the end, when there are none, empty dicts.

        Raises:
            ConfigError: for what `save` did not give, or did for another config or in another version.
        """
        if not isinstance(saved, SavedEpisode):
            raise ConfigError(f"saved must be what save gives, got {in_short(saved)}")
        if saved.config != self._config_digest:
            raise ConfigError(
                f"saved must come from an arena of equal config, {self._config_digest}, got {saved.config}"
            )
        memory = require_memory(self._engine, saved.memory, alone=True)
        if list(saved.possible_agents) != self.possible_agents:
            got = in_short(list(saved.possible_agents))
            raise ConfigError(f"saved must come from an env with the agents {self.possible_agents}, got {got}")
        self._seed = saved.seed
        self._engine.restore_row(0, memory)
        self._set_agents(list(saved.agents))
        self._over = saved.over
        self._leaving = set(saved.leaving)
        self._np_random = None
        if saved.np_random is not None:
            self.np_random.bit_generator.state = saved.np_random
        self._replay = None if saved.replay is None else saved.replay.copy()
        return self._observations(), self._infos()

    def clone(self) -> "CatchArenaEnv":
        """An env of its own in the same state, as `copy.deepcopy` makes it too; without a window."""
        return copy.deepcopy(self)

    @cached_property
    def _config_digest(self) -> str:
        return self.config.digest

    def render(self) -> NDArray[np.uint8] | None:
        """A fresh (height, width, 3) uint8 frame under "rgb_array"; under "human" the window shows the last step."""
        if self.render_mode is None:
            return None
        self._require_episode("render")
        from catch_arena.render.renderer import ArenaPainter

        if self._painter is None:
            self._painter = ArenaPainter(self.config, size=RENDER_SIZE)
        if self.render_mode == "rgb_array":
            frame: NDArray[np.uint8] = self._painter.paint(self._engine.world())
            return frame
        from catch_arena.render.window import Window

        if self._window is None:
            self._window = Window("Catch Arena", RENDER_SIZE)
        lasts_ms = self._painter.enter(self._engine.world())
        self._window.play(self._painter.draw, lasts_ms)
        return None

    def _repr_html_(self) -> str:
        """How a notebook shows it: a recorded episode plays, of another one there is a picture of its present."""
        if self._replay is not None and self._replay.steps:
            return self._replay._repr_html_()
        if self._seed is None:
            return f"<p>{escape(str(self))}: no episode has begun</p>"
        try:
            from catch_arena.render.renderer import png_html
        except ConfigError as error:  # without the libraries that draw
            return f"<p>{escape(str(self))}: {escape(str(error))}</p>"
        return png_html(self.config, self._engine.world())

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def check_action(self, agent: str, action: object) -> None:
        """Raise the ActionError that `step` would raise for that action; nothing moves."""
        _, control = self._places[self._known(agent)]
        checked_action(control, agent, action, self._ranks, clip=True)

    def _known(self, agent: str) -> str:
        if not isinstance(agent, str) or (agent not in self._seats and agent not in self._prey):
            raise ActionError(f"unknown agent {agent!r}: {suggest(agent, self.possible_agents)}")
        return agent

    def _require_episode(self, what: str) -> None:
        if self._seed is None:
            raise EpisodeError(f"{what} must follow a reset: no episode has begun")

    def _apply_actions(self, actions: Mapping[str, Any]) -> None:
        if type(actions) is not dict and not isinstance(actions, Mapping):  # the first is known at once
            raise ActionError(f"actions must map each agent to its action, got {actions!r}")
        agents = self.agents
        if len(actions) != len(agents):
            self._require_complete(actions)
        choices, commands = self._choice_items, self._command_items
        ranks, seats = self._ranks, self._seats
        try:
            if self._all_target_control:
                for agent in agents:
                    action = actions[agent]
                    legal = type(action) is int and 0 <= action <= ranks
                    choices[seats[agent]] = action if legal else checked_choice(agent, "an action", action, ranks)
            else:
                for agent in agents:
                    index, control = self._places[agent]
                    if control == "velocity":
                        speed, turn_rate = checked_command(agent, "an action", actions[agent], clip=True)
                    elif control == "full":
                        choices[index], (speed, turn_rate) = checked_full(agent, actions[agent], ranks, clip=True)
                    else:
                        choices[index] = checked_choice(agent, "an action", actions[agent], ranks)
                        continue
                    commands[2 * index] = speed
                    commands[2 * index + 1] = turn_rate
        except KeyError:
            self._require_complete(actions)
            raise  # an action's own
        for agent in self._leaving:
            if agent not in agents:
                if agent in seats:
                    choices[seats[agent]] = 0
                self._commands[0, self._places[agent][0]] = 0.0

    def _require_complete(self, actions: Mapping[str, Any]) -> None:
        """An action for each of `agents`, and others only of agents that have left."""
        for agent in actions:
            self._known(agent)
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise ActionError(f"actions must hold one for each agent, got none for {', '.join(missing)}")

    def _observations(self) -> dict[str, Any]:
        """Return a copy of what each of `agents` observes."""
        seen = self._engine.observations[0].copy()
        observations: dict[str, Any] = {agent: seen[seat] for agent, seat in self._hunters_here}
        if self._prey_here:
            seen = self._engine.prey_observations[0].copy()
            observations |= {agent: seen[index] for agent, index in self._prey_here}
        if self._mask_in_observation:
            masks = self._engine.masks[0].copy()
            for agent, seat in self._hunters_here:
                if self._controls[seat] == "target":
                    observations[agent] = {"observation": observations[agent], "action_mask": masks[seat]}
        return observations

    def _infos(self, truncated: Sequence[str] = ()) -> dict[str, dict[str, Any]]:
        """Return the info of each of `agents`."""
        if self._infos_level == "full":
            infos = self._full_infos()
            for agent in truncated:
                infos[agent]["TimeLimit.truncated"] = True
            return infos
        infos = {agent: {} for agent in self.agents}
        if self._infos_level == "mask":
            masks = self._engine.masks[0].copy()
            for agent, seat in self._hunters_here:
                if self._controls[seat] != "velocity":
                    infos[agent]["action_mask"] = masks[seat]
        return infos

    def _full_infos(self) -> dict[str, dict[str, Any]]:
        engine = self._engine
        answers, parts, masks = engine.answers.tolist(), engine.parts[0].copy(), engine.masks[0].copy()
        infos: dict[str, dict[str, Any]] = {}
        for agent, seat in self._hunters_here:
            infos[agent] = info = _NO_ANSWER.copy()
            number, verdict, distance, winner = answers[seat]
            if verdict:
                info["verdict"], info["target"] = int(verdict), int(number) or -1
                info["distance_um"], info["winner"] = int(distance), int(winner)
            info["reward_parts"] = parts[seat]
            if self._controls[seat] != "velocity":
                info["action_mask"] = masks[seat]
        if self._dropouts_stay:
            active = engine.active[0].tolist()
            for agent, seat in self._hunters_here:
                infos[agent]["active"] = active[seat]
        if self.config.teams is not None:
            scores = engine.team_scores[0].tolist()
            for agent, seat in self._hunters_here:
                infos[agent]["team_score"] = int(scores[self._team_by_seat[seat]])
        if self._prey_here:
            caught_by = engine.prey_rows(0)[:, _CAUGHT_BY].tolist()
            in_play, parts = engine.prey_active[0].tolist(), engine.prey_parts[0].copy()
            for agent, index in self._prey_here:
                infos[agent] = {
                    "active": in_play[index],
                    "caught_by": int(caught_by[index]),
                    "reward_parts": parts[index],
                    "TimeLimit.truncated": False,
                }
        return infos


def _checked_agent_names(given: str | Sequence[str] | None, usual: list[str]) -> list[str]:
    if given is None:
        return usual
    names = as_python(given)
    if isinstance(given, str) and "{seat" in given:
        try:
            names = [given.format(seat=seat) for seat in range(len(usual))]
        except (ValueError, LookupError, AttributeError, TypeError):
            raise ConfigError(
                f'agent_names must be a pattern such as "agent_{{seat}}", or "agent_{{seat:02d}}", got {given!r}'
            ) from None
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) and name for name in names):
        raise ConfigError(f"agent_names must be a pattern with {{seat}} or a list of names, got {in_short(given)}")
    if not len(set(names)) == len(names) == len(usual):
        raise ConfigError(f"agent_names must be {len(usual)} different names, got {in_short(given)}")
    return list(names)
