"""The arena on a ROS 2 bus (docs/ros2.md, docs/ros2_bags.md).

- middleware: messages and services, and what carries them: DDS, rosbridge or rclpy. Nothing of the arena.
- nodes: the arena as a node, and the exercise's two nodes.
- node_tests: the conformance cases asked of somebody else's node, and its grade.
- doctor: what keeps a node from playing.
- bags: recorded matches as bags, and bags of turtlesim read and judged.
"""
