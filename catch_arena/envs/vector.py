"""Many arenas played together: the engine's own arrays, for learners."""

import copy as copy_module
from collections.abc import Iterable
from functools import cached_property
from typing import Any, Final, TypeVar

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import MAX_HEADING_RAD, ArenaConfig, require_flag, require_integer
from catch_arena.core import rows
from catch_arena.core.controllers import CONTROLS
from catch_arena.engine import Engine, SavedState
from catch_arena.engine.engine import NO_CHOICES, NO_COMMANDS
from catch_arena.engine.episode_seeds import batch_seeds, next_seeds
from catch_arena.envs.actions import action_array, array_of, clipped, describe_value
from catch_arena.envs.spaces import action_space, vector_space
from catch_arena.errors import ActionError, ConfigError, EpisodeError
from catch_arena.layout import columns, prey_columns
from catch_arena.scenarios import scenario as arena_config
from catch_arena.seeding import arena_seed, checked_seed
from catch_arena.text import shortened
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_TERMINATED: Final = np.int8(rows.TERMINATED)  # same type as `Engine.ends`, so that NumPy converts nothing
_TRUNCATED: Final = np.int8(rows.TRUNCATED)

T = TypeVar("T")

StepResults = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]
Begun = tuple[NDArray[np.float32], dict[str, Any]]
Bounds = dict[str, tuple[Any, Any]]


