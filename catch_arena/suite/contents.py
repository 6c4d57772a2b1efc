"""Contents of the suites: scenarios for training and held-out ones, the opponents in each, and the number of matches.

A suite is frozen under its name, because numbers in papers belong to it. Every change goes into a new version.
"""

import hashlib
import json
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations
from typing import Any, Final

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import ConfigError, suggest
from catch_arena.scenarios import SCENARIOS
from catch_arena.tournament.match import Block
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import Plan, round_robin
from catch_arena.tournament.secret import Secret

TRAINING_OPPONENTS: Final = ("first", "nearest", "contested", "contested_by_time", "patrol")
"""Opponents in scenarios with known opponents. A learner may train against any agent but the held-out ones."""
HELD_OUT_OPPONENTS: Final = ("assignment", "intercept", "spoiler", "tour", "voronoi")
"""Held-out opponents: no learner has met or imitated them, or was selected by its results against them."""
REFERENCES: Final = ("nearest", "contested_by_time", "patrol")
"""Agents whose results are kept with the package (`make card`), for comparison with other agents."""
QUICK_BLOCKS: Final = 2
"""Number of blocks of each scenario for a first look, which is not the protocol."""


@dataclass(frozen=True, slots=True)
class SuiteScenario:
    """One arena of a suite, with the agent's opponents."""

    name: str
    config: ArenaConfig
    opponents: tuple[str, ...]
    """Names of shipped agents, frozen learned ones included. In each block other ones of them fill the seats that the
    agent leaves free.
    """
    held_out: bool
    description: str
    """Short description of what differs from other scenarios."""


@dataclass(frozen=True)
class Suite:
    """Scenarios, and the number of blocks and the seed that are fixed for all of them."""

    name: str
    scenarios: tuple[SuiteScenario, ...]
    blocks: int
    """Blocks of each scenario: one seed each, played in every rotation of its players through the seats."""
    seed: int
    """Seed of all random draws. It is public, so a learner must not train on matches that follow from it."""

    def part(self, *, held_out: bool) -> tuple[SuiteScenario, ...]:
        """Return the scenarios for training, or the held-out ones."""
        return tuple(one for one in self.scenarios if one.held_out == held_out)

    def secret(self, scenario: SuiteScenario) -> Secret:
        """Return the secret from which all seeds of a scenario's matches follow."""
        return Secret.of(self.seed).part("suite", self.scenarios.index(scenario))

    def plan(self, scenario: SuiteScenario, blocks: int) -> Plan:
        """Return the matches of one agent in a scenario: entrant 0 is the agent, the others are its opponents.

        In a block each opponent plays as often as all of them fit in; the remaining parties are a group that changes
        by block. A plan with fewer blocks has the first blocks of a longer plan.
        """
        parties, opponents = Parties.of(scenario.config), range(1, 1 + len(scenario.opponents))
        whole, rest = divmod(len(parties) - 1, len(opponents))
        groups = list(combinations(opponents, rest))
        roles = round_robin(len(parties), parties, blocks, self.secret(scenario))

        def seated(block: Block) -> Block:
            playing = (0, *(*opponents,) * whole, *groups[block[0].block % len(groups)])
            return tuple(replace(match, seating=tuple(playing[role] for role in match.seating)) for match in block)

        # without the number of blocks, so that the matches of a first look are not played again
        parameters = {"format": "suite", "suite": self.name, "scenario": scenario.name}
        return Plan(parameters, roles.size, lambda: map(seated, roles.blocks()))

    @cached_property
    def digest(self) -> str:
        """Digest of all facts of the suite, 16 hexadecimal digits."""
        text = json.dumps(self.facts(), sort_keys=True, separators=(",", ":"))
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()

    def facts(self) -> dict[str, Any]:
        """Return the whole suite as JSON-ready values.

        It has only the settings that differ from `ArenaConfig`'s defaults, so that a new setting changes nothing.
        """
        usual = ArenaConfig().to_dict()
        return {
            "suite": self.name,
            "ruleset": RULESET,
            "blocks": self.blocks,
            "seed": self.seed,
            "scenarios": [
                {
                    "name": one.name,
                    "held_out": one.held_out,
                    "opponents": list(one.opponents),
                    "settings": {name: value for name, value in one.config.to_dict().items() if value != usual[name]},
                }
                for one in self.scenarios
            ],
        }


