"""Plans of matches: blocks of seats and seeds, in stages; nothing here plays.

- schedule: the formats, and the blocks of each; balanced_groups: the entrants of each block.
- until_separated: a plan that goes on until the order of the entrants is clear.
"""
