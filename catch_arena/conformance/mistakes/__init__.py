"""Which known mistakes explain the cases that failed. `diagnosis` is the only one that the rest of the suite imports.

- `replaceable_rules`: chapter 5 with every rule in a place of its own. `wrong_rules`: others to put there.
- `known_mistakes`: what arbiters are known to do wrong, made of them.
- `search`: those that answer as the code under test did. `diagnosis`: the failures grouped by them.
"""