def _scenario(
    name: str,
    description: str,
    opponents: tuple[str, ...] = TRAINING_OPPONENTS,
    *,
    arena: str | None = None,
    held_out: bool = False,
    **settings: Any,
) -> SuiteScenario:
    """Return a line of the tables below: a shipped scenario, `arena` or else `name`, with changes of its settings.

    Each agent plays under its own control.
    """
    config = SCENARIOS[arena or name].replace(control=ArenaConfig().control, **settings)
    return SuiteScenario(name, config, opponents, held_out, description)


_held_out = partial(_scenario, arena="standard", held_out=True)

SUITE: Final = Suite(
    name="catch_arena_suite_v1",
    scenarios=(
        _scenario("standard", "four hunters in turtlesim's arena"),
        _scenario("duel", "two hunters"),
        _scenario("scarce", "a target every two seconds"),
        _scenario("wander", "targets drive in arcs"),
        _scenario("fog", "hunters see 2.5 m far"),
        _scenario("pairs", "two teams of two"),
        _held_out("strangers", "`standard` against held-out opponents", HELD_OUT_OPPONENTS),
        _held_out(
            "dense",
            "three targets per second, 20 at the start",
            initial_targets=20,
            max_targets=32,
            spawn_frequency_hz=3.0,
        ),
        _held_out(
            "fast",
            "hunters drive 3.5 m/s and turn faster; their reach is shorter",
            max_speed_mps=3.5,
            max_turn_rate_radps=6.0,
            reach_m=0.2,
        ),
        _held_out(
            "triples",
            "two teams of three",
            hunters=6,
            teams=((0, 1, 2), (3, 4, 5)),
            team_share=1.0,
            side_m=14.0,
            initial_targets=12,
            max_targets=24,
            spawn_frequency_hz=1.5,
        ),
        _held_out(
            "wide",
            "a side of 18 m, with few targets",
            HELD_OUT_OPPONENTS,
            side_m=18.0,
            initial_targets=6,
            spawn_frequency_hz=0.8,
        ),
        _held_out(
            "tight",
            "three slow hunters in 7 m",
            HELD_OUT_OPPONENTS,
            hunters=3,
            side_m=7.0,
            max_speed_mps=1.2,
            max_turn_rate_radps=2.5,
            initial_targets=5,
        ),
        _held_out("six", "six hunters in the arena of four", HELD_OUT_OPPONENTS, hunters=6, spawn_frequency_hz=1.5),
        _held_out(
            "lookout",
            "three hunters, targets that flee, and a partial view with errors: 4 m, 200 degrees, 5 cm",
            HELD_OUT_OPPONENTS,
            hunters=3,
            target_motion="flee",
            target_speed_mps=1.2,
            view_radius_m=4.0,
            view_angle_deg=200.0,
            view_noise_m=0.05,
        ),
    ),
    blocks=10,
    seed=1,
)
"""The suite with scripted opponents, which is the usual one."""

LADDER: Final = Suite(
    name="catch_arena_ladder_v1",
    scenarios=(
        _scenario("standard", "four hunters in turtlesim's arena, against scripts"),
        _scenario("partners", "two teams of two, and a catch needs two hunters; against a script", ("together",)),
        _held_out(
            "beginners",
            "`standard` against agents that have learned for a short time",
            tuple(f"ladder.standard_seat_1_{age}k" for age in (0, 62, 111, 157, 203)),
        ),
        _held_out(
            "graduates",
            "`standard` against learned agents",
            (
                *(f"ladder.standard_seat_1_{age}k" for age in (263, 402, 808)),
                "ladder.standard_seat_2_805k",
                "ladder.standard_seat_3_808k",
            ),
        ),
        _held_out(
            "teams",
            "`partners` against learned teams",
            ("ladder.partners_seat_1_2509k", "ladder.partners_seat_2_2514k", "ladder.partners_seat_3_2502k"),
            arena="partners",
        ),
    ),
    blocks=10,
    seed=2,
)
"""The suite with frozen learned opponents in its held-out scenarios."""


def suite_called(name: str | None) -> Suite:
    """Return a suite by its name; without a name, the usual one. Raise ConfigError for an unknown name."""
    suites = {one.name: one for one in (SUITE, LADDER)}
    if name is not None and name not in suites:
        raise ConfigError(f"unknown suite {name!r}: {suggest(name, suites)}")
    return SUITE if name is None else suites[name]
