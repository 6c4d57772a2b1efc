"""The arena on a ROS 2 bus (docs/howto/ros2.md, docs/howto/ros2_bags.md).

- arena_service: the arena by names and Twists, without a bus.
- middleware: topics, messages and services of a match, and the back-ends that carry them: DDS, rosbridge or rclpy.
- nodes: the arena as a node, and the exercise's two nodes.
- node_tests: conformance cases and grades for nodes of students.
- doctor: facts and problems that keep a node from playing.
- bags: export of recorded matches as bags; reading and judging of turtlesim's bags.
"""
