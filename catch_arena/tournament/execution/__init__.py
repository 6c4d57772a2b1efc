"""A plan is played, block by block, in this process, in many, or on a cluster; nothing here decides what is played."""
