"""The arena on a ROS 2 bus.

`interfaces` says what is sent, as ROS's own definitions; `bus` is what the rest uses of a middleware, and `dds_bus`,
`rosbridge_bus` and `rclpy_bus` are the three that there are.
"""
