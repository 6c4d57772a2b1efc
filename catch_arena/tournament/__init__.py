"""Tournaments: agents play each other in every seat, and are rated by what came of it.

What is in which folder:
- plans: which matches are played, in which stages.
- isolation: agents in processes of their own, with limits.
- execution: a plan is played, in this process or in many.
- statistics: what the results say about the agents, and how sure that is.

And in which file, from one match up:
- agent_spec: how a word names an agent. loading: an agent's code is imported. entrants: who plays.
- parties: who plays as one, a team or one prey. players, match, match_loop, ranks: one match, how it is played,
  and its result.
- secret: the tournament's secret, and all seeds that follow from it.
- store: what was planned and played. stored_values: what a stored value may be.
- agent_logs, export, standings_files: what is written beside it.
- agent_check, grading with grading_spec: one agent. comparison: two.

Nothing here draws, prints or reads options: the command line does (cli/).
"""
