"""The arena as a PettingZoo parallel environment: the batch engine with one arena, agent names instead of row numbers,
and checks of the arguments that callers give.
"""

import copy
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from catch_arena.config import RULESET, ArenaConfig, require_choice, require_options
from catch_arena.core import rows
from catch_arena.engine import Engine, SavedState
from catch_arena.engine.episode_seeds import episode_seed
from catch_arena.envs.actions import checked_action
from catch_arena.envs.dictionaries import Dictionaries, Infos, of_agents
from catch_arena.envs.spaces import action_space, observation_space, vector_space
from catch_arena.equality import EqualByBits
from catch_arena.errors import ConfigError, EpisodeError
from catch_arena.layout import observation_size, prey_columns, state_columns, state_values
from catch_arena.plain import as_python
from catch_arena.render.env_display import RENDER_MODES, Display, notebook_html
from catch_arena.replay import Recorder, Replay
from catch_arena.scenarios import scenario as arena_config
from catch_arena.text import shortened
from catch_arena.world import World

Step = tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]


@dataclass(frozen=True, slots=True, eq=False)
class SavedEpisode(EqualByBits):
    """The result of `save` in a parallel or AEC env, which may be pickled and restored any number of times.

    Two saved episodes are equal if an env continues from both in the same way, bit for bit.
    """

    arena: SavedState
    seed: int | None
    possible_agents: tuple[str, ...]
    agents: tuple[str, ...]
    withdrawn: frozenset[str]
    truncated: tuple[str, ...]
    np_random: Any
    """State of the random generator; None if nothing has drawn from it."""
    replay: Replay | None
    turns: dict[str, Any] | None = None
    """State of an AEC env's turns: the agent whose turn it is, actions that were given but not played yet, and results
    of the last step. None from a parallel env.
    """


class CatchArenaEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]  # PettingZoo is not typed everywhere
    """PettingZoo environment in which hunters chase targets and an arbiter decides who catches them.

    The rules are in docs/reference/rulebook.md.

    Agents are `hunter_0`, `hunter_1`, ..., and then `prey_0`, ... if there is prey, unless `agent_names` gives other
    names. Observations are float32 vectors (docs/reference/observation.md). Under target control an action is 0 (hold)
    or a target's rank in view. Under velocity control it is two numbers in [-1, 1]. Under full control it is
    {"cmd_vel": two such numbers, "catch": a rank or 0}. A whole number is anything that `operator.index` accepts, or an
    array or tensor with one such element. Finite velocities out of bounds are clipped. `infos[agent]` holds numbers and
    arrays, of one type in every step:

    - `action_mask`: R7.2's mask, int8 (K + 1), as `action_space(agent).sample` takes it; absent under velocity control.
      With `mask_in_observation=True` the observation holds it too, under target control;
    - `verdict`: answer to the agent's catch request in this step, a number of `Verdict`; 0 without a request;
    - `target`, `distance_um`, `winner`: number of the requested target, its distance [micrometres], and the seat that
      won; each -1 for none;
    - `reward_parts`: R6.2's parts, unweighted, float64, one for each field of `RewardWeights`, in their order;
    - `active`, if hunters drop out and stay (`dropouts="fixed"`): True until the hunter drops out (R1.7);
    - `team_score`, if there are teams: the sum of its hunters' scores (R11.1);
    - `TimeLimit.truncated`: True if the agent is truncated in this step. stable-baselines3 then still counts the value
      of the last observation. A reset without a seed repeats this entry, since SuperSuit replaces the infos of the last
      step by those of the next reset.

    With `infos="mask"` an info holds only `action_mask`; under velocity control, and for prey, it is empty. With
    `infos="none"` every info is empty.

    With `dropouts="leave"` a hunter that drops out is terminated in that step, and is removed from `agents`.

    Prey's actions are two numbers in [-1, 1]. Its infos hold `active`, False while it is out; `caught_by`, the seat
    that caught it in this step, -1 for none; and `reward_parts`, R12.5's, float64 (3), in the order of
    `PreyRewardWeights`. With `prey_returns_s=None` prey that is caught is terminated in that step. Otherwise it stays
    in `agents`, and its actions are ignored until it returns (R12.3).

    Errors are ActionError, EpisodeError and ConfigError; a call that raises leaves the arena as it was.

    Args:
        scenario: name of a scenario, or a config.
        render_mode: None, "rgb_array" or "human".
        infos: "full", "mask" (only the mask) or "none".
        agent_names: names of the agents in this env: a pattern such as "agent_{seat}" or "agent_{seat:02d}", in which
            prey's seats follow the hunters', or a list with one name for each. The world, replays and digests do not
            depend on them.
        overrides: fields of ArenaConfig.

    Raises:
        ConfigError: names the setting, the requirement and the value.
    """

    metadata: dict[str, Any] = {"name": RULESET, "render_modes": list(RENDER_MODES), "is_parallelizable": True}  # noqa: RUF012 - PettingZoo's own form

    def __init__(
        self,
        scenario: str | ArenaConfig = "standard",
        render_mode: str | None = None,
        *,
        infos: Infos = "full",
        agent_names: str | Sequence[str] | None = None,
        **overrides: object,
    ) -> None:
        self.config = config = arena_config(scenario, **overrides)
        require_choice("infos", infos, get_args(Infos))
        self.render_mode = render_mode
        self.metadata = {**type(self).metadata, "render_fps": max(1, round(1000 / config.control_period_ms))}
        self.possible_agents = _agent_names(agent_names, [*config.hunter_names, *config.prey_names])
        self.agents: list[str] = []
        self.max_cycles = config.max_steps
        hunters_leave = config.dropout_rate > 0.0 and config.dropouts == "leave"
        leaves = [hunters_leave] * config.hunters + [config.prey_returns_s is None] * config.prey
        self._leaving_rows = [row for row, agent_leaves in enumerate(leaves) if agent_leaves]
        """Rows of the agents that leave when they are no longer active."""
        self._seed: int | None = None
        self._np_random: np.random.Generator | None = None
        self._withdrawn: set[str] = set()
        """Agents that `withdraw` has named in this episode."""
        self._truncated: tuple[str, ...] = ()
        """Agents whose infos have `TimeLimit.truncated` True."""
        self._engine = Engine(config)
        self._dictionaries = Dictionaries(self._engine, self.possible_agents, infos)
        self._display = Display(config, render_mode)
        self._recorder = Recorder(config)

    # observations and actions

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """R7.1, R12.4: return the space of that agent's observations; the same object in every call."""
        self._dictionaries.seat(agent)
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """R4.1, R4.4, R12.2: return the space of that agent's actions; the same object in every call."""
        self._dictionaries.seat(agent)
        return self.action_spaces[agent]

    @cached_property
    def observation_spaces(self) -> dict[str, spaces.Space[Any]]:
        """Observation space of each of `possible_agents`."""
        made = [observation_space(self.config, control) for control in self.config.controls]
        made += [vector_space(prey_columns(self.config)) for _ in range(self.config.prey)]
        return dict(zip(self.possible_agents, made, strict=True))

    @cached_property
    def action_spaces(self) -> dict[str, spaces.Space[Any]]:
        """Action space of each of `possible_agents`."""
        return {agent: action_space(self.config, control) for agent, (_, control) in self._dictionaries.seats.items()}

    @cached_property
    def state_space(self) -> spaces.Box:
        """R7.3: space of the global state."""
        return vector_space(state_columns(self.config))

    @property
    def np_random(self) -> np.random.Generator:
        """Random generator for wrappers that draw at random, such as SuperSuit's frame_skip_v0. The episode's seed
        determines it, and no rule of the game reads it.
        """
        if self._np_random is None:
            self._np_random = np.random.default_rng(self._seed)
        return self._np_random

    # playing

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begin an episode and return its first observations and infos.

        Args:
            seed: a whole number in [0, 2^64). Without a seed, the operating system gives the first one, and each later
                one follows from the one before it (A.5). The first seed then repeats a whole run.
            options: a dict or None; not used.

        Returns:
            observations and infos, each a dict by agent.

        Raises:
            ConfigError: for a seed that is not such a number, and options that are not a dict.
        """
        require_options(options)
        self._seed = episode_seed(seed, self._seed)
        if seed is not None or self.agents:  # else the infos repeat `TimeLimit.truncated`
            self._truncated = ()
        self._np_random = None
        self._engine.reset([self._seed])
        self._recorder.begin(self._seed, self._engine)
        self._withdrawn.clear()
        self.agents = self.possible_agents[:]
        if self.render_mode == "human":
            self.render()
        return self._dictionaries.observations(), self._dictionaries.infos(self._truncated)

    def step(self, actions: Mapping[str, Any]) -> Step:
        """R1.4: play one control period with an action for each of `agents`; actions of agents that left are ignored.

        Returns:
            observations, rewards, terminations, truncations and infos by agent. After the end no agent is left to act;
            then a call with no actions returns five empty dictionaries.

        Raises:
            ActionError: for a missing or illegal action, and for an unknown agent.
            EpisodeError: before the first reset, or for actions after the end.
        """
        agents, engine, by_agent = self.agents, self._engine, self._dictionaries
        if not agents:
            self._require_episode("step")
            if not isinstance(actions, Mapping) or actions:
                raise EpisodeError("cannot call step(): the episode is over; call reset() first")
            return {}, {}, {}, {}, {}  # as PettingZoo's envs; SuperSuit's wrappers need it
        by_agent.read(agents, actions)
        engine.step(by_agent.choices, by_agent.commands)  # writes the arrays from which results are made
        if self._recorder.replay is not None:
            self._recorder.replay.append(by_agent.choices[0], by_agent.commands[0], engine)
        end, leaving = engine.ends.item(), self._withdrawn
        if self._leaving_rows:
            active = engine.active[0].tolist()
            leaving = leaving.union(self.possible_agents[row] for row in self._leaving_rows if not active[row])
        terminations = dict.fromkeys(agents, end == rows.TERMINATED)
        truncations = dict.fromkeys(agents, end == rows.TRUNCATED)
        for agent in leaving:
            if agent in terminations:
                terminations[agent], truncations[agent] = True, False
        self._truncated = tuple(agent for agent in agents if truncations[agent]) if end else ()
        observations, rewards, infos = by_agent.observations(), by_agent.rewards(), by_agent.infos(self._truncated)
        if len(agents) < len(infos):
            observations, rewards = of_agents(agents, observations), of_agents(agents, rewards)
            infos = of_agents(agents, infos)
        if end or leaving:
            self.agents = [agent for agent in agents if not (terminations[agent] or truncations[agent])]
        if self.render_mode == "human":
            self.render()
        return observations, rewards, terminations, truncations, infos

    def check_action(self, agent: str, action: object) -> None:
        """Raise the ActionError that `step` would raise for that action; the arena does not change."""
        _, control = self._dictionaries.seat(agent)
        checked_action(control, agent, action, self.config.targets_seen, clip=True)

    def withdraw(self, agent: str) -> None:
        """R1.6, R12.5: withdraw an agent from the rest of the episode.

        The agent is among `agents` for one more step, in which none of its requests is granted. That step ends with its
        termination and its last observation. Withdrawn prey stands still, and can be caught.
        """
        row, _ = self._dictionaries.seat(agent)
        if agent not in self.agents:
            raise EpisodeError(f"cannot withdraw {agent}: it is not among the agents of this episode")
        if agent not in self._withdrawn:
            self._engine.withdraw(0, row)
            self._withdrawn.add(agent)
            self._recorder.withdraw(row)

    def world(self) -> World:
        """Return the arena in the world frame, for people, rendering and tests."""
        self._require_episode("world")
        return self._engine.world()

    def hunter_observations(self) -> NDArray[np.float32]:
        """R7.1: return a copy of all hunters' current observations, by seat, (H, D); hunters that left are included."""
        self._require_episode("hunter_observations")
        return self._engine.observations[0, : self.config.hunters, : observation_size(self.config)].copy()

    def state(self) -> NDArray[np.float32]:
        """R7.3: return the global state as one float32 vector, in the order of `layout.state_columns`."""
        self._require_episode("state")
        return np.array(state_values(self._engine.world(), self.config), dtype=np.float32)

    def digest(self) -> bytes:
        """A.8: return the digest of the state, eight bytes."""
        self._require_episode("digest")
        return self._engine.digest()

    # saving and replays

    def record(self, names: Sequence[str] | None = None, title: str = "") -> None:
        """Record every episode from the next reset on. `names` are players' names, in the order of `possible_agents`.

        Raises:
            ConfigError: for a name or a title that is not at most 200 printable characters.
        """
        import catch_arena.player  # noqa: F401 - notebooks show replays with it

        usual = self.config.hunter_names + self.config.prey_names
        self._recorder.record(usual if names is None else names, title)

    def replay(self) -> Replay:
        """Return the replay of the episode so far, if `record` was called before its reset."""
        if self._recorder.replay is None:
            raise EpisodeError("there is no replay: call record() and then reset()")
        return self._recorder.replay

    def save(self) -> SavedEpisode:
        """R10.2: return the state of the episode. `restore` takes it any number of times, in this env or in another one
        of an equal config.

        Raises:
            EpisodeError: before the first reset.
        """
        self._require_episode("save")
        replay = self._recorder.replay
        return SavedEpisode(
            arena=self._engine.save(0),
            seed=self._seed,
            possible_agents=tuple(self.possible_agents),
            agents=tuple(self.agents),
            withdrawn=frozenset(self._withdrawn),
            truncated=self._truncated,
            np_random=None if self._np_random is None else self._np_random.bit_generator.state,
            replay=None if replay is None else replay.copy(),
        )

    def restore(self, saved: SavedEpisode) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Continue from a saved episode, bit for bit.

        Returns:
            observations and infos of `agents`, as they were when saved; empty dicts if the episode was over.

        Raises:
            ConfigError: for anything that `save` did not return, and for the state of another config or another
                version.
        """
        if not isinstance(saved, SavedEpisode) or getattr(saved, "turns", saved) is not None:  # an old pickle has none
            raise ConfigError(f"saved must be a state that a parallel env's save() returned, got {shortened(saved)}")
        names = list(saved.possible_agents)
        if len(names) == len(self.possible_agents) and names != self.possible_agents:  # else the configs differ
            raise ConfigError(
                f"saved must come from an env with the agents {self.possible_agents}, got {shortened(names)}"
            )
        self._engine.restore(saved.arena, 0)
        self._seed, self.agents = saved.seed, list(saved.agents)
        self._withdrawn, self._truncated = set(saved.withdrawn), saved.truncated
        self._np_random = None
        if saved.np_random is not None:
            self.np_random.bit_generator.state = saved.np_random
        self._recorder.replay = None if saved.replay is None else saved.replay.copy()
        observations, infos = self._dictionaries.observations(), self._dictionaries.infos(self._truncated)
        return of_agents(self.agents, observations), of_agents(self.agents, infos)

    def clone(self) -> "CatchArenaEnv":
        """Return an independent env in the same state, without a window; `copy.deepcopy` does the same."""
        return copy.deepcopy(self)

    # rendering

    def render(self) -> NDArray[np.uint8] | None:
        """Return a new (height, width, 3) uint8 frame under "rgb_array"; under "human" show the last step in the
        window.
        """
        if self.render_mode is None:
            return None
        self._require_episode("render")
        return self._display.render(self._engine.world())

    def _repr_html_(self) -> str:
        """Return the HTML that a notebook shows for this env."""
        world = None if self._seed is None else self._engine.world()
        return notebook_html(str(self), self.config, world, self._recorder.replay)

    def close(self) -> None:
        """Close the window, if there is one."""
        self._display.close()

    def _require_episode(self, method: str) -> None:
        if self._seed is None:
            raise EpisodeError(f"cannot call {method}(): no episode has begun; call reset() first")


def _agent_names(given: str | Sequence[str] | None, usual: list[str]) -> list[str]:
    """Return the names of an env's agents, by a pattern with {seat} or a list; the usual ones for None."""
    if given is None:
        return usual
    names = as_python(given)
    if isinstance(given, str) and "{seat" in given:
        with suppress(ValueError, LookupError, AttributeError, TypeError):  # it is no pattern
            names = [given.format(seat=seat) for seat in range(len(usual))]
    are_names = isinstance(names, list | tuple) and all(isinstance(name, str) and name for name in names)
    if not are_names or not len(set(names)) == len(names) == len(usual):
        pattern = 'a pattern such as "agent_{seat}" or "agent_{seat:02d}"'
        raise ConfigError(f"agent_names must be {pattern}, or {len(usual)} different names, got {shortened(given)}")
    return list(names)


parallel_env = CatchArenaEnv
"""PettingZoo's name for the maker of a parallel environment."""
