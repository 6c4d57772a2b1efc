"""Conformance cases as data: what the rulebook's arbiter and arena answer in positions that were chosen by hand.

Each file of the folder cases/ is a group of them; docs/conformance.md says how they are read and how to run them.

- The cases: `cases` says what one is; `case_files` reads and checks the .toml files.
- A run (catch_arena/testing.py begins it): `arbiter_runner` and `arena_runner` play a case; `answers` calls the code
  under test and reads what it returns; `comparison` holds that against what is expected; `results` has what came of
  each case, and `report` of all.
- Why cases failed: `diagnosis`, by the table mistakes.toml.
"""
