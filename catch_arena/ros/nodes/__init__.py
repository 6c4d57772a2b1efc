"""Nodes of our own.

- arena_node: the arena. serving: one match of it. seats: the hunters that others' nodes drive. agents: those that play
  in the other seats. neighbours: what other nodes do that a player would suffer from.
- controller, spawner: the exercise's two nodes for turtlesim, with an agent and with our arbiter.
- neighbours: what other nodes do that somebody would suffer from.
- ros_args: what --ros-args says at the start. rate: even steps by the wall clock.
"""