class VectorArena:
    """A batch of B arenas in lockstep. Each has N agents: first H hunters by seat, then P prey by index. An observation
    has D numbers and shows K targets.

    Two arrays hold the agents' actions; each may be omitted if no agent reads it:

    - `choices`: (B, H) whole numbers, of hunters under target and full control: 0, or a target's rank in view;
    - `commands`: (B, N, 2) numbers in [-1, 1], of hunters under velocity and full control and of prey: linear and
      angular velocity as fractions of the limits; finite numbers out of bounds are clipped.

    Values that an agent's control does not read must be legal too, and are ignored.

    Observations are (B, N, D) float32. If those of hunters and prey differ in size, zeros fill the shorter ones
    (`observation_space(agent)` has an agent's own size). Rewards are (B, N) float32. Prey that is out keeps its row.

    An arena whose episode ends begins the next one immediately (Gymnasium's SAME_STEP autoreset): the observations are
    then those of the new episode, and `infos` keeps those of the old one. With `auto_reset=False` (Gymnasium's
    DISABLED) an arena that has ended stands still and ignores its actions until `reset` names it.

    `infos` holds these entries, the same arrays in every step:

    - `action_mask`: (B, H, K + 1) int8, read only: R7.2's mask of ranks; absent if no hunter chooses;
    - `active`, if hunters drop out or there is prey: (B, N) bool, False for hunters that dropped out (R1.7) and for
      prey that is out (R12.3); their rows stay, as under `dropouts="fixed"`;
    - `team_score`, if there are teams: (B, teams) float64, the sums of their hunters' scores (R11.1);
    - with auto_reset, `_final_obs`: (B,) bool, the arenas whose episode ended in this step. For these, `final_obs` has
      the last observations, (B, N, D) float32, and `final_mask` their masks, (B, H, K + 1) int8 (if there are masks).
      `episode` is a dict of their records. All agents have `length` [steps], `return` (rewards summed) and `rank` (1 is
      best, counted separately for hunters and prey; equal agents and team-mates share it), each (B, N). Hunters have
      `score`, `team_score` (without teams the same), `contests_won` and `contests_lost`, each (B, H). They also have
      `verdicts`, (B, H, 12), the number of times that each verdict was given, in the order of `Verdict`. Prey has
      `times_caught`, (B, P). Rows of other arenas keep the values of their last episode. All but `_final_obs` and
      `final_mask` are float32.

    All returned arrays lie in buffers that the next call overwrites: do not write into them, since the zeros that fill
    shorter observations are written only once. `copy=True` returns separate arrays. A step allocates no memory, unless
    actions have other types than int64 and float32.

    Args:
        scenario: name of a scenario, or a config.
        num_envs: B, the number of arenas.
        num_threads: number of threads that play, at least 4096 hunters each (results do not depend on it).
        auto_reset: whether an arena whose episode ends begins the next one immediately.
        copy: whether to return separate arrays instead of the buffers.
        any_control: whether arenas may differ in their hunters' controls, by `set_controls`.
        overrides: fields of ArenaConfig.

    Raises:
        ConfigError: for an unknown scenario or setting, and for a number or flag that is not one.
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
        num_envs = require_integer("num_envs", num_envs, 1, 10**9)  # no machine's memory holds more
        num_threads = require_integer("num_threads", num_threads, 1, 4096)
        self.auto_reset: Final = require_flag("auto_reset", auto_reset)
        self._copy, any_control = require_flag("copy", copy), require_flag("any_control", any_control)
        self.config: Final = arena_config(scenario, **overrides)
        self.num_envs: Final = num_envs
        self.num_hunters: Final = self.config.hunters
        self.num_prey: Final = self.config.prey
        kinds = set(CONTROLS if any_control else self.config.controls)
        self._reads_choices: Final = kinds != {"velocity"}
        self._reads_commands: Final = kinds != {"target"} or self.config.prey > 0
        """The two flags: True if some agent reads choices, and if some agent reads commands."""
        self._has_begun = False
        try:
            self._engine = Engine(
                self.config,
                num_envs,
                with_infos=False,
                auto_reset=self.auto_reset,
                num_threads=num_threads,
                any_control=any_control,
            )
            self._rewards = np.zeros(self._engine.rewards.shape, dtype=np.float32)
            self._terminations, self._truncations, self._ended = (np.zeros(num_envs, dtype=np.bool_) for _ in range(3))
        except MemoryError as error:
            raise ConfigError(f"num_envs must fit into this machine's memory, got {num_envs}: {error}") from None

    @cached_property
    def _infos(self) -> dict[str, Any]:
        """Arrays of the infos; a copied or unpickled batch makes them again, from its own engine's arrays."""
        engine, hunters, infos = self._engine, self.num_hunters, dict[str, Any]()
        if self._reads_choices:
            infos["action_mask"] = engine.masks.view()
            infos["action_mask"].flags.writeable = False  # the engine writes only what has changed
        if engine.active.size:
            infos["active"] = engine.active
        if self.config.teams is not None:
            infos["team_score"] = engine.team_scores
        if self.auto_reset:
            records, of_hunters = engine.records, engine.records[:, :hunters]
            tallies = of_hunters[:, :, rows.FINAL_TALLIES : rows.FINAL_TEAM_SCORE]
            team_score = rows.FINAL_SCORE if self.config.teams is None else rows.FINAL_TEAM_SCORE
            infos["_final_obs"] = self._ended
            infos["final_obs"] = engine.final_observations
            if self._reads_choices:
                infos["final_mask"] = engine.final_masks
            infos["episode"] = {
                "length": np.broadcast_to(engine.lengths[:, None], records.shape[:2]),
                "return": records[:, :, rows.FINAL_REWARD_SUM],
                "rank": records[:, :, rows.FINAL_RANK],
                "score": of_hunters[:, :, rows.FINAL_SCORE],
                "team_score": of_hunters[:, :, team_score],
                "contests_won": of_hunters[:, :, rows.FINAL_CONTESTS_WON],
                "contests_lost": tallies[:, :, Verdict.LOST_CONTEST - 1],
                "verdicts": tallies,
            }
            if self.num_prey:
                infos["episode"]["times_caught"] = records[:, hunters:, rows.FINAL_SCORE]
        return infos

    def __repr__(self) -> str:
        prey = f" and {self.num_prey} prey" if self.num_prey else ""
        return (
            f"<VectorArena: {self.num_envs} arenas, {self.num_hunters} hunters{prey} in each, "
            f"{self.config.control} control>"
        )

    def close(self) -> None:
        """Do nothing: the arena holds nothing that must be released, and can still be played."""

    def observation_space(self, agent: int = 0) -> spaces.Box:
        """R7.1, R12.4: return the space of an agent's observations, without masks; `agent` is from 0 to N - 1."""
        table = prey_columns if self._agent(agent) >= self.num_hunters else columns
        return vector_space(table(self.config))

    def action_space(self, agent: int = 0) -> spaces.Space[Any]:
        """R4.1, R4.4, R12.2: return the space of an agent's actions; `agent` is from 0 to N - 1."""
        row = self._agent(agent)
        return action_space(self.config, "velocity" if row >= self.num_hunters else self.config.controls[row])

    def _agent(self, agent: int) -> int:
        return require_integer("agent", agent, 0, self.num_hunters + self.num_prey - 1)

    # playing

    def reset(self, seed: int | Iterable[int] | None = None, arenas: ArrayLike | None = None) -> Begun:
        """Begin episodes and return their first observations and infos.

        Args:
            seed: one whole number in [0, 2^64), from which each row's own seed follows (A.5), or one number for each
                arena. Without a seed, each arena plays the episode after its current one; the operating system gives
                the first.
            arenas: the rows to reset, as numbers or as a (B,) mask; all rows if omitted.

        Returns:
            observations and infos, see `VectorArena`.

        Raises:
            ConfigError: for a seed or row that is not legal, and for a row that is named twice.
            EpisodeError: for single rows before the first reset of all rows.
        """
        chosen = self._rows(arenas)
        if not self._has_begun and len(chosen) < self.num_envs:
            raise EpisodeError("cannot reset single arenas: no episode has begun; call reset() without arenas first")
        if seed is None and self._has_begun:
            seeds = next_seeds(self._engine.seeds()[chosen])
        elif isinstance(seed, Iterable) and not isinstance(seed, str | bytes) and getattr(seed, "ndim", 1) > 0:
            seeds = np.array([checked_seed(one) for one in seed], dtype=np.uint64)
        else:
            seeds = batch_seeds(arena_seed(seed), self.num_envs)[chosen]
        self._engine.reset(seeds, chosen)
        self._ended[chosen] = False  # what the last step ended can be read until the next one
        return self._begun()

    def place(
        self, hunters: ArrayLike, targets: ArrayLike, *, steps: ArrayLike = 0, arenas: ArrayLike | None = None
    ) -> Begun:
        """Begin episodes with the given hunters and targets instead of those that the seeds give: for a search that
        continues from a hunter's observation, and for curricula. All scores are 0. All later draws follow from the seed
        of the last reset, and from `steps`.

        Args:
            hunters: (n, H, 4), for n arenas: x, y [m], heading [rad] from -1000 to 1000, linear velocity [m/s]. A
                hunter with a row of NaN takes no part: it stands still, and no agent sees it (R1.6).
            targets: (n, T, 5), T up to max_targets: x, y [m], heading [rad] from -1000 to 1000, linear velocity [m/s]
                (0 for targets that stand still), age [s]. A row of NaN is no target. Targets are numbered from 1, the
                oldest first.
            steps: number of steps already played, (n,) or one number. The time and the next spawns follow from it.
            arenas: the rows, as for `reset`; all rows if omitted.

        Returns:
            observations and infos, as from `reset`.

        Raises:
            ConfigError: for a body outside the arena, a heading or a velocity beyond its limits, an age above the
                elapsed time, and an arena with prey.
            EpisodeError: before the first reset.
        """
        self._require_begun("place")
        if self.num_prey:
            raise ConfigError(f"place() does not support arenas with prey, and this one has {self.num_prey}")
        chosen, config = self._rows(arenas), self.config
        played, most = array_of(steps), (config.time_limit_ms - 1) // config.control_period_ms
        numbers = played.dtype.kind in "iu" and played.shape in {(), (len(chosen),)}
        if not numbers or not ((played >= 0) & (played <= most)).all():
            raise ConfigError(f"steps must be one or {len(chosen)} numbers from 0 to {most}, got {shortened(steps)}")
        played = np.broadcast_to(played.astype(np.int64), len(chosen))
        elapsed_s = played[:, None] * config.control_period_ms / 1000.0
        oldest = np.nextafter(elapsed_s + 0.0005, 0.0)  # ages are rounded to the millisecond
        place, turn = (0.0, config.side_m), (-MAX_HEADING_RAD, MAX_HEADING_RAD)
        pose: Bounds = {"x": place, "y": place, "a heading": turn}
        of_hunters = pose | {"a velocity": (config.min_speeds, config.max_speeds)}
        moving = config.target_speed_mps if config.targets_move else 0.0
        of_targets = pose | {"a velocity": (0.0, moving), "an age": (0.0, oldest)}
        hunters = _bodies("hunters", hunters, (len(chosen), config.hunters, config.hunters), of_hunters)
        targets = _bodies("targets", targets, (len(chosen), 0, config.max_targets), of_targets)
        self._engine.place_batch(chosen, hunters, targets, played)
        self._ended[chosen] = False  # what the last step ended can be read until the next one
        return self._begun()

    def _begun(self) -> Begun:
        self._has_begun = True
        return self._handed_out((self._engine.observations, dict(self._infos)))

    def step(self, choices: ArrayLike | None = None, commands: ArrayLike | None = None) -> StepResults:
        """R1.4: play one step of every arena.

        Args:
            choices: (B, H), see `VectorArena`.
            commands: (B, N, 2), see `VectorArena`.

        Returns:
            observations (B, N, D) float32, rewards (B, N) float32, terminations (B,) and truncations (B,) bool, infos.
            Without `copy=True` the next call writes into the same arrays: copy the arrays that must last.

        Raises:
            ActionError: names the first arena and agent whose action is not legal; no arena has changed then.
            EpisodeError: before the first reset.
        """
        self._require_begun("step")
        engine = self._engine
        engine.step(self._checked_choices(choices), self._checked_commands(commands))
        np.copyto(self._rewards, engine.rewards, casting="same_kind")
        self._update_ends()
        return self._handed_out(
            (engine.observations, self._rewards, self._terminations, self._truncations, dict(self._infos))
        )

    def check_actions(self, choices: ArrayLike | None = None, commands: ArrayLike | None = None) -> None:
        """Raise the ActionError that `step` would raise for these actions; no arena changes."""
        self._checked_choices(choices)
        self._checked_commands(commands)

    def set_controls(self, controls: ArrayLike, arenas: ArrayLike | None = None) -> None:
        """R4.1, R4.4: set the controls of hunters from now on. An arena then plays as a one-arena env of those
        controls.

        Args:
            controls: 0 (target), 1 (velocity) or 2 (full) for each of those arenas and each seat: (n, H).
            arenas: the rows, as for `reset`; all rows if omitted.

        Raises:
            ConfigError: for other numbers, or if the batch was made without `any_control`.
        """
        self._engine.require_any_control()
        chosen, given = self._rows(arenas), array_of(controls)
        shape = (len(chosen), self.num_hunters)
        if given.shape != shape or given.dtype.kind not in "iu" or not np.isin(given, list(CONTROLS.values())).all():
            raise ConfigError(f"controls must be {shape} numbers from 0 to 2, got {describe_value(controls)}")
        self._engine.controls[chosen] = given

    def _update_ends(self) -> None:
        ends = self._engine.ends
        np.equal(ends, _TERMINATED, out=self._terminations)
        np.equal(ends, _TRUNCATED, out=self._truncations)
        np.logical_or(self._terminations, self._truncations, out=self._ended)

    def _checked_choices(self, given: Any) -> NDArray[np.int64]:
        if given is None and not self._reads_choices:
            return NO_CHOICES
        choices = action_array("choices", given, (self.num_envs, self.num_hunters), whole=True)
        ranks = self.config.targets_seen
        if choices.min() < 0 or choices.max() > ranks:
            illegal = (choices < 0) | (choices > ranks)
            self._raise_illegal("choices", f"a whole number from 0 to {ranks}", choices, illegal)
        return choices if choices.dtype == np.int64 and choices.flags.carray else np.array(choices, np.int64, order="C")

    def _checked_commands(self, given: Any) -> NDArray[np.float32]:
        if given is None and not self._reads_commands:
            return NO_COMMANDS
        commands = action_array("commands", given, (self.num_envs, self.num_hunters + self.num_prey, 2))
        if not (commands.min() >= -1.0 and commands.max() <= 1.0):  # false for NaN too
            finite = np.isfinite(commands)
            if not finite.all():
                self._raise_illegal("commands", "two finite numbers", commands, ~finite.all(axis=-1))
            commands = clipped(commands)
        is_plain = commands.dtype == np.float32 and commands.flags.carray
        return commands if is_plain else np.array(commands, np.float32, order="C")  # rounded to float32

    def _raise_illegal(self, subject: str, requirement: str, given: NDArray[Any], illegal: NDArray[np.bool_]) -> None:
        arena, row = (int(found) for found in np.argwhere(illegal)[0])
        agent = (*self.config.hunter_names, *self.config.prey_names)[row]
        raise ActionError(
            f"{subject} must be {requirement}, got {given[arena, row].tolist()} in arena {arena} for {agent}"
        )

    def _handed_out(self, results: T) -> T:
        return copy_module.deepcopy(results) if self._copy else results

    def _rows(self, arenas: ArrayLike | None) -> NDArray[np.int64]:
        if arenas is None:
            return np.arange(self.num_envs)
        chosen = array_of(arenas)
        if chosen.dtype == np.bool_ and chosen.shape == (self.num_envs,):
            return np.flatnonzero(chosen)
        numbers = chosen.ndim == 1 and (chosen.dtype.kind in "iu" or not chosen.size)
        wrong = chosen[(chosen < 0) | (chosen >= self.num_envs)].tolist() if numbers else [arenas]
        repeated = numbers and len(np.unique(chosen)) < len(chosen)  # it would be unclear which of two seeds is meant
        if wrong or repeated:
            most, got = self.num_envs - 1, shortened(wrong[0] if wrong else chosen.tolist())
            raise ConfigError(f"arenas must be different rows from 0 to {most}, or a mask of {most + 1}, got {got}")
        return chosen.astype(np.int64)

    # saving

    def save(self, arena: int | None = None) -> SavedState:
        """R10.2: return the state of all arenas, which `restore` takes in a batch of equal config and size; or that of
        one arena, which any row of a batch of equal config can take.

        Raises:
            ConfigError: for a row that does not exist.
            EpisodeError: before the first reset.
        """
        self._require_begun("save")
        return self._engine.save(None if arena is None else self._row("save", arena))

    def restore(self, saved: SavedState, arena: int | None = None) -> Begun:
        """Continue from a saved state, bit for bit, in all arenas or in one; the records of past episodes are restored
        too.

        Returns:
            observations and infos, as from `reset`.

        Raises:
            ConfigError: for a row that does not exist, and for anything that `save` of an equal config, and of as many
                arenas or a single one, did not return.
            EpisodeError: for a single arena before the first reset.
        """
        self._engine.restore(saved, None if arena is None else self._row("restore", arena))
        self._update_ends()
        return self._begun()

    def clone(self) -> "VectorArena":
        """Return an independent batch in the same state; `copy.deepcopy` does the same."""
        return copy_module.deepcopy(self)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_infos"}

    # reading

    def world(self, arena: int) -> World:
        """Return one arena in the world frame, for people, rendering and tests."""
        return self._engine.world(self._row("world", arena))

    def rulings(self, arena: int) -> tuple[Ruling, ...]:
        """R5.6: return one arena's rulings of the last step; empty if a new episode has begun in that arena."""
        return self._engine.rulings(self._row("rulings", arena))

    def digest(self, arena: int) -> bytes:
        """A.8: return the digest of one arena's state, eight bytes."""
        return self._engine.digest(self._row("digest", arena))

    def seeds(self) -> NDArray[np.uint64]:
        """Return the seeds of the current episodes, (B,). A one-arena env reset with such a seed plays the same
        episode.
        """
        self._require_begun("seeds")
        return self._engine.seeds()

    def _require_begun(self, method: str) -> None:
        if not self._has_begun:
            raise EpisodeError(f"cannot call {method}(): no episode has begun; call reset() first")

    def _row(self, method: str, arena: int) -> int:
        self._require_begun(method)
        return require_integer("arena", arena, 0, self.num_envs - 1)


