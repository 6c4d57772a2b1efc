"""Tournaments: agents play each other in every seat, and are rated by the results.

Folders:
- plans: the matches to play, in stages.
- isolation: agents in their own processes, with limits.
- execution: playing a plan, in this process or in many.
- statistics: figures about the agents, with their uncertainty.

Files, from one match up:
- agent_spec: names of agents on the command line. loading: import of an agent's code. entrants: agents in a tournament.
- parties: teams and single prey, each played by one entrant. match: matches, their results and ranks. players: the
  agents of one match, and agents' inspection. match_loop: playing one match.
- secret: the tournament's secret, and all seeds that follow from it.
- store: played matches.
- export: other files of a tournament.
- agent_check, grading with grading_spec and hints.toml: one agent. comparison: two.

Nothing here draws, prints or reads options: the command line does (cli/).
"""
