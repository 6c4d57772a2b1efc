"""Plans of matches: blocks of seats and seeds, in stages; nothing here plays.

- schedule: the formats, the blocks of each, and the end of a plan. balanced_groups: the entrants of each block.
"""
