"""Nodes of others, tried.

- node_under_test: a node that serves catch_turtle, and the arena about it.
- cases: the conformance cases that it can be asked. grading: its grade by a spec.
"""
