"""What the results say about the entrants, and how sure that is (docs/ratings.md): arrays in, figures out.

- outcomes: the matches as arrays; sides: of hunters and of prey, each by itself.
- standings: the table. ratings: how strong each is. head_to_head: each against each other.
- separation: who can be told apart. sprt: a test of two that ends as soon as it can.
- intervals: how sure a figure is, with tail_probabilities. aggregates: one figure over many scenarios.
"""
