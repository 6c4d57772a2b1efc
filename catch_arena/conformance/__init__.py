"""Conformance cases as data: what the rulebook's arbiter and arena answer in positions that were chosen by hand.

Each .toml file beside this one is a group of cases; docs/conformance.md says how they are read and how to run them.

- The cases: `cases` says what one is; `case_files` reads and checks the .toml files, with `toml_reader`.
- A run (catch_arena/testing.py begins it): `arbiter_runner` and `arena_runner` play a case; `answers` calls the code
  under test and reads what it returns; `comparison` holds that against what is expected; `results` has what came of
  each case, and `report` of all.
- Why cases failed: `replaceable_rules` is chapter 5 with every rule in a place of its own; `wrong_rules` are others to
  put there, and `mistakes` the known mistakes made of them; `mistake_search` finds those that answer as the code did,
  and `diagnosis` groups the failures by them.
"""
