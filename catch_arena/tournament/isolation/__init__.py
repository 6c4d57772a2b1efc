"""Agents in processes of their own, with limits; docs/isolation.md says what that protects against, and what not.

From the match down: playing, starting, isolated_players, pipes, protocol. From the tournament's process down: sandbox,
supervisor, servers, fork_server. Namespaces: levels, namespaces, visible_files. Limits: limits, processes,
forbidden_calls, control_groups, group_watch. Before play: inspecting asks agents what they are. Harm is found by apart,
with freezer and newcomers. What strangers wrote to is emptied by folders.
"""
