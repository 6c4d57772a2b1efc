"""Agents in processes of their own, with limits; docs/isolation.md says what that protects against, and what not.

From the match down: seating, isolated_players, pipes; from the tournament's process down: sandbox, supervisor,
fork_server.
"""
