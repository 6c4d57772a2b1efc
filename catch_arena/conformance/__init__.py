"""Conformance cases as data: the rulebook's answers in positions that were chosen by hand.

Each file of the folder cases/ is a group of cases; docs/reference/conformance_cases.md explains their format.

- The cases: `cases` defines their fields, and reads the .toml files.
- A run (catch_arena/testing.py starts it): `arbiter_runner` and `arena_runner` play a case;
  `adjudicator_calls` calls the code under test and reads its rulings; `comparison` compares them with the expected
  ones; `results` has the result of each case, and the causes of failures by the table mistakes.toml; `report` has the
  results of all cases as text.
"""
