"""Isolated agents: each in its own process, with limits.

`players` asks them during a match, and finds the faults of each.

- sandbox: the agents' processes. agent_program: the program in them. protocol: the messages between both.
- namespaces: the command line that hides the rest of the machine from an agent. quotas: limits of an agent.
"""
