"""Many arenas at once: the engine's own arrays, for those who learn."""

import copy as copy_module
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import Any, Final, Literal, NamedTuple, TypeVar, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import MAX_HEADING_RAD, ArenaConfig, Control, require_flag
from catch_arena.core import episodes, prey, state
from catch_arena.core.controllers import CONTROLS
from catch_arena.engine import Engine
from catch_arena.engine.episode_seeds import batch_seeds, next_seeds
from catch_arena.envs.saved import require_memory
from catch_arena.envs.spaces import (
    action_space,
    choice_array,
    clipped,
    command_array,
    observation_space,
    prey_observation_space,
    velocity_space,
)
from catch_arena.equality import equal
from catch_arena.errors import ActionError, ConfigError, EpisodeError
from catch_arena.plain import whole_number
from catch_arena.scenarios import scenario as arena_config
from catch_arena.seeding import checked_seed, fresh_seed
from catch_arena.text import with_type
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_TERMINATED: Final = np.int8(state.TERMINATED)  # of the same type as `Engine.ends`, so that NumPy converts nothing
_TRUNCATED: Final = np.int8(state.TRUNCATED)
_MOST_ENVS: Final = 10**9  # of which a machine's memory holds fewer
_MOST_THREADS: Final = 4096
_NO_CHOICES: Final = np.zeros((0, 0), dtype=np.int64)
_NO_COMMANDS: Final = np.zeros((0, 0, 2), dtype=np.float32)

T = TypeVar("T")

Results = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]
"""Without prey; with prey the first two are dicts of such arrays."""
Begun = tuple[NDArray[np.float32], dict[str, Any]]
"""Likewise."""


