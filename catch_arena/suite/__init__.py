"""A benchmark suite: arenas and opponents, some of which a learner may meet while it trains and others not, with all
that two papers must have in common to compare their numbers (docs/suite.md).

- contents: what is in a suite, frozen under a name with a version.
- evaluation: an agent plays it; each scenario is a tournament in a folder of its own.
- measures: what came out, by scenario and for all of them.
- references: what shipped agents reached, kept with the package.
"""
