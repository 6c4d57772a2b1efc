"""Tests and grades of nodes that other people wrote.

- node_under_test: a node that serves catch_turtle, and its surroundings.
- cases: the conformance cases that it can be asked. grading: its grade by a spec.
"""