class SavedState(NamedTuple):  # noqa: PLW1641 - a tuple that holds arrays has no hash in any case
    """What `VectorArena.save` and `save_row` give. Two are equal in every bit."""

    config: str
    """The digest of the arena's config."""
    num_envs: int | None
    """Of the batch; None for a single row."""
    controls: NDArray[np.int8]
    """How hunters are driven, as `set_controls` takes it: (B, H), or (H,) of a row."""
    memory: NDArray[np.uint8]
    """As the engine keeps it; what only auto_reset keeps comes last."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SavedState) and equal(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other


class VectorArena:
    """A batch of arenas in lockstep. B arenas, H hunters in each, D numbers seen by each of them, K targets among them.

    Actions, by the scenario's control:

    - target: (B, H) whole numbers: 0 to hold, or a target's rank in view;
    - velocity: (B, H, 2) numbers in [-1, 1]: linear and angular velocity as fractions of the limits; finite numbers
      out of bounds are clipped;
    - full, or controls that differ by seat: {"cmd_vel": (B, H, 2), "catch": (B, H)}; what a seat's control does not
      read must be legal too, and is ignored.

    Episodes that end begin anew at once (Gymnasium's SAME_STEP autoreset): the observations are then those of the new
    episode, and `infos` keeps those of the old one. With `auto_reset=False` (Gymnasium's DISABLED) an arena that has
    ended stands still, whatever it is told, until `reset` names it.

    Where there is prey, P in each arena that see E numbers, everything that is given or taken for each agent is a dict
    of two arrays, {"hunter": ..., "prey": ...}: actions, the second of which is (B, P, 2) numbers in [-1, 1];
    observations, (B, H, D) and (B, P, E); rewards, (B, H) and (B, P); `final_obs`; and `episode`, whose second part has
    `length`, `return`, `times_caught` and `rank` (1 is who was caught least), all (B, P). Prey that is out keeps its
    row: its actions must be legal, and are ignored.

    `infos` holds, always the same arrays:

    - `action_mask`: (B, H, K + 1) int8, read only: R7.2's mask of ranks; absent under velocity control;
    - `active`, where hunters drop out: (B, H) bool, who has not (R1.7); all play on as under `dropouts="fixed"`;
    - `team_score`, where there are teams: (B, teams) float64, the sums of their scores (R11.1);
    - `prey_active`, where there is prey: (B, P) bool, who is not out (R12.3);
    - with auto_reset, `_final_obs`: (B,) bool, the arenas whose episode ended in this step, and for these `final_obs`
      (B, H, D) float32, the last observations, `final_mask` (B, H, K + 1) int8, their masks (where there are masks),
      and `episode`, a dict with `length` [steps], `return` (rewards summed), `score`, `team_score` (without teams the
      same), `rank` (1 is best, equal scores share it, team-mates too), `contests_won` and `contests_lost`, all (B, H),
      and `verdicts`, (B, H, 11), how often each verdict was met, in the order of `Verdict`. Rows whose episode ended
      earlier keep what they had; all but `_final_obs` and `final_mask` are float32.

    Everything that is returned lies in buffers that the next call fills anew; `copy=True` returns arrays of their
    own. A step allocates no memory, unless actions come in other types than int64 and float32.

    Args:
        scenario: a name or a config.
        num_envs: B.
        num_threads: how many threads play, at least 4096 hunters each (results do not depend on it).
        auto_reset: whether ended episodes begin anew at once.
        copy: whether arrays of their own are returned.
        any_control: whether arenas may differ in their hunters' controls, by `set_controls`; actions have the form of
            full control then.
        overrides: fields of ArenaConfig.

    Raises:
        ConfigError: for an unknown scenario or setting, and numbers and flags that are none.
    """

    def __init__(
        self,
        scenario: str | ArenaConfig = "standard",
        num_envs: int = 1,
        num_threads: int = 1,
        *,
        auto_reset: bool = True,
        copy: bool = False,
        any_control: bool = False,
        **overrides: object,
    ) -> None:
        num_envs = _positive("num_envs", num_envs, _MOST_ENVS)
        num_threads = _positive("num_threads", num_threads, _MOST_THREADS)
        auto_reset = require_flag("auto_reset", auto_reset)
        copy, any_control = require_flag("copy", copy), require_flag("any_control", any_control)
        self.config: Final = arena_config(scenario, **overrides)
        self.num_envs: Final = num_envs
        self.num_hunters: Final = self.config.hunters
        self.num_prey: Final = self.config.prey
        self.auto_reset: Final = auto_reset
        self._copy = copy
        self._kinds: Final = set(CONTROLS if any_control else self.config.controls)
        self._begun = False
        self._converted: dict[str, NDArray[Any]] = {}
        """Room for actions of other types than the engine's, once some have come."""
        try:
            self._engine = Engine(
                self.config,
                num_envs,
                with_infos=False,
                auto_reset=auto_reset,
                num_threads=num_threads,
                any_control=any_control,
            )
            self._terminations, self._truncations, self._ended = (np.zeros(num_envs, dtype=np.bool_) for _ in range(3))
        except MemoryError as error:
            raise ConfigError(f"num_envs must fit into this machine's memory, got {num_envs}: {error}") from None
        self._infos = self._make_infos()

    def _make_infos(self) -> dict[str, Any]:
        engine, infos = self._engine, dict[str, Any]()
        if self._kinds != {"velocity"}:
            infos["action_mask"] = engine.masks.view()
            infos["action_mask"].flags.writeable = False  # the engine writes only what has changed
        if self.config.dropout_rate > 0.0:
            infos["active"] = engine.active
        if self.config.teams is not None:
            infos["team_score"] = engine.team_scores
        if self.num_prey:
            infos["prey_active"] = engine.prey_active
        if engine.auto_reset:
            records, prey_records, lengths = engine.records, engine.prey_records, engine.lengths[:, None]
            tallies = records[:, :, episodes.FINAL_TALLIES : episodes.FINAL_TEAM_SCORE]
            team_score = episodes.FINAL_SCORE if self.config.teams is None else episodes.FINAL_TEAM_SCORE
            infos["_final_obs"] = self._ended
            infos["final_obs"] = self._by_side(engine.final_observations, engine.prey_final_observations)
            if "action_mask" in infos:
                infos["final_mask"] = engine.final_masks
            infos["episode"] = self._by_side(
                {
                    "length": np.broadcast_to(lengths, records.shape[:2]),
                    "return": records[:, :, episodes.FINAL_REWARD_SUM],
                    "score": records[:, :, episodes.FINAL_SCORE],
                    "team_score": records[:, :, team_score],
                    "rank": records[:, :, episodes.FINAL_RANK],
                    "contests_won": records[:, :, episodes.FINAL_CONTESTS_WON],
                    "contests_lost": tallies[:, :, Verdict.LOST_CONTEST - 1],
                    "verdicts": tallies,
                },
                {
                    "length": np.broadcast_to(lengths, prey_records.shape[:2]),
                    "return": prey_records[:, :, prey.PREY_FINAL_REWARD_SUM],
                    "times_caught": prey_records[:, :, prey.PREY_TIMES_CAUGHT],
                    "rank": prey_records[:, :, prey.PREY_RANK],
                },
            )
        return infos

    def _by_side(self, of_hunters: Any, of_prey: Any) -> Any:
        """What is given for each agent: where there is prey, both sides' by their names."""
        return {"hunter": of_hunters, "prey": of_prey} if self.num_prey else of_hunters

    def __repr__(self) -> str:
        prey = f" and {self.num_prey} prey" if self.num_prey else ""
        return (
            f"<VectorArena: {self.num_envs} arenas, {self.num_hunters} hunters{prey} in each, "
            f"{self.config.control} control>"
        )

    def close(self) -> None:
        """End the threads that were started. The arena is as it was, and can be played on."""
        self._engine.threads.close()

    def observation_space(self, seat: int | Literal["hunter", "prey"] = 0) -> spaces.Space[Any]:
        """R7.1: what the hunter of that seat sees; the mask is in `infos`. By side, "hunter": what each hunter
        sees, where all have one control; "prey": what each prey sees (R12.4).
        """
        if seat == "prey":
            self._require_prey()
            return prey_observation_space(self.config)
        return observation_space(self.config.replace(mask_in_observation=False), self._control_of(seat))

    def action_space(self, seat: int | Literal["hunter", "prey"] = 0) -> spaces.Space[Any]:
        """R4.1, R4.4: what the hunter of that seat may do. By side, "hunter": what each hunter may do, where all have
        one control; "prey": what each prey may do (R12.2).
        """
        if seat == "prey":
            self._require_prey()
            return velocity_space()
        return action_space(self.config, self._control_of(seat))

    def _require_prey(self) -> None:
        if not self.num_prey:
            raise ConfigError("seat must be a hunter's in an arena without prey, got 'prey'")

    def _control_of(self, seat: object) -> Control:
        if seat == "hunter":
            if len(set(self.config.controls)) > 1:
                raise ConfigError("seat must be a number where hunters differ in their control, got 'hunter'")
            seat = 0
        number = whole_number(seat)
        if number is None or not 0 <= number < self.num_hunters:
            sides = "'hunter' or 'prey'" if self.num_prey else "or 'hunter'"
            raise ConfigError(f"seat must be a whole number from 0 to {self.num_hunters - 1}, {sides}, got {seat!r}")
        return self.config.controls[number]

    # playing

    def reset(self, seed: int | Iterable[int] | None = None, arenas: ArrayLike | None = None) -> Begun:
        """Begin episodes.

        Args:
            seed: one whole number in [0, 2^64), from which each row's own follows (A.5), or one for each arena; without
                it each arena goes on to the episode after its own, and the first seed is the operating system's.
            arenas: the rows to begin anew, as numbers or as a (B,) mask; all without it.

        Returns:
            observations and infos, see above.

        Raises:
            ConfigError: also for a row that is named twice.
            EpisodeError: for single rows before all have begun.
        """
        chosen = self._rows(arenas)
        if not self._begun and len(chosen) < self.num_envs:
            raise EpisodeError("reset of single arenas must follow a reset of all: no episode has begun")
        if seed is None:
            seeds = (
                batch_seeds(fresh_seed(), self.num_envs)
                if not self._begun
                else next_seeds(self._engine.seeds()[chosen])
            )
        elif isinstance(seed, np.ndarray) and seed.ndim == 1 and seed.dtype == np.uint64:
            seeds = seed  # as `seeds()` gives them
        elif isinstance(seed, Iterable) and not isinstance(seed, str | bytes) and getattr(seed, "ndim", 1) > 0:
            seeds = np.array([checked_seed(one) for one in seed], dtype=np.uint64)
        else:
            seeds = batch_seeds(checked_seed(seed), self.num_envs)[chosen]
        self._engine.reset(seeds, None if arenas is None else chosen)
        self._begun = True
        self._ended[chosen] = False
        return self._begun_with()

    def place(
        self, hunters: ArrayLike, targets: ArrayLike, *, steps: ArrayLike = 0, arenas: ArrayLike | None = None
    ) -> Begun:
        """Begin episodes with these hunters and targets in place of those that the seeds give: for a search that goes
        on from what a hunter sees, and for lessons. All scores are 0. What is drawn from now on follows from the seed
        of the last reset, and from `steps`.

        Args:
            hunters: (n, H, 4), of n arenas: x, y [m], heading [rad], from -1000 to 1000, linear velocity [m/s]. A row
                of NaN takes no part: it stands still, and nobody sees it (R1.6).
            targets: (n, T, 5), T up to max_targets: x, y [m], heading [rad], likewise, linear velocity [m/s] (of
                targets that stand still, 0), age [s]. A row of NaN is no target. They are numbered from 1, the oldest
                first.
            steps: how many have been played, (n,) or one number; the time follows from it, and with that the spawns.
            arenas: the rows, as for `reset`; all without it.

        Returns:
            observations and infos, as `reset`.

        Raises:
            ConfigError: for a body outside the arena, a heading or a velocity beyond its limits, an age above the time
                that has passed, and an arena with prey.
            EpisodeError: before the first reset.
        """
        self._require_begun("place")
        if self.num_prey:
            raise ConfigError(f"place must be called where there is no prey, got {self.num_prey} prey")
        chosen, config = self._rows(arenas), self.config
        hunters = _placed("hunters", hunters, len(chosen), (config.hunters, config.hunters), 4)
        targets = _placed("targets", targets, len(chosen), (0, config.max_targets), 5)
        played, most = np.asarray(steps), (config.time_limit_ms - 1) // config.control_period_ms
        if played.dtype.kind not in "iu" or played.shape not in {(), (len(chosen),)}:
            raise ConfigError(f"steps must be a whole number, or {len(chosen)} of them, got {_named(played)}")
        _require("steps", f"numbers from 0 to {most}", played, (played >= 0) & (played <= most))
        played = np.broadcast_to(played.astype(np.int64), len(chosen))
        fastest = np.array(config.max_speeds)
        self._require_bodies("hunters", hunters, -fastest if config.reverse else 0.0 * fastest, fastest)
        self._require_bodies("targets", targets, 0.0, config.target_speed_mps if config.targets_move else 0.0)
        passed_s = played[:, None] * config.control_period_ms / 1000.0
        young = (targets[:, :, 4] >= 0.0) & (targets[:, :, 4] < passed_s + 0.0005)  # to the millisecond
        _require("targets", "of ages from 0 to the time that has passed", targets, young | np.isnan(targets[:, :, 0]))
        self._engine.place_batch(chosen, hunters, targets, played)
        self._update_ends()
        return self._begun_with()

    def _require_bodies(self, name: str, bodies: NDArray[np.float64], slowest: Any, fastest: Any) -> None:
        x, y, heading, speed = (bodies[:, :, column] for column in range(4))
        absent, side = np.isnan(x), self.config.side_m
        inside = (x >= 0.0) & (x <= side) & (y >= 0.0) & (y <= side)
        _require(name, f"at places in the arena, from 0 to {side} m", bodies, absent | inside)
        headings = f"of headings from {-MAX_HEADING_RAD:g} to {MAX_HEADING_RAD:g} rad"
        _require(name, headings, bodies, absent | (np.abs(heading) <= MAX_HEADING_RAD))
        _require(name, "of velocities within their limits", bodies, absent | ((speed >= slowest) & (speed <= fastest)))

    def _begun_with(self) -> Begun:
        engine = self._engine
        return self._handed_out((self._by_side(engine.observations, engine.prey_observations), dict(self._infos)))

    def step(self, actions: ArrayLike | Mapping[str, Any]) -> Results:
        """R1.4: one step of every arena.

        Args:
            actions: see above.

        Returns:
            observations (B, H, D) float32, rewards (B, H) float32, terminations (B,) and truncations (B,) bool, infos;
            where there is prey, observations and rewards of each side. Without `copy=True` the next call writes into
            the same arrays: copy what you keep.

        Raises:
            ActionError: that names the first arena and agent whose action is not legal; nothing has moved then.
            EpisodeError: before the first reset.
        """
        self._require_begun("step")
        engine = self._engine
        engine.step(*self._checked(actions))
        self._update_ends()
        return self._handed_out(
            (
                self._by_side(engine.observations, engine.prey_observations),
                self._by_side(engine.rewards, engine.prey_rewards),
                self._terminations,
                self._truncations,
                dict(self._infos),
            )
        )

    def check_actions(self, actions: ArrayLike | Mapping[str, Any]) -> None:
        """Raise the ActionError that `step` would raise for these actions; nothing moves."""
        self._checked(actions)

    def set_controls(self, controls: ArrayLike, arenas: ArrayLike | None = None) -> None:
        """R4.1, R4.4: how hunters are driven from now on; the arena plays what a one-arena env of such a config does.

        Args:
            controls: for each of those arenas and each seat 0 (target), 1 (velocity) or 2 (full): (n, H).
            arenas: the rows, as for `reset`; all without it.

        Raises:
            ConfigError: for other numbers, or where the arena was made without `any_control`.
        """
        self._require_any_control()
        chosen, given = self._rows(arenas), np.asarray(controls)
        shape = (len(chosen), self.num_hunters)
        if given.shape != shape or given.dtype.kind not in "iu" or not np.isin(given, list(CONTROLS.values())).all():
            raise ConfigError(f"controls must be {shape} numbers from 0 to 2, got {_named(given)}")
        self._engine.controls[chosen] = given

    def _require_any_control(self) -> None:
        if len(self._kinds) < len(CONTROLS):
            raise ConfigError("any_control must be True for arenas to have controls of their own, got False")

    def _update_ends(self) -> None:
        ends = self._engine.ends
        np.equal(ends, _TERMINATED, out=self._terminations)
        np.equal(ends, _TRUNCATED, out=self._truncations)
        np.logical_or(self._terminations, self._truncations, out=self._ended)

    def _checked(self, actions: Any) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32] | None]:
        """What the engine is handed."""
        if not self.num_prey:
            if isinstance(actions, Mapping) and {"hunter", "prey"} & set(actions):
                raise ActionError(
                    f"actions must be those of the hunters alone where there is no prey, got {_named(actions)}"
                )
            return *self._checked_actions("actions", actions), None
        if not isinstance(actions, Mapping) or set(actions) != {"hunter", "prey"}:
            raise ActionError(f"actions must be a mapping with hunter and prey, got {_named(actions)}")
        hunters = self._checked_actions("actions['hunter']", actions["hunter"])
        return *hunters, self._checked_commands("actions['prey']", actions["prey"], self.num_prey, "prey")

    def _checked_actions(self, what: str, actions: Any) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        controls = self._kinds
        if controls == {"target"}:
            return self._checked_choices(what, actions), _NO_COMMANDS
        if controls == {"velocity"}:
            return _NO_CHOICES, self._checked_commands(what, actions, self.num_hunters)
        if not isinstance(actions, Mapping) or set(actions) != {"cmd_vel", "catch"}:
            raise ActionError(f"{what} must be a mapping with cmd_vel and catch, got {_named(actions)}")
        choices = self._checked_choices("catch", actions["catch"])
        return choices, self._checked_commands("cmd_vel", actions["cmd_vel"], self.num_hunters)

    def _checked_choices(self, what: str, given: Any) -> NDArray[np.int64]:
        ranks = self.config.targets_seen
        choices = _array(what, given, choice_array, 2)
        if choices.dtype.kind not in "iu":
            raise ActionError(f"{what} must be whole numbers, got {_named(given)}")
        self._require_shape(what, choices, (self.num_envs, self.num_hunters))
        if choices.min() < 0 or choices.max() > ranks:
            self._blame(what, f"a whole number from 0 to {ranks}", choices, (choices < 0) | (choices > ranks))
        if choices.dtype == np.int64 and choices.flags.carray:
            return choices
        return self._as_type(what, choices, np.int64)  # every rank fits

    def _checked_commands(self, what: str, given: Any, agents: int, side: str = "hunter") -> NDArray[np.float32]:
        commands = _array(what, given, command_array, 3)
        if commands.dtype.kind not in "fiu":
            raise ActionError(f"{what} must be numbers, got {_named(given)}")
        self._require_shape(what, commands, (self.num_envs, agents, 2))
        if not (commands.min() >= -1.0 and commands.max() <= 1.0):  # false for NaN too
            if not np.isfinite(commands).all():
                illegal = np.any(~np.isfinite(commands), axis=-1)
                self._blame(what, "two finite numbers", commands, illegal, side)
            commands = clipped(commands)
        if commands.dtype == np.float32 and commands.flags.carray:
            return commands
        return self._as_type(what, commands, np.float32)  # rounded

    def _as_type(self, what: str, given: NDArray[Any], dtype: type[Any]) -> NDArray[Any]:
        if what not in self._converted:
            self._converted[what] = np.zeros(given.shape, dtype)
        np.copyto(self._converted[what], given, casting="unsafe")
        return self._converted[what]

    @staticmethod
    def _require_shape(what: str, given: NDArray[Any], shape: tuple[int, ...]) -> None:
        if given.shape != shape:
            raise ActionError(f"{what} must have the shape {shape}, got {given.shape}")

    @staticmethod
    def _blame(
        what: str, requirement: str, given: NDArray[Any], illegal: NDArray[np.bool_], side: str = "hunter"
    ) -> None:
        arena, index = (int(found) for found in np.argwhere(illegal)[0])
        value = given[arena, index].tolist()
        raise ActionError(f"{what} must be {requirement}, got {value} in arena {arena} for {side}_{index}")

    def _handed_out(self, results: T) -> T:
        return cast(T, _copied(results)) if self._copy else results

    def _rows(self, arenas: ArrayLike | None) -> NDArray[np.int64]:
        if arenas is None:
            return np.arange(self.num_envs)
        chosen = np.asarray(arenas)
        if chosen.dtype == np.bool_ and chosen.shape == (self.num_envs,):
            return np.flatnonzero(chosen)
        legal = chosen.ndim == 1 and (chosen.dtype.kind in "iu" or not chosen.size)
        if not legal or (chosen.size and not 0 <= chosen.min() <= chosen.max() < self.num_envs):
            raise ConfigError(
                f"arenas must be row numbers from 0 to {self.num_envs - 1} or a mask of {self.num_envs}, "
                f"got {_named(chosen)}"
            )
        numbers, counts = np.unique(chosen, return_counts=True)
        if len(numbers) < len(chosen):  # which of two seeds is meant?
            raise ConfigError(f"arenas must be different rows, got {numbers[counts > 1][0]} more than once")
        return chosen.astype(np.int64)

    # keeping

    def save(self) -> SavedState:
        """R10.2: the state of all arenas; `restore` takes it back, here or in an arena of equal config and size.

        Raises:
            EpisodeError: before the first reset.
        """
        self._require_begun("save")
        engine = self._engine
        return SavedState(self._config_digest, self.num_envs, engine.controls.copy(), engine.save())

    def restore(self, saved: SavedState) -> Begun:
        """Go on from a saved state, bit for bit, the figures of past episodes included.

        Returns:
            observations and infos, as `reset`.

        Raises:
            ConfigError: for what was not saved from as many arenas of an equal config.
        """
        memory = self._memory_of(saved, self.num_envs, self._engine.controls)
        self._engine.restore(memory)
        self._engine.controls[:] = saved.controls
        self._begun = True
        self._update_ends()
        return self._begun_with()

    def save_row(self, arena: int) -> SavedState:
        """R10.2: the state of one arena, which any row of an arena of equal config can take."""
        arena, engine = self._row("save_row", arena), self._engine
        return SavedState(self._config_digest, None, engine.controls[arena].copy(), engine.save_row(arena))

    def restore_row(self, arena: int, saved: SavedState) -> Begun:
        """Go on, in one arena, from a saved row.

        Returns:
            observations and infos, as `reset`.

        Raises:
            ConfigError: for a row that is not there, and what is no saved row of an equal config.
        """
        arena = self._row("restore_row", arena)
        memory = self._memory_of(saved, None, self._engine.controls[arena])
        self._engine.restore_row(arena, memory)
        self._engine.controls[arena] = saved.controls
        self._update_ends()
        return self._begun_with()

    @cached_property
    def _config_digest(self) -> str:
        return self.config.digest

    def _memory_of(self, saved: SavedState, num_envs: int | None, controls: NDArray[np.int8]) -> NDArray[np.uint8]:
        if not isinstance(saved, SavedState) or saved.config != self._config_digest:
            raise ConfigError("a saved state must come from an arena of equal config, got another's")
        if saved.num_envs != num_envs:
            wanted, got = ("a single row" if size is None else f"{size} arenas" for size in (num_envs, saved.num_envs))
            raise ConfigError(f"a saved state must be one of {wanted} here, got one of {got}")
        memory = require_memory(self._engine, saved.memory, alone=num_envs is None)
        if np.shape(saved.controls) != controls.shape:
            raise ConfigError(f"a saved state must have controls {controls.shape}, got {np.shape(saved.controls)}")
        if (saved.controls != controls).any():
            self._require_any_control()
        return memory

    def clone(self) -> "VectorArena":
        """An arena of its own in the same state, as `copy.deepcopy` makes it too."""
        return copy_module.deepcopy(self)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_infos"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """What was copied or unpickled has infos that show its own engine's arrays."""
        self.__dict__.update(state)
        self._infos = self._make_infos()

    # reading

    def world(self, arena: int) -> World:
        """One arena in the world frame, for people, rendering and tests."""
        return self._engine.world(self._row("world", arena))

    def rulings(self, arena: int) -> tuple[Ruling, ...]:
        """R5.6: one arena's verdicts of the last step; none where a new episode has begun in it."""
        return self._engine.rulings(self._row("rulings", arena))

    def digest(self, arena: int) -> bytes:
        """A.8: eight bytes that stand for one arena's state."""
        return self._engine.digest(self._row("digest", arena))

    def seeds(self) -> NDArray[np.uint64]:
        """The seeds of the episodes under way: (B,). A one-arena env that is reset with one plays the same episode."""
        return self._engine.seeds()

    def _require_begun(self, what: str) -> None:
        if not self._begun:
            raise EpisodeError(f"{what} must follow a reset: no episode has begun")

    def _row(self, what: str, arena: int) -> int:
        self._require_begun(what)
        row = whole_number(arena)
        if row is None or not 0 <= row < self.num_envs:
            raise ConfigError(f"arena must be a row from 0 to {self.num_envs - 1}, got {arena!r}")
        return row