def _bodies(name: str, given: ArrayLike, sizes: tuple[int, int, int], bounds: Bounds) -> NDArray[np.float64]:
    """Return an argument of `place` as an array: (arenas, bodies, columns). Rows of NaN are legal.

    `sizes` are the number of arenas, and the least and the greatest number of bodies. `bounds` are the least and the
    greatest value of each column, by its name.
    """
    table, (arenas, least, most) = array_of(given, np.float64), sizes
    if table.ndim != 3 or table.shape[::2] != (arenas, len(bounds)) or not least <= table.shape[1] <= most:
        shape = f"({arenas}, {most if least == most else f'{least} to {most}'}, {len(bounds)})"
        raise ConfigError(f"{name} must be numbers of the shape {shape}, got {describe_value(given)}")
    for column, (words, (low, high)) in zip(table.transpose(2, 0, 1), bounds.items(), strict=True):
        illegal = np.argwhere(~(np.isnan(table[:, :, 0]) | ((column >= low) & (column <= high))))
        if len(illegal):
            at = tuple(illegal[0].tolist())
            lowest, highest = (np.broadcast_to(bound, column.shape)[at] for bound in (low, high))
            raise ConfigError(f"{name} must have {words} from {lowest:g} to {highest:g}, got {column[at]:g} at {[*at]}")
    return table
