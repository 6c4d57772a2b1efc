"""Execution of a plan, block by block: in this process, in several, or on a cluster. `plans` makes the plan.

- runner: plays a plan, and stores each block, its replays and its logs.
- block_queue: submits, collects in order, plays again, and excludes entrants that forfeit too often.
- executors: play blocks in this process or in several; ray_executor: on a cluster.
- cost: time and space that a plan needs.
"""
