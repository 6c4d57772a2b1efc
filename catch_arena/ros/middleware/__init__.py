"""What is sent on a ROS 2 bus, and over what.

- interfaces: the messages and services as ROS's own definitions, and the tuples that stand for them here.
- rulings: what the arbiter ruled, as a message.
- graph_names: what topics and services are called. names: what the back-ends and the packages are called.
- bus: what the rest uses of a middleware. dds_bus, rosbridge_bus and rclpy_bus: the three back-ends.
- parameters: those of our nodes.
- ros_types: the types of a package as ROS has them.
- typestore: our types as the library rosbags knows types. type_hashes: what tells two definitions of one type apart.
- dds_domain: where DDS looks for other processes. dds_types: messages as it has them. dds_peers: who else is on the
  bus, where that would cause trouble.
"""
