"""Tournaments, a room for each question.

Who plays: entrants. How one match goes: match, players; with agents in processes of their own: isolation. What is
played: plans. How all of it is played: execution. What is kept: records. How strong the entrants are, and how sure
that is: statistics. Playing until something is known: sequential. Is the arena fair: fairness. Is one agent fit, and
how good is it: marking. What people see of it: display.
"""
