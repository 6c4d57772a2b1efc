"""Which matches are played: blocks of seats and seeds, in stages; nothing here plays.

- schedule: the formats, and the blocks of each; balanced_groups: who is in a block together.
- until_separated: a plan that goes on until the order is clear.
"""
