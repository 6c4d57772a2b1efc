"""Isolated agents: each in its own process, with limits.

- playing: whole matches, with trusted and isolated agents.
- isolated_players: asks the agents of a match, and finds the faults of each.
- sandbox: the agents' processes. agent_program: the program in them. protocol: the messages between both.
- namespaces: the command line that hides the rest of the machine from an agent. quotas: limits of an agent.
"""
