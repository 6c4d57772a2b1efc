"""Isolated agents: each in a process of its own, with limits.

- playing: whole matches, with the agents of each seat where they belong.
- isolated_players: asks the agents of a match, and blames the one that fails.
- sandbox: the agents' processes. agent_program: the program in them. protocol: what both say.
- namespaces: the command line that hides everything else from an agent. limits: what an agent may take.
"""
