"""Agents that come with Catch Arena, one file each; the file's name is the agent's name (docs/reference/agents.md)."""
