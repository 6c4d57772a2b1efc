"""Tournaments, a module for each question.

Who plays: entrants. What is played: schedule. How one match goes: match. How all of them go: runner. What came out:
standings, results.
"""
