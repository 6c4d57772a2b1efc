"""Bags of rosbag2, the recordings of a ROS 2 bus.

- export: writes a replay as a bag.
- reading: reads a bag. rulings: the arbiter's rulings on its catches. video: a video of it.
"""
