"""Execution of a plan, block by block: in this process, in several, or on a cluster. `plans` makes the plan.

- runner: plays a plan, and stores each block. block_queue: submits, collects in order, and plays again.
- executors: play blocks in this process or in several; ray_executor: on a cluster.
- worker: plays the matches of a block.
- cost: time and space that a plan needs. forfeit_streaks: exclusion of entrants that forfeit too often.
"""
