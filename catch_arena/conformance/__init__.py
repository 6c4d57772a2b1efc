"""Conformance cases as data: what the rulebook's arbiter and arena answer in positions that were chosen by hand.

Each .toml file beside this one is a group of cases; docs/conformance.md says how they are read and how to run them.
"""
