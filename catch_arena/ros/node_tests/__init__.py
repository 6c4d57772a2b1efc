"""Tests and grades of nodes of students.

- node_under_test: a node that serves catch_turtle, and its surroundings.
- cases: the conformance cases that a node can be asked, and its grades by a spec.
"""
