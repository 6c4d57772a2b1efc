"""Bags of rosbag2, the recordings of a ROS 2 bus.

- export: writes a replay as a bag. files: its files.
- reading: reads a bag. contents: its poses and lists. rulings: the arbiter's rulings on them. video: a video of it.
"""
