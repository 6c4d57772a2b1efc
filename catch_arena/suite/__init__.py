"""A benchmark suite: arenas and opponents, some for training and some held out (docs/howto/suite.md). The cases of the
conformance suite are in conformance/.

The benchmark fixes everything that two papers must have in common to compare their numbers.

- contents: the scenarios, opponents and matches of a suite, frozen under a name with a version.
- tournaments: the tournament of each scenario, set up and played as by the command `tournament`, with a plan that
  gives the measured agent its fixed opponents.
- measures: the figures of an agent, by scenario and over all scenarios, from the stores of its tournaments.
- aggregates: one figure over many scenarios.
"""
