"""Messages and services on a ROS 2 bus, and the back-ends that carry them.

- interfaces: the messages and services as ROS's own definitions, and the tuples that stand for them here.
- graph_names: the names of topics and services.
- bus: the part of a middleware that the arena uses. dds_bus, rosbridge_bus and rclpy_bus: the three back-ends. opening:
  the choice of one.
- ros_types: the types of a package as ROS has them.
- typestore: our types as the library rosbags has them, and their hashes.
- dds_domain: the DDS domain, its discovery, and nodes with Fast DDS in it.
"""