def _positive(name: str, value: object, most: int) -> int:
    number = whole_number(value)
    if number is None or not 1 <= number <= most:
        shown = with_type(value) if number is None else number
        raise ConfigError(f"{name} must be a whole number from 1 to {most}, got {shown}")
    return number


def _placed(name: str, given: ArrayLike, arenas: int, bodies: tuple[int, int], columns: int) -> NDArray[np.float64]:
    """What `place` is given: (arenas, least to most bodies, columns)."""
    try:
        table = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        table = np.zeros(0)
    least, most = bodies
    if table.ndim != 3 or table.shape[::2] != (arenas, columns) or not least <= table.shape[1] <= most:
        count = most if least == most else f"{least} to {most}"
        raise ConfigError(f"{name} must be numbers of the shape ({arenas}, {count}, {columns}), got {_named(given)}")
    return table


def _require(name: str, requirement: str, given: NDArray[Any], legal: NDArray[np.bool_]) -> None:
    """Name the first that is not legal."""
    if not legal.all():
        where = tuple(int(index) for index in np.argwhere(~legal)[0])
        raise ConfigError(f"{name} must be {requirement}, got {given[where].tolist()} at {list(where)}")


def _array(what: str, given: Any, read: Callable[[Any, int], NDArray[Any]], axes: int) -> NDArray[Any]:
    try:
        return read(given, axes)
    except ValueError:
        raise ActionError(f"{what} must be rows of equal length, got {_named(given)}") from None


def _copied(results: Any) -> Any:
    if isinstance(results, tuple):
        return tuple(_copied(result) for result in results)
    if isinstance(results, dict):
        return {key: _copied(value) for key, value in results.items()}
    return results.copy()


def _named(given: object) -> str:
    """What was given, in a few words."""
    if isinstance(given, np.ndarray):
        return f"an array of {given.dtype} of the shape {given.shape}"
    if isinstance(given, Mapping):
        return f"a mapping with {' and '.join(map(str, given)) or 'nothing'}"[:80]
    return f"{given!r}"[:80]
