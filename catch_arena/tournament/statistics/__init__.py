"""Figures about the entrants with their uncertainty, from the results of matches (docs/explanation/ratings.md).

- outcomes: the matches of hunters and of prey separately, as arrays.
- standings: the table. ratings: the strength of each entrant. head_to_head: each entrant against each other.
- separation: pairs with a significant difference. sprt: a test of two agents that ends as early as possible.
- intervals: confidence intervals, with tail_probabilities.
"""
