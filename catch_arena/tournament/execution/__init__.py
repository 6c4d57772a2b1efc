"""A plan is played, block by block, in this process, in many, or on a cluster; nothing here decides what is played.

- runner: plays a plan, and keeps each match. block_queue: blocks side by side, kept in the order of the plan.
- executors: where blocks are played, in this process or in several; ray_executor: on a cluster.
- worker: plays the matches of a block. worker_process: a process with a worker in it.
- cost: what a plan will take. forfeit_streaks: who is excluded. quarantine: who did harm, where a
  block was not played.
"""
