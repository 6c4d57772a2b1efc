"""A plan is played, block by block, in this process, in several, or on a cluster; the plan itself is made elsewhere.

- runner: plays a plan, and stores each block. block_queue: submits, collects in order, and plays again.
- executors: where blocks are played, in this process or in several; ray_executor: on a cluster.
- worker: plays the matches of a block.
- cost: what a plan will take. forfeit_streaks: which entrants are excluded.
"""
