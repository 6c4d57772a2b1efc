"""The arena on a ROS 2 bus (docs/ros2.md, docs/ros2_bags.md).

What is sent, and over what:
- interfaces: the messages and services as ROS's own definitions, and the tuples that stand for them here.
- type_hashes: what tells two definitions of one type apart. service_events: recorded calls of a service.
- bus: what the rest uses of a middleware. dds_bus, rosbridge_bus and rclpy_bus: the three back-ends.
- parameters, parameter_services: those of our nodes, and how others read and change them. ros_args: how they begin.
- dds_types, dds_peers: messages as DDS has them; who else is on the bus, where that would cause trouble.
- dds_graph: this process as a node of ROS's graph.

The arena, and nodes of our own:
- arena_node: the arena there. serving: one match of it. seats: the hunters that nodes drive. agents: those that play in
  the other seats. rulings: what the arbiter answered, as a message.
- controller, spawner: the exercise's two nodes for turtlesim, with an agent and with our arbiter.
- rate: even steps by the wall clock.

Nodes of others, tried:
- node_under_test: a node that serves catch_turtle, and the arena about it.
- node_cases, node_grading: the conformance cases that it can be asked; a grade by a spec.

Bags:
- bag_files: rosbag2's files. bag_export: a replay becomes a bag. bag_import: a bag is read.
- bag_contents, bag_rulings: what a bag tells of turtlesim, and what the arbiter would have answered. bag_video: a video
  of it.
"""
