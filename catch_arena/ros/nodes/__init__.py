"""Our own nodes.

- arena_node: the arena. serving: one match of it. seats: hunters that nodes drive, and advice for the authors of the
  nodes. agents: the agents in the other seats. neighbours: other nodes that disturb a match.
- controller, spawner: the exercise's two nodes for turtlesim, with an agent and with our arbiter.
- rate: even steps by the wall clock. parameters: what a node is started with.
"""
